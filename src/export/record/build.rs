//! Building the record out of what the stages made.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion};

use super::Record;
use crate::{
    clip::ClipInfo,
    export::ExportError,
    geometry::{Pose, Side, Torso},
    hands::{HandFrame, HandTrack},
    retarget::{CameraMap, RobotMotion, SideReport},
    robot::{ARM_DOF, HAND_DOF},
};

/// Lower and upper limit of the 12 hand actuators, radians, in the record's order.
pub type HandLimits = [[f64; 2]; HAND_DOF];

impl Record {
    /// The record of a motion.
    ///
    /// `hand_limits` turn hand angles into commands: 0 at the lower limit, 1 at the upper one.
    ///
    /// # Errors
    /// When the parts have different lengths.
    pub fn from_motion(
        motion: &RobotMotion,
        hands: &HandTrack,
        info: &ClipInfo,
        hand_limits: &HandLimits,
    ) -> Result<Self, ExportError> {
        let expected = info.frame_table.len();
        for (name, found) in [
            ("motion", motion.angles.len()),
            ("motion of the left side", motion.sides.left.len()),
            ("motion of the right side", motion.sides.right.len()),
            ("left hand track", hands.hands.left.len()),
            ("right hand track", hands.hands.right.len()),
        ] {
            if found != expected {
                return Err(ExportError::WrongLength { name, expected, found });
            }
        }
        let mut record = Self {
            beta: motion.map.beta,
            alpha: motion.alpha,
            r_cam: motion.map.rotation,
            t_offset: motion.map.offset,
            k: info.intrinsics.matrix(),
            ..Self::default()
        };
        let camera = virtual_camera(&motion.map);
        for row in 0..expected {
            record.timestamp.push(info.frame_table[row].pts);
            record.frame_index.push(i64::from(info.frame_table[row].index.0));
            record.push_angles(&motion.angles[row].0, hand_limits);
            record.push_sides(|side| &motion.sides[side][row], |side| &hands.hands[side][row], &camera);
        }
        Ok(record)
    }

    fn push_angles(&mut self, angles: &[f64], limits: &HandLimits) {
        let (mut arms, mut hands, mut commands) = ([0.0; ARM_DOF], [0.0; HAND_DOF], [0.0; HAND_DOF]);
        arms.copy_from_slice(&angles[..ARM_DOF]);
        hands.copy_from_slice(&angles[ARM_DOF..]);
        for ((command, angle), [lower, upper]) in commands.iter_mut().zip(hands).zip(limits) {
            *command = ((angle - lower) / (upper - lower)).clamp(0.0, 1.0);
        }
        self.arm_q.push(arms);
        self.hand_q.push(hands);
        self.hand_cmd.push(commands);
    }

    fn push_sides<'a>(
        &mut self,
        report: impl Fn(Side) -> &'a SideReport,
        hand: impl Fn(Side) -> &'a HandFrame,
        camera: &Isometry3<f64>,
    ) {
        let valid = Side::BOTH.map(|side| report(side).driven && hand(side).is_valid());
        let known = |side: Side, value: f64| if valid[side.index()] { value } else { f64::NAN };
        let from_camera = camera.inverse();
        self.wrist_torso.push(Side::BOTH.map(|side| {
            let before = self.wrist_torso.last().map(|row| row[side.index()]);
            pose_row(&report(side).reached.isometry, before)
        }));
        self.wrist_cam.push(Side::BOTH.map(|side| {
            let before = self.wrist_cam.last().map(|row| row[side.index()]);
            pose_row(&(from_camera * report(side).reached.isometry), before)
        }));
        self.target_wrist_torso.push(Side::BOTH.map(|side| {
            // Continues the reached wrist, so that both can be subtracted.
            let beside = self.wrist_torso.last().map(|row| row[side.index()]);
            target_row(&report(side).target, beside, valid[side.index()])
        }));
        self.fingertips_cam.push(Side::BOTH.map(|side| {
            report(side).fingertips.map(|tip| (from_camera * Point3::from(tip.xyz)).coords.into())
        }));
        self.ik_error_pos.push(Side::BOTH.map(|side| known(side, report(side).error_position)));
        self.ik_error_rot.push(Side::BOTH.map(|side| known(side, report(side).error_rotation)));
        self.hand_confidence.push(Side::BOTH.map(|side| hand(side).confidence));
        self.contact.push(Side::BOTH.map(|side| report(side).contact));
        self.hand_valid.push(valid);
    }
}

/// The pose of the robot's virtual camera in the torso frame: `R_cam`, `T_offset`.
fn virtual_camera(map: &CameraMap) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(map.rotation));
    Isometry3::from_parts(Translation3::from(map.offset), rotation)
}

fn target_row(pose: &Pose<Torso>, beside: Option<[f64; 7]>, valid: bool) -> [f64; 7] {
    if valid { pose_row(&pose.isometry, beside) } else { [f64::NAN; 7] }
}

/// `x y z qw qx qy qz`; of the two quaternions the one nearer to `before`, or with positive w.
fn pose_row(pose: &Isometry3<f64>, before: Option<[f64; 7]>) -> [f64; 7] {
    let mut row = Pose::<Torso>::new(*pose).to_xyz_wxyz();
    let reference = before.unwrap_or([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let agreement: f64 = row[3..].iter().zip(&reference[3..]).map(|(a, b)| a * b).sum();
    if agreement < 0.0 {
        for value in &mut row[3..] {
            *value = -*value;
        }
    }
    row
}
