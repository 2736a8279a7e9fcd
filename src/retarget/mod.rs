//! Retargeting: camera-relative map, wrist corrections, inverse kinematics, smoothing, limits.

mod motion;

pub use motion::{CameraMap, RobotMotion, SideReport};
