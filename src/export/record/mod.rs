//! The synchronised action/state record: `record.npz` and `record.json`.

mod build;
mod describe;
mod npz;

use nalgebra::{Matrix3, Vector3};

pub use build::HandLimits;
pub use describe::{ArrayNote, RecordClip, RecordDescription, RecordMeta};
pub use npz::{ArrayData, NamedArray, write_npz};

use super::ExportError;
use crate::robot::{ACTUATED_DOF, ARM_DOF, HAND_DOF};

/// One row a frame at 30 FPS. Sides are ordered left, right; poses are `x y z qw qx qy qz` in
/// metres. The wrist frame has its origin in `{side}_base_link` and the axes of
/// `{side}_wrist_yaw_link`; `cam` is the robot's virtual camera (OpenCV axes, unscaled robot metres).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// Seconds from the first frame.
    pub timestamp: Vec<f64>,
    /// Index on the standard timeline.
    pub frame_index: Vec<i64>,
    /// Arm joints, radians.
    pub arm_q: Vec<[f64; ARM_DOF]>,
    /// Hand joints, radians.
    pub hand_q: Vec<[f64; HAND_DOF]>,
    /// Hand commands, 0 open to 1 closed.
    pub hand_cmd: Vec<[f64; HAND_DOF]>,
    /// Reached wrist in the virtual camera.
    pub wrist_cam: Vec<[[f64; 7]; 2]>,
    /// Reached wrist in the torso frame.
    pub wrist_torso: Vec<[[f64; 7]; 2]>,
    /// Wanted wrist in the torso frame; NaN where no hand drove the side.
    pub target_wrist_torso: Vec<[[f64; 7]; 2]>,
    /// Reached fingertips in the virtual camera, thumb to pinky, metres.
    pub fingertips_cam: Vec<[[[f64; 3]; 5]; 2]>,
    /// Wrist distance to target, metres; NaN where no hand drove the side.
    pub ik_error_pos: Vec<[f64; 2]>,
    /// Wrist angle to target, radians; NaN where no hand drove the side.
    pub ik_error_rot: Vec<[f64; 2]>,
    /// Whether a known human hand drove the side.
    pub hand_valid: Vec<[bool; 2]>,
    /// Trust in the human hand, 0 to 1.
    pub hand_confidence: Vec<[f64; 2]>,
    /// Contact of thumb and fingers, 0 to 1.
    pub contact: Vec<[f64; 2]>,
    /// Scale β of the camera-relative map.
    pub beta: f64,
    /// Smoothing α.
    pub alpha: f64,
    /// Rotation of the camera-relative map.
    pub r_cam: Matrix3<f64>,
    /// Offset of the camera-relative map, metres.
    pub t_offset: Vector3<f64>,
    /// Camera matrix of the clip.
    pub k: Matrix3<f64>,
}

