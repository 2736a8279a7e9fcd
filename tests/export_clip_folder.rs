//! What a finished clip leaves: the record as NumPy reads it, videos frame by frame, pictures.
#![cfg(feature = "engine")]
#![expect(clippy::unwrap_used, reason = "a failure in a helper fails the test")]

use std::{path::Path, process::Command};

use agenticfocus::{
    clip::{CameraSpec, ClipFlag, ClipInfo, FrameIndex, FrameRow, Rotation},
    export::{
        ExportError, Record, RecordDescription, RecordMeta, VideoQuality, VideoWriter, object_crop,
        video_facts, write_mask,
    },
    geometry::{PerSide, Pinhole, Pose, Position, Side, Size},
    hands::{HandFrame, HandState, HandTrack},
    image::{Mask, Rgb8},
    retarget::{CameraMap, Method, RobotMotion, SideReport},
    robot::JointAngles,
};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

const ROWS: usize = 5;

fn info() -> ClipInfo {
    let size = Size::new(64, 48);
    let row = |k: u32| FrameRow {
        index: FrameIndex(k),
        pts: f64::from(k) / 30.0,
        source_frame: k,
        source_pts: 0.0,
        stored: k,
    };
    ClipInfo {
        path: "/somewhere/clip.mp4".into(),
        hash: "00".into(),
        codec: "h264".into(),
        size,
        decoded_size: size,
        rotate: Rotation::Deg0,
        intrinsics: Pinhole::new(50.0, 51.0, 32.0, 24.0, size).unwrap(),
        intrinsics_source: CameraSpec::Unknown,
        source_fps: 30.0,
        source_frames: ROWS as u32,
        frame_table: (0..ROWS as u32).map(row).collect(),
        flags: vec![ClipFlag::DefaultIntrinsics],
        messages: Vec::new(),
    }
}

/// A robot whose virtual camera sits at (0.06, 0.02, 0.43) and looks along the torso's x axis.
fn motion() -> RobotMotion {
    let rotation = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let map = CameraMap { beta: 0.8, rotation, offset: Vector3::new(0.06, 0.02, 0.43) };
    let report = |row: usize| {
        let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, row as f64);
        let pose = Isometry3::from_parts(Vector3::new(0.56, 0.12, 0.03).into(), turn);
        SideReport {
            driven: true,
            target: Pose::new(pose),
            reached: Pose::new(pose),
            fingertips: [Position::new(Vector3::new(0.56, 0.12, 0.03)); 5],
            error_position: 0.0,
            error_rotation: 0.0,
            limit_margin: 0.2,
            reachable: true,
            contact: 0.5,
        }
    };
    let angles = |row: usize| JointAngles(std::array::from_fn(|j| (row + j) as f64 * 0.01));
    RobotMotion {
        method: Method::Ours,
        raw_angles: Vec::new(),
        map,
        alpha: 0.7,
        angles: (0..ROWS).map(angles).collect(),
        sides: PerSide::from_fn(|_| (0..ROWS).map(report).collect()),
    }
}

fn hands() -> HandTrack {
    let seen = HandFrame { state: HandState::Observed, confidence: 0.9, ..HandFrame::invalid() };
    let mut hands: PerSide<Vec<HandFrame>> = PerSide::from_fn(|_| vec![seen.clone(); ROWS]);
    hands[Side::Right][2] = HandFrame::invalid();
    HandTrack { hands, hand_length: PerSide::default(), backend: "test".into() }
}

fn record() -> Record {
    Record::from_motion(&motion(), &hands(), &info(), &[[0.0, 1.5]; 12]).unwrap()
}

