//! What one side of the robot shall do on one frame.

use nalgebra::{UnitQuaternion, Vector3};

use crate::geometry::{Pose, Position, Torso};

/// A wrist, and fingers where there are any, in `torso_link`.
#[derive(Clone, Copy, Debug)]
pub struct SideTarget {
    /// The wrist frame: origin of `{side}_base_link`, axes of `{side}_wrist_yaw_link`, metres.
    pub wrist: Pose<Torso>,
    /// Unit line of sight from the virtual camera to the wrist.
    pub sight: Vector3<f64>,
    /// Fingers; `None` solves for the wrist alone.
    pub hand: Option<HandTarget>,
}

/// Fingers, as vectors in torso axes.
#[derive(Clone, Copy, Debug)]
pub struct HandTarget {
    /// Wrist → fingertip, metres, thumb to pinky.
    pub tips: [Vector3<f64>; 5],
    /// Thumb tip → fingertip, index to pinky.
    pub pinches: [PinchTarget; 4],
}

/// Thumb and one finger, drawn together.
#[derive(Clone, Copy, Debug, Default)]
pub struct PinchTarget {
    /// Wanted vector from the thumb's tip to the finger's, metres.
    pub gap: Vector3<f64>,
    /// 0 (free) to 1 (full pinch).
    pub strength: f64,
}

impl SideTarget {
    /// A wrist alone, seen from `camera` (metres, `torso_link`).
    pub fn wrist_only(position: Vector3<f64>, rotation: UnitQuaternion<f64>, camera: &Vector3<f64>) -> Self {
        let sight = (position - camera).try_normalize(1e-6).unwrap_or_else(Vector3::x);
        Self { wrist: Pose::from_parts(Position::new(position), rotation), sight, hand: None }
    }
}
