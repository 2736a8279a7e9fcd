//! What is known of hands before looking: joint limits, usual angles, usual motion.

use nalgebra::SVector;

use super::kinematics::{ANGLES, POSE_DOF};

/// Softness of a joint limit, radians.
pub(super) const LIMIT_SIGMA: f64 = 0.06;
/// DIP angle as a share of the PIP angle, and how far it strays, radians.
pub(super) const DIP_SHARE: f64 = 0.67;
/// Spread around that share.
pub(super) const DIP_SIGMA: f64 = 0.30;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Lower limit, upper limit, usual value and its spread of an angle, radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct AnglePrior {
    pub low: f64,
    pub high: f64,
    pub usual: f64,
    pub spread: f64,
}

const fn degrees(low: f64, high: f64, usual: f64, spread: f64) -> AnglePrior {
    AnglePrior { low: low * DEGREE, high: high * DEGREE, usual: usual * DEGREE, spread: spread * DEGREE }
}

const THUMB: [AnglePrior; 5] = [
    degrees(-50.0, 60.0, 0.0, 30.0),
    degrees(-50.0, 50.0, 0.0, 30.0),
    degrees(-45.0, 45.0, 0.0, 15.0),
    degrees(-20.0, 80.0, 20.0, 30.0),
    degrees(-20.0, 90.0, 20.0, 35.0),
];
const FINGER: [AnglePrior; 4] = [
    degrees(-22.0, 22.0, 0.0, 9.0),
    degrees(-30.0, 92.0, 30.0, 50.0),
    degrees(0.0, 112.0, 35.0, 50.0),
    degrees(-5.0, 85.0, 22.0, 50.0),
];

/// Priors of the 21 angles.
pub(super) fn angle_priors() -> [AnglePrior; ANGLES] {
    std::array::from_fn(|k| if k < 5 { THUMB[k] } else { FINGER[(k - 5) % 4] })
}

/// A relaxed hand.
pub(super) fn usual_angles() -> SVector<f64, ANGLES> {
    let priors = angle_priors();
    SVector::from_fn(|k, _| priors[k].usual)
}

/// Spread of the second difference of each pose parameter from frame to frame at 30 FPS: a hand
/// that speeds up by 3 m/s² moves 3.3 mm a frame off its straight way.
pub(super) fn acceleration_spread() -> SVector<f64, POSE_DOF> {
    SVector::from_fn(|k, _| match k {
        0 | 1 => 0.004,
        2 => 0.002,
        3..=5 => 0.05,
        _ => 0.10,
    })
}
