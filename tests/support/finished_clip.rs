//! A finished clip's folder as a batch leaves it, without running one.
#![allow(dead_code, clippy::unwrap_used, reason = "each test uses its part; a failing unwrap fails the test")]

use std::{fs, path::Path};

use agenticfocus::{
    clip::FrameIndex,
    export::{Record, VideoQuality, VideoWriter, write_mask, write_npz},
    geometry::Size,
    image::{Mask, Rgb8},
    robot::{ARM_DOF, HAND_DOF},
};
use serde_json::json;

/// What a clip is made like.
pub struct Made<'a> {
    pub id: &'a str,
    pub task: &'a str,
    pub frames: usize,
    pub size: Size,
    /// Stands in `done.json`: another one is another run.
    pub key: &'a str,
    pub review: serde_json::Value,
}

impl Default for Made<'_> {
    fn default() -> Self {
        Self {
            id: "clip",
            task: "move the cup",
            frames: 7,
            size: Size::new(64, 48),
            key: "first",
            review: json!({ "state": "unreviewed" }),
        }
    }
}

/// The masks of a frame: empty, full, and with a hole and several parts in turn.
pub fn masks(size: Size, frame: usize) -> [Mask; 2] {
    let object = Mask::from_fn(size, |x, y| match frame % 3 {
        0 => false,
        1 => true,
        _ => (x % 16 < 8 && y % 12 < 6) && !(x % 16 == 3 && y % 12 == 2),
    });
    let hand = Mask::from_fn(size, |x, y| frame % 3 == 2 && x + y > 40);
    [object, hand]
}

/// Writes the folder `out/id`.
pub fn finished(out: &Path, made: &Made<'_>) {
    let folder = out.join(made.id);
    for name in ["masks/object", "masks/hand"] {
        fs::create_dir_all(folder.join(name)).unwrap();
    }
    let mut record = Record::default();
    let mut video =
        VideoWriter::create(&folder.join("composite.mp4"), made.size, VideoQuality::Final).unwrap();
    for frame in 0..made.frames {
        let turn = |column: usize| (0.1 * frame as f64 + column as f64 + made.id.len() as f64).sin();
        record.timestamp.push(frame as f64 / 30.0);
        record.frame_index.push(frame as i64);
        record.arm_q.push(std::array::from_fn::<f64, ARM_DOF, _>(turn));
        record.hand_q.push([0.5; HAND_DOF]);
        record.hand_cmd.push(std::array::from_fn::<f64, HAND_DOF, _>(|column| 0.5 + 0.5 * turn(column)));
        record.wrist_cam.push([[0.0; 7]; 2]);
        record.wrist_torso.push([[0.0; 7]; 2]);
        record.target_wrist_torso.push([[0.0; 7]; 2]);
        record.fingertips_cam.push([[[0.0; 3]; 5]; 2]);
        record.ik_error_pos.push([0.0; 2]);
        record.ik_error_rot.push([0.0; 2]);
        record.hand_valid.push([true; 2]);
        record.hand_confidence.push([1.0; 2]);
        record.contact.push([0.0; 2]);
        let grey = (20 * frame) as u8;
        video.push(&Rgb8::from_data(made.size, [grey, 90, 200].repeat(made.size.area())).unwrap()).unwrap();
        for (layer, mask) in ["object", "hand"].into_iter().zip(masks(made.size, frame)) {
            let name = format!("masks/{layer}/{:06}.png", FrameIndex(frame as u32).0);
            write_mask(&folder.join(name), &mask).unwrap();
        }
    }
    video.finish().unwrap();
    write_npz(&folder.join("record.npz"), &record.arrays()).unwrap();
    let pinhole = json!({ "fx": 50.0, "fy": 50.0, "cx": 32.0, "cy": 24.0, "size": made.size });
    write(
        &folder.join("record.json"),
        &json!({
            "version": 1, "rows": made.frames, "fps": 30.0, "sides": ["left", "right"], "arm_joints": [],
            "hand_actuators": [], "state": [], "action": "", "frames": {}, "arrays": {},
            "clip": { "file": "clip.mp4", "hash": "00ff", "source_fps": 30.0, "rotate": 0, "intrinsics": pinhole,
                "intrinsics_known": true, "flags": [], "source_frame": (0..made.frames).collect::<Vec<_>>() },
            "id": made.id, "task": made.task, "backends": { "hands": "mediapipe" }, "versions": {}, "parameters": {},
        }),
    );
    write(&folder.join("report.json"), &json!({ "document": { "review": made.review } }));
    write(&folder.join("done.json"), &json!({ "id": made.id, "exit": "done", "inputs": made.key }));
}

fn write(path: &Path, value: &serde_json::Value) {
    fs::write(path, serde_json::to_vec(value).unwrap()).unwrap();
}
