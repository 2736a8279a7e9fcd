//! What retargeting hands on: joint angles for every frame and how well they meet the targets.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::Method;
use crate::{
    geometry::{PerSide, Pose, Position, Torso},
    robot::JointAngles,
};

/// The camera-relative map `P_robot = β R_cam P_human + T_offset`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraMap {
    /// Uniform scale β.
    pub beta: f64,
    /// Rotation from camera axes to torso axes.
    #[serde(rename = "R_cam")]
    pub rotation: Matrix3<f64>,
    /// The robot's virtual camera in the torso frame, metres.
    #[serde(rename = "T_offset")]
    pub offset: Vector3<f64>,
}

/// One side on one frame, as solved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SideReport {
    /// Whether a hand drove this side on this frame.
    pub driven: bool,
    /// The wanted wrist, torso frame (see `DESIGN.md` for the wrist frame): the human's under the motion's map,
    /// whatever a baseline steered by.
    pub target: Pose<Torso>,
    /// The reached wrist.
    pub reached: Pose<Torso>,
    /// Reached fingertips, thumb to pinky.
    pub fingertips: [Position<Torso>; 5],
    /// Wrist distance to target, metres.
    pub error_position: f64,
    /// Wrist angle to target, radians.
    pub error_rotation: f64,
    /// Smallest distance of an arm joint to one of its limits as a share of its range, 0 to 0.5. Fingers are
    /// left out: an open hand is at its limits.
    pub limit_margin: f64,
    /// Whether the target lies within reach.
    pub reachable: bool,
    /// Contact of thumb and a finger with each other or an object between them, 0 to 1.
    pub contact: f64,
}

/// The robot over a clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotMotion {
    /// The method that made it.
    #[serde(default)]
    pub method: Method,
    /// The map that was used (β fitted, if it was to be).
    pub map: CameraMap,
    /// Smoothing α of `q_t = α q̂_t + (1−α) q_{t−1}` that was used; 1 where a baseline smoothed in its own way.
    pub alpha: f64,
    /// One a frame, in order.
    pub angles: Vec<JointAngles>,
    /// q̂: as solved, before velocity limits and smoothing; one a frame.
    #[serde(default)]
    pub raw_angles: Vec<JointAngles>,
    /// One a frame and side.
    pub sides: PerSide<Vec<SideReport>>,
}