#[test]
fn the_record_speaks_of_the_virtual_camera_and_of_the_next_state() {
    let record = record();
    record.check().unwrap();
    // 0.5 m ahead of the camera, 0.1 m to its left, 0.4 m below it.
    for (found, expected) in record.wrist_cam[0][0].iter().zip([-0.1, 0.4, 0.5]) {
        assert!((found - expected).abs() < 1e-12);
    }
    assert!((record.fingertips_cam[3][1][4][2] - 0.5).abs() < 1e-12);
    let (state, action) = (record.state(), record.action());
    assert_eq!(state[1..], action[..ROWS - 1]);
    assert_eq!(state[ROWS - 1], action[ROWS - 1]);
    assert!((record.hand_cmd[1][0] - 0.15 / 1.5).abs() < 1e-12);
    assert_eq!(record.hand_valid[2], [true, false]);
    assert!(record.ik_error_pos[2][1].is_nan() && record.target_wrist_torso[2][1][0].is_nan());
    // Quaternions of neighbouring rows never jump to the other hemisphere.
    for pair in record.wrist_torso.windows(2) {
        let dot: f64 = (3..7).map(|i| pair[0][0][i] * pair[1][0][i]).sum();
        assert!(dot > 0.0);
    }
}

#[test]
fn a_record_that_is_out_of_step_or_not_finite_is_refused() {
    let mut short = record();
    short.contact.pop();
    assert!(matches!(short.check(), Err(ExportError::WrongLength { name: "contact", .. })));
    let mut broken = record();
    broken.arm_q[3][1] = f64::NAN;
    assert!(matches!(broken.check(), Err(ExportError::NotFinite { name: "arm_q", row: 3 })));
    let mut broken = record();
    broken.ik_error_pos[1][0] = f64::NAN;
    assert!(matches!(broken.check(), Err(ExportError::NotFinite { name: "ik_error_pos", row: 1 })));
    let mut tracks = hands();
    tracks.hands.left.pop();
    assert!(Record::from_motion(&motion(), &tracks, &info(), &[[0.0, 1.5]; 12]).is_err());
}

#[test]
fn the_record_has_the_same_bytes_every_time_and_numpy_reads_all_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.npz");
    record().write_npz(&path).unwrap();
    let first = std::fs::read(&path).unwrap();
    record().write_npz(&path).unwrap();
    assert_eq!(first, std::fs::read(&path).unwrap());
    let meta = RecordMeta { id: "clip".into(), task: "test".into(), ..RecordMeta::default() };
    let json = folder.path().join("record.json");
    RecordDescription::new(&record(), &info(), &meta).write(&json).unwrap();
    let back: RecordDescription = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert_eq!((back.rows, back.state.len(), back.arrays.len()), (ROWS, 26, 22));
    assert_eq!(back.state[14], "left_thumb");

    let script = "import sys, json, numpy as np
d = np.load(sys.argv[1]); n = 5
want = dict(timestamp=(n,), frame_index=(n,), arm_q=(n,14), hand_q=(n,12), hand_cmd=(n,12), state=(n,26),
  action=(n,26), wrist_cam=(n,2,7), wrist_torso=(n,2,7), target_wrist_torso=(n,2,7), fingertips_cam=(n,2,5,3),
  ik_error_pos=(n,2), ik_error_rot=(n,2), hand_valid=(n,2), hand_confidence=(n,2), contact=(n,2), fps=(),
  beta=(), alpha=(), R_cam=(3,3), T_offset=(3,), K=(3,3))
assert sorted(d.files) == sorted(want), d.files
kinds = dict(frame_index='<i8', hand_valid='|b1')
for name, shape in want.items():
    assert d[name].shape == shape, (name, d[name].shape)
    assert d[name].dtype == np.dtype(kinds.get(name, '<f8')), (name, d[name].dtype)
notes = json.load(open(sys.argv[2]))['arrays']
assert all(tuple(notes[k]['shape']) == d[k].shape for k in want)
assert (d['action'][:-1] == d['state'][1:]).all() and d['fps'] == 30 and d['K'][0,2] == 32
assert d['R_cam'][0,2] == 1 and d['R_cam'][1,0] == -1
print('read')";
    let venv = [".deps/venv/bin/python", "../../deps/venv/bin/python"].map(|path| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        path.to_string_lossy().into_owned()
    });
    for python in venv.iter().map(String::as_str).chain(["python3"]) {
        let has_numpy = Command::new(python).args(["-c", "import numpy"]).output();
        if !has_numpy.is_ok_and(|output| output.status.success()) {
            continue;
        }
        let output = Command::new(python).args(["-c", script]).arg(&path).arg(&json).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        return;
    }
    println!("skipped reading by NumPy: no Python that has it");
}