impl Record {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.timestamp.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.timestamp.is_empty()
    }

    /// `arm_q ++ hand_cmd`, one a row.
    pub fn state(&self) -> Vec<[f64; ACTUATED_DOF]> {
        let rows = self.arm_q.iter().zip(&self.hand_cmd);
        rows.map(|(arms, hands)| {
            let mut row = [0.0; ACTUATED_DOF];
            row[..ARM_DOF].copy_from_slice(arms);
            row[ARM_DOF..].copy_from_slice(hands);
            row
        })
        .collect()
    }

    /// `action[t] = state[t + 1]`, the last row repeated.
    pub fn action(&self) -> Vec<[f64; ACTUATED_DOF]> {
        let mut rows = self.state();
        if !rows.is_empty() {
            let last = rows.len() - 1;
            rows.copy_within(1.., 0);
            // After the shift the last two rows are equal, as they should be.
            debug_assert!(last == 0 || rows[last] == rows[last - 1]);
        }
        rows
    }

    /// Checks that all parts have as many rows as `timestamp`, and that what must be finite is.
    ///
    /// # Errors
    /// Names the part and its length or row.
    pub fn check(&self) -> Result<(), ExportError> {
        let expected = self.len();
        for array in self.arrays().iter().filter(|array| array.per_row) {
            let found = array.shape[0];
            if found != expected {
                return Err(ExportError::WrongLength { name: array.name, expected, found });
            }
            self.check_finite(array)?;
        }
        Ok(())
    }

    fn check_finite(&self, array: &NamedArray) -> Result<(), ExportError> {
        let ArrayData::F64(values) = &array.data else { return Ok(()) };
        let width: usize = array.shape[1..].iter().product();
        let bad = values.iter().enumerate().find(|(place, value)| {
            let row = place / width;
            let side = (place % width) * 2 / width.max(2);
            let may_be_unknown = array.unknown_without_hand && !self.hand_valid[row][side];
            !value.is_finite() && !may_be_unknown
        });
        match bad {
            None => Ok(()),
            Some((place, _)) => Err(ExportError::NotFinite { name: array.name, row: place / width }),
        }
    }

    /// All arrays in the order of the file.
    pub fn arrays(&self) -> Vec<NamedArray> {
        let n = self.len();
        let per_side = |name, rows: &[[f64; 2]], unit| NamedArray::rows(name, rows, &[2], unit);
        let pose = "m, quaternion wxyz";
        let poses = |name, rows: &[[[f64; 7]; 2]]| NamedArray::rows(name, rows.as_flattened(), &[2, 7], pose);
        let fingertips = self.fingertips_cam.as_flattened().as_flattened();
        let valid: Vec<bool> = self.hand_valid.as_flattened().to_vec();
        vec![
            NamedArray::per_row("timestamp", vec![n], ArrayData::F64(self.timestamp.clone()), "s"),
            NamedArray::per_row(
                "frame_index",
                vec![self.frame_index.len()],
                ArrayData::I64(self.frame_index.clone()),
                "1",
            ),
            NamedArray::rows("arm_q", &self.arm_q, &[ARM_DOF], "rad"),
            NamedArray::rows("hand_q", &self.hand_q, &[HAND_DOF], "rad"),
            NamedArray::rows("hand_cmd", &self.hand_cmd, &[HAND_DOF], "0 open to 1 closed"),
            NamedArray::rows("state", &self.state(), &[ACTUATED_DOF], "rad, then 0..1"),
            NamedArray::rows("action", &self.action(), &[ACTUATED_DOF], "rad, then 0..1"),
            poses("wrist_cam", &self.wrist_cam),
            poses("wrist_torso", &self.wrist_torso),
            poses("target_wrist_torso", &self.target_wrist_torso).unknown_without_hand(),
            NamedArray::rows("fingertips_cam", fingertips, &[2, 5, 3], "m"),
            per_side("ik_error_pos", &self.ik_error_pos, "m").unknown_without_hand(),
            per_side("ik_error_rot", &self.ik_error_rot, "rad").unknown_without_hand(),
            NamedArray::per_row("hand_valid", vec![self.hand_valid.len(), 2], ArrayData::Bool(valid), "bool"),
            per_side("hand_confidence", &self.hand_confidence, "0..1"),
            per_side("contact", &self.contact, "0..1"),
            NamedArray::constant("fps", &[], vec![crate::clip::STANDARD_FPS], "Hz"),
            NamedArray::constant("beta", &[], vec![self.beta], "1"),
            NamedArray::constant("alpha", &[], vec![self.alpha], "1"),
            NamedArray::constant("R_cam", &[3, 3], row_major(&self.r_cam), "1"),
            NamedArray::constant("T_offset", &[3], self.t_offset.iter().copied().collect(), "m"),
            NamedArray::constant("K", &[3, 3], row_major(&self.k), "px"),
        ]
    }

    /// Checks the record and writes it as `record.npz`: the same rows give the same bytes.
    ///
    /// # Errors
    /// When a part has the wrong length, a value is not finite, or the file cannot be written.
    pub fn write_npz(&self, path: &std::path::Path) -> Result<(), ExportError> {
        self.check()?;
        write_npz(path, &self.arrays())
    }
}

fn row_major(matrix: &Matrix3<f64>) -> Vec<f64> {
    matrix.transpose().iter().copied().collect()
}
