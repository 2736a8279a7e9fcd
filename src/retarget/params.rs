//! What can be tuned about retargeting.

use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::{Deserialize, Serialize};

use super::{CameraMap, Method, RetargetError, WristTurn};
use crate::geometry::PerSide;

/// Parameters of [`super::retarget`]; every field has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RetargetParams {
    /// By which method. A baseline takes R_cam, T_offset and `reach_tolerance` from here, and what steers our
    /// own method alone (corrections, α, smoothing, weights, pinches, rest) does not touch it.
    pub method: Method,
    /// Whether Masquerade works with our camera map and its fitted β instead of its own fixed transform with
    /// β = 1 (default: no).
    pub shared_map: bool,
    /// Scale β, or `"fit"`.
    pub beta: Beta,
    /// Share of the frames that a fitted β must bring within reach, 0 to 1.
    pub beta_reach: f64,
    /// Rotation from the source camera's axes to the torso's.
    #[serde(rename = "R_cam")]
    pub camera: CameraRotation,
    /// The virtual camera in `torso_link`, metres.
    #[serde(rename = "T_offset")]
    pub offset: Vector3<f64>,
    /// A person's correction of each wrist.
    pub wrist: PerSide<WristTurn>,
    /// α of `q_t = α q̂_t + (1−α) q_{t−1}`, above 0 and up to 1 (no smoothing).
    pub alpha: f64,
    /// How α is applied.
    pub smoothing: Smoothing,
    /// Smoothing of the hand track before solving.
    pub cutoff: Cutoff,
    /// What the solver weighs against what.
    pub weights: Weights,
    /// When thumb and finger are drawn together.
    pub pinch: Pinch,
    /// A wrist nearer than this to its target counts as reached, metres.
    pub reach_tolerance: f64,
    /// How long an arm takes from its last target to rest, and back, seconds.
    pub rest_time: f64,
}

impl Default for RetargetParams {
    fn default() -> Self {
        Self {
            method: Method::Ours,
            shared_map: false,
            beta: Beta::Fit,
            beta_reach: 0.95,
            camera: CameraRotation::default(),
            offset: Vector3::new(0.0576, 0.0, 0.4299),
            wrist: PerSide::default(),
            alpha: 0.5,
            smoothing: Smoothing::ZeroPhase,
            cutoff: Cutoff::default(),
            weights: Weights::default(),
            pinch: Pinch::default(),
            reach_tolerance: 0.005,
            rest_time: 0.8,
        }
    }
}

/// The scale β of the camera-relative map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Beta {
    /// A given number, above 0.
    Fixed(f64),
    /// Fitted to the clip: the one nearest to equal apparent hand size that brings `beta_reach` of the frames
    /// within reach.
    #[serde(with = "fit")]
    Fit,
}

mod fit {
    use serde::{Deserialize as _, Deserializer, Serializer, de::Error as _};

    pub(super) fn serialize<S: Serializer>(serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str("fit")
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<(), D::Error> {
        match String::deserialize(deserializer)?.as_str() {
            "fit" => Ok(()),
            other => Err(D::Error::custom(format!("beta = \"{other}\": expected a number or \"fit\""))),
        }
    }
}

/// R_cam, as a matrix or as angles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum CameraRotation {
    /// Rows of the matrix that takes camera axes (x right, y down, z forward) to torso axes.
    Rows([[f64; 3]; 3]),
    /// A camera that looks forward, turned.
    Angles(CameraAngles),
}

/// Attitude of the source camera in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraAngles {
    /// Downwards.
    pub pitch_deg: f64,
    /// To the left.
    pub yaw_deg: f64,
    /// About the optical axis, clockwise as the camera sees it.
    pub roll_deg: f64,
}

impl Default for CameraAngles {
    /// The robot's own head camera.
    fn default() -> Self {
        Self { pitch_deg: 47.6, yaw_deg: 0.0, roll_deg: 0.0 }
    }
}

impl Default for CameraRotation {
    fn default() -> Self {
        Self::Angles(CameraAngles::default())
    }
}

