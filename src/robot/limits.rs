//! Position and velocity limits of the actuated joints.

use crate::clip::STANDARD_FPS;

use super::{ACTUATED_DOF, JointAngles};

/// Limits of the 26 actuated joints, in the record's order.
#[derive(Clone, Debug, PartialEq)]
pub struct JointLimits {
    /// Lower limits, radians.
    pub lower: [f64; ACTUATED_DOF],
    /// Upper limits, radians; a finger's is lowered where its coupled joint would pass its own limit.
    pub upper: [f64; ACTUATED_DOF],
    /// Velocity limits, rad/s.
    pub velocity: [f64; ACTUATED_DOF],
}

impl JointLimits {
    /// How far joint `index` may move from one 30 FPS frame to the next, radians.
    pub fn step(&self, index: usize) -> f64 {
        self.velocity[index] / STANDARD_FPS
    }

    /// `angles` with every joint moved to the nearest angle inside its limits.
    pub fn clamp(&self, angles: &JointAngles) -> JointAngles {
        let mut clamped = *angles;
        for (index, angle) in clamped.0.iter_mut().enumerate() {
            *angle = angle.clamp(self.lower[index], self.upper[index]);
        }
        clamped
    }

    /// Number of joints beyond a position limit by more than `tolerance` radians; a NaN counts.
    pub fn position_violations(&self, angles: &JointAngles, tolerance: f64) -> usize {
        let inside = |i: usize, q: f64| q >= self.lower[i] - tolerance && q <= self.upper[i] + tolerance;
        angles.0.iter().enumerate().filter(|&(index, &angle)| !inside(index, angle)).count()
    }

    /// Number of joints that move more in one frame than their velocity limit allows, by more than
    /// `tolerance` radians; a NaN counts.
    pub fn velocity_violations(&self, before: &JointAngles, after: &JointAngles, tolerance: f64) -> usize {
        let moved = |i: usize| (after.0[i] - before.0[i]).abs();

        (0..ACTUATED_DOF)
            .filter(|&index| moved(index).is_nan() || moved(index) > self.step(index) + tolerance)
            .count()
    }

    /// The smallest distance of the joints `range` to a limit, as a share of the joint's range: 0 at a limit,
    /// 0.5 in the middle.
    pub fn margin(&self, angles: &JointAngles, range: std::ops::Range<usize>) -> f64 {
        range
            .map(|i| {
                let (lower, upper) = (self.lower[i], self.upper[i]);
                (angles.0[i] - lower).min(upper - angles.0[i]) / (upper - lower)
            })
            .fold(0.5, f64::min)
            .max(0.0)
    }
}