fn gradient(size: Size, seed: u32) -> Rgb8 {
    let mut frame = Rgb8::new(size);
    for y in 0..size.height {
        for x in 0..size.width {
            frame.set_pixel(x, y, [(x * 2 + seed) as u8, (y * 2) as u8, 120]);
        }
    }
    frame
}

fn write_video(path: &Path, size: Size, frames: u32) {
    let mut video = VideoWriter::create(path, size, VideoQuality::Final).unwrap();
    for seed in 0..frames {
        video.push(&gradient(size, seed)).unwrap();
    }
    video.finish().unwrap();
}

#[test]
fn videos_hold_exactly_what_was_pushed_in_true_colours() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a.mp4"), folder.path().join("b.mp4"));
    let size = Size::new(101, 77);
    write_video(&a, size, 40);
    write_video(&b, size, 40);
    assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
    let facts = video_facts(&a).unwrap();
    assert_eq!((facts.frames, facts.size, facts.rate.as_str()), (40, Size::new(102, 78), "30/1"));

    use agenticfocus::{
        clip::{ClipRequest, FrameSource, open},
        progress::Unwatched,
    };
    let clip = open(&ClipRequest::new(&a), folder.path(), &Unwatched).unwrap();
    assert_eq!((clip.frame_count(), clip.info.flags.as_slice()), (40, &[ClipFlag::DefaultIntrinsics][..]));
    let (frame, wanted) = (clip.frame(FrameIndex(7)).unwrap(), gradient(size, 7));
    let (mut sum, mut count) = (0.0, 0.0);
    for y in 0..size.height {
        for x in 0..size.width {
            for (a, b) in frame.pixel(x, y).into_iter().zip(wanted.pixel(x, y)) {
                sum += f64::from(a.abs_diff(b));
                count += 1.0;
            }
        }
    }
    assert!(sum / count < 2.0, "mean difference {}", sum / count);
}

#[test]
fn a_video_that_fails_or_is_dropped_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mp4");
    let size = Size::new(64, 48);
    let mut video = VideoWriter::create(&path, size, VideoQuality::Final).unwrap();
    assert!(matches!(video.push(&Rgb8::new(Size::new(2, 2))), Err(ExportError::WrongSize { .. })));
    drop(video);
    assert!(VideoWriter::create(&path, size, VideoQuality::Final).unwrap().finish().is_err());
    assert!(!path.exists());
    let nowhere = folder.path().join("missing/a.mp4");
    let mut video = VideoWriter::create(&nowhere, size, VideoQuality::Final).unwrap();
    let pushed = (0..200).try_for_each(|_| video.push(&Rgb8::new(size)));
    let error = pushed.and_then(|()| video.finish()).unwrap_err().to_string();
    assert!(error.contains("No such file"), "{error}");
}

#[test]
fn masks_and_crops_become_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let size = Size::new(20, 10);
    let mask = Mask::from_fn(size, |x, y| (5..9).contains(&x) && (2..6).contains(&y));
    let path = folder.path().join("m.png");
    write_mask(&path, &mask).unwrap();
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap())).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut data).unwrap();
    assert_eq!(data, mask.data());
    let crop = object_crop(&gradient(size, 0), &mask, 1.0).unwrap();
    assert_eq!(crop.size(), Size::new(6, 6));
    assert_eq!((crop.pixel(0, 0)[3], crop.pixel(1, 1)[3]), (0, 255));
    assert!(object_crop(&gradient(size, 0), &Mask::new(size), 1.0).is_none());
}