impl CameraRotation {
    /// The rotation matrix from camera to torso axes.
    ///
    /// # Errors
    /// When a matrix is given that is no rotation, or an angle is not finite.
    pub fn matrix(&self) -> Result<Matrix3<f64>, RetargetError> {
        let matrix = match self {
            Self::Rows(rows) => Matrix3::from_fn(|row, column| rows[row][column]),
            Self::Angles(angles) => {
                let (sin, cos) = angles.pitch_deg.to_radians().sin_cos();
                let pitched = Matrix3::new(0.0, -sin, cos, -1.0, 0.0, 0.0, 0.0, -cos, -sin);
                let yaw = Rotation3::from_axis_angle(&Vector3::z_axis(), angles.yaw_deg.to_radians());
                let roll = Rotation3::from_axis_angle(&Vector3::z_axis(), angles.roll_deg.to_radians());
                yaw.matrix() * pitched * roll.matrix()
            }
        };
        let skew = (matrix.transpose() * matrix - Matrix3::identity()).amax();
        if skew < 1e-3 && matrix.determinant() > 0.0 {
            // Hand-typed rows are rounded; the nearest rotation is what was meant.
            return Ok(nalgebra::UnitQuaternion::from_matrix(&matrix).to_rotation_matrix().into_inner());
        }
        Err(RetargetError::Parameter {
            name: "R_cam",
            value: format!("{self:?}"),
            expected: "a rotation matrix (orthonormal rows, determinant 1) or finite angles",
        })
    }
}

/// How the method's exponential moving average is applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Smoothing {
    /// Not at all.
    None,
    /// As published: causal, so the robot lags behind.
    Ema,
    /// Forward and backward, so that nothing lags; afterwards the wrists are put back on their targets.
    ZeroPhase,
}

/// Half-power frequencies of the zero-phase smoother that the hand track passes before solving, Hz.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Cutoff {
    /// Wrist across the line of sight: light, since the picture shows it and landmarks come smoothed.
    pub across_hz: f64,
    /// Wrist along the line of sight: strong, since a single camera hardly sees it.
    pub depth_hz: f64,
    /// Orientation of the palm.
    pub rotation_hz: f64,
    /// Fingers in the palm.
    pub finger_hz: f64,
}

impl Default for Cutoff {
    fn default() -> Self {
        Self { across_hz: 8.0, depth_hz: 2.5, rotation_hz: 3.5, finger_hz: 4.5 }
    }
}

/// Weights of the solver's residuals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Weights {
    /// Wrist position, per metre.
    pub position: f64,
    /// The share of `position` that counts along the line of sight: out of reach, the wrist gives way in depth
    /// and stays on its pixel.
    pub along_sight: f64,
    /// Wrist orientation, per radian.
    pub rotation: f64,
    /// Wrist → fingertip vectors, per metre.
    pub fingertip: f64,
    /// Thumb → finger vectors of a full pinch, per metre.
    pub pinch: f64,
    /// Pull of the arm towards its comfortable posture, per radian.
    pub posture: f64,
    /// Pull towards the angles of the frame before, per radian.
    pub inertia: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self {
            position: 1000.0,
            along_sight: 0.15,
            rotation: 3.0,
            fingertip: 15.0,
            pinch: 150.0,
            posture: 0.02,
            inertia: 0.02,
        }
    }
}

/// Pinch closing with hysteresis, after DexPilot's projection of near fingertips.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pinch {
    /// Thumb and fingertip of the human nearer than this start a pinch, metres on a hand of 0.18 m.
    pub close: f64,
    /// Farther than this they end it, metres on a hand of 0.18 m; on the way there the robot's open as they do.
    pub release: f64,
    /// Gap between the robot's fingertips in a pinch, metres.
    pub gap: f64,
    /// Frames over which a pinch fades in and out.
    pub ramp_frames: usize,
}

impl Default for Pinch {
    fn default() -> Self {
        Self { close: 0.03, release: 0.04, gap: 1e-4, ramp_frames: 4 }
    }
}

