//! `record.json`: what the arrays of the record mean and how they were made.

use std::{collections::BTreeMap, path::Path};

use serde::{Deserialize, Serialize};

use super::Record;
use crate::{
    clip::{ClipFlag, ClipInfo, Rotation},
    export::{ExportError, write_json},
    geometry::{Pinhole, Side},
    robot::{ARM_JOINTS, HAND_ACTUATORS},
};

/// What the pipeline knows and the arrays do not say.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordMeta {
    /// The clip's id.
    pub id: String,
    /// What is done, in words.
    pub task: String,
    /// Which back end made which artifact, for example `hands` → `mediapipe`.
    pub backends: BTreeMap<String, String>,
    /// Versions of the program and of what it used.
    pub versions: BTreeMap<String, String>,
    /// Parameters of the stages.
    pub parameters: BTreeMap<String, serde_json::Value>,
}

/// The clip behind a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordClip {
    /// File name, without folders: they differ between machines.
    pub file: String,
    /// BLAKE3 of the file, hexadecimal.
    pub hash: String,
    /// Mean frame rate of the source, Hz.
    pub source_fps: f64,
    /// Turn that was applied.
    pub rotate: Rotation,
    /// The camera.
    pub intrinsics: Pinhole,
    /// Whether the camera is known, or a default.
    pub intrinsics_known: bool,
    /// What is noteworthy.
    pub flags: Vec<ClipFlag>,
    /// The frame of the source behind each row.
    pub source_frame: Vec<u32>,
}

/// One array of the record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArrayNote {
    /// Shape.
    pub shape: Vec<usize>,
    /// NumPy type.
    pub dtype: String,
    /// Unit.
    pub unit: String,
}

/// The content of `record.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordDescription {
    /// Version of this layout.
    pub version: u32,
    /// Rows of the record, frames of the video.
    pub rows: usize,
    /// Rows a second.
    pub fps: f64,
    /// Order of the sides.
    pub sides: [String; 2],
    /// Names of the columns of `arm_q`.
    pub arm_joints: Vec<String>,
    /// Names of the columns of `hand_q` and `hand_cmd`, the hardware's motor order.
    pub hand_actuators: Vec<String>,
    /// Names of the columns of `state` and `action`.
    pub state: Vec<String>,
    /// What action means.
    pub action: String,
    /// Frames of reference.
    pub frames: BTreeMap<String, String>,
    /// The arrays.
    pub arrays: BTreeMap<String, ArrayNote>,
    /// The clip.
    pub clip: RecordClip,
    /// What else is known.
    #[serde(flatten)]
    pub meta: RecordMeta,
}

impl RecordDescription {
    /// Describes `record` of the clip `info`.
    pub fn new(record: &Record, info: &ClipInfo, meta: &RecordMeta) -> Self {
        let names = |parts: &[&str], suffix: &str| -> Vec<String> {
            let side_names = |side: Side| parts.iter().map(move |part| (side, part));
            let all = Side::BOTH.into_iter().flat_map(side_names);
            all.map(|(side, part)| format!("{}_{part}{suffix}", side.name())).collect()
        };
        let (arm_joints, hand_actuators) = (names(&ARM_JOINTS, "_joint"), names(&HAND_ACTUATORS, ""));
        let notes = record.arrays().into_iter().map(|array| {
            let (dtype, unit) = (array.data.dtype().to_owned(), array.unit.to_owned());
            (array.name.to_owned(), ArrayNote { shape: array.shape, dtype, unit })
        });
        let file = info.path.file_name().map(|name| name.to_string_lossy().into_owned());
        Self {
            version: 1,
            rows: record.len(),
            fps: crate::clip::STANDARD_FPS,
            sides: Side::BOTH.map(|side| side.name().to_owned()),
            state: arm_joints.iter().chain(&hand_actuators).cloned().collect(),
            arm_joints,
            hand_actuators,
            action: "action[t] = state[t + 1], last row repeated".to_owned(),
            frames: frames(),
            arrays: notes.collect(),
            clip: RecordClip {
                file: file.unwrap_or_default(),
                hash: info.hash.clone(),
                source_fps: info.source_fps,
                rotate: info.rotate,
                intrinsics: info.intrinsics,
                intrinsics_known: !info.has(ClipFlag::DefaultIntrinsics),
                flags: info.flags.clone(),
                source_frame: info.frame_table.iter().map(|row| row.source_frame).collect(),
            },
            meta: meta.clone(),
        }
    }

    /// Writes `record.json`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ExportError> {
        write_json(path, self)
    }
}

fn frames() -> BTreeMap<String, String> {
    let notes = [
        ("torso", "torso_link: x forward, y left, z up, metres"),
        ("cam", "the robot's virtual camera (R_cam, T_offset in torso): OpenCV axes, unscaled robot metres"),
        ("wrist", "origin of {side}_base_link, axes of {side}_wrist_yaw_link"),
        ("pose", "x y z metres, then quaternion w x y z"),
        ("unknown", "target_wrist_torso and ik_error_* are NaN where hand_valid is false"),
    ];
    notes.into_iter().map(|(name, note)| (name.to_owned(), note.to_owned())).collect()
}