impl RetargetParams {
    /// The camera map with scale `beta`.
    ///
    /// # Errors
    /// When R_cam is no rotation.
    pub fn map(&self, beta: f64) -> Result<CameraMap, RetargetError> {
        Ok(CameraMap { beta, rotation: self.camera.matrix()?, offset: self.offset })
    }

    /// # Errors
    /// Names the first parameter that is out of its range.
    pub fn validate(&self) -> Result<(), RetargetError> {
        self.camera.matrix()?;
        if let Beta::Fixed(beta) = self.beta {
            require("beta", beta, beta > 0.0, "a number above 0, or \"fit\"")?;
        }
        let share = (0.0..=1.0).contains(&self.beta_reach);
        require("beta_reach", self.beta_reach, share, "a share between 0 and 1")?;
        for value in self.offset.iter() {
            require("T_offset", *value, value.is_finite(), "three finite numbers, metres")?;
        }
        for (_, turn) in self.wrist.iter() {
            for value in turn.degrees() {
                require("wrist", value, value.is_finite(), "finite degrees")?;
            }
        }
        require("alpha", self.alpha, self.alpha > 0.0 && self.alpha <= 1.0, "above 0 and at most 1")?;
        let positive = [
            ("cutoff.across_hz", self.cutoff.across_hz),
            ("cutoff.depth_hz", self.cutoff.depth_hz),
            ("cutoff.rotation_hz", self.cutoff.rotation_hz),
            ("cutoff.finger_hz", self.cutoff.finger_hz),
            ("weights.position", self.weights.position),
            ("weights.along_sight", self.weights.along_sight),
            ("reach_tolerance", self.reach_tolerance),
            ("rest_time", self.rest_time),
        ];
        for (name, value) in positive {
            require(name, value, value > 0.0, "a finite number above 0")?;
        }
        let weights = [
            ("weights.rotation", self.weights.rotation),
            ("weights.fingertip", self.weights.fingertip),
            ("weights.pinch", self.weights.pinch),
            ("weights.posture", self.weights.posture),
            ("weights.inertia", self.weights.inertia),
            ("pinch.gap", self.pinch.gap),
            ("pinch.close", self.pinch.close),
        ];
        for (name, value) in weights {
            require(name, value, value >= 0.0, "a finite number, 0 or above")?;
        }
        let ordered = self.pinch.release >= self.pinch.close;
        require("pinch.release", self.pinch.release, ordered, "a distance not below pinch.close")
    }
}

fn require(name: &'static str, value: f64, holds: bool, expected: &'static str) -> Result<(), RetargetError> {
    if value.is_finite() && holds {
        return Ok(());
    }
    Err(RetargetError::Parameter { name, value: value.to_string(), expected })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_camera_is_the_robots_own() {
        let matrix = CameraRotation::default().matrix().unwrap();
        let facts = Matrix3::new(0.0, -0.73846, 0.67430, -1.0, 0.0, 0.0, 0.0, -0.67430, -0.73846);
        assert!((matrix - facts).amax() < 1e-4);
    }

    #[test]
    fn beta_is_a_number_or_fit() {
        assert_eq!(serde_json::from_str::<Beta>("0.7").unwrap(), Beta::Fixed(0.7));
        assert_eq!(serde_json::from_str::<Beta>("\"fit\"").unwrap(), Beta::Fit);
        assert_eq!(serde_json::to_string(&Beta::Fit).unwrap(), "\"fit\"");
        assert!(serde_json::from_str::<Beta>("\"fitted\"").is_err());
    }

    #[test]
    fn a_mirror_is_no_camera_rotation() {
        let mirror = CameraRotation::Rows([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
        assert!(mirror.matrix().is_err());
    }

    #[test]
    fn a_nan_is_named() {
        let params = RetargetParams { alpha: f64::NAN, ..Default::default() };
        assert!(params.validate().unwrap_err().to_string().contains("alpha"));
    }
}
