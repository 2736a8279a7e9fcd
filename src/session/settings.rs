//! Parameters a person or a manifest sets for a clip.

use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::{Deserialize, Serialize};

/// Clockwise rotation of the decoded picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "u32", into = "u32")]
pub enum Rotation {
    /// As decoded (default).
    #[default]
    None,
    /// A quarter turn clockwise.
    Clockwise90,
    /// Upside down.
    Half,
    /// A quarter turn anticlockwise.
    Clockwise270,
}

impl TryFrom<u32> for Rotation {
    type Error = String;
    fn try_from(degrees: u32) -> Result<Self, String> {
        match degrees {
            0 => Ok(Self::None),
            90 => Ok(Self::Clockwise90),
            180 => Ok(Self::Half),
            270 => Ok(Self::Clockwise270),
            other => Err(format!("rotate = {other}: expected 0, 90, 180 or 270 degrees clockwise")),
        }
    }
}

impl From<Rotation> for u32 {
    fn from(rotation: Rotation) -> Self {
        match rotation {
            Rotation::None => 0,
            Rotation::Clockwise90 => 90,
            Rotation::Half => 180,
            Rotation::Clockwise270 => 270,
        }
    }
}

/// The source camera, in pixels of the clip as decoded (before [`Rotation`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraSetting {
    /// Nobody said: a stated default field of view is taken (default).
    #[default]
    Unknown,
    /// Pinhole intrinsics in pixels.
    Intrinsics {
        /// Focal length along x.
        fx: f64,
        /// Focal length along y.
        fy: f64,
        /// Principal point x.
        cx: f64,
        /// Principal point y.
        cy: f64,
    },
    /// Horizontal field of view in degrees, square pixels, centred.
    HorizontalFov(f64),
}

/// The scale β of the camera map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Beta {
    /// As given.
    Value(f64),
    /// The largest scale at which the wanted share of frames is reachable.
    Fit,
}

/// `R_cam`: how camera axes lie in the torso frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraRotation {
    /// A camera pitched down, then yawed left and rolled clockwise, in degrees.
    Angles {
        /// Downwards from the horizon.
        pitch_deg: f64,
        /// Leftwards about the torso's z.
        yaw_deg: f64,
        /// Clockwise about the optical axis.
        roll_deg: f64,
    },
    /// The rotation matrix itself.
    Matrix(Matrix3<f64>),
}

impl Default for CameraRotation {
    fn default() -> Self {
        Self::Angles { pitch_deg: 47.6, yaw_deg: 0.0, roll_deg: 0.0 }
    }
}

impl CameraRotation {
    /// The 3×3 rotation from camera axes (x right, y down, z forward) to torso axes (x forward, y left, z up).
    ///
    /// With pitch p alone this is `[[0, −sin p, cos p], [−1, 0, 0], [0, −cos p, −sin p]]`.
    pub fn matrix(&self) -> Matrix3<f64> {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Angles { pitch_deg, yaw_deg, roll_deg } => {
                let (sin, cos) = pitch_deg.to_radians().sin_cos();
                let pitched = Matrix3::new(0.0, -sin, cos, -1.0, 0.0, 0.0, 0.0, -cos, -sin);
                let yaw = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw_deg.to_radians());
                let roll = Rotation3::from_axis_angle(&Vector3::z_axis(), roll_deg.to_radians());
                yaw.into_inner() * pitched * roll.into_inner()
            }
        }
    }
}

/// What retargeting lets a person tune for a clip. `None` leaves the stage's documented default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RetargetSettings {
    /// Scale β (default: fit).
    pub beta: Option<Beta>,
    /// Smoothing α, 0 < α ≤ 1.
    pub alpha: Option<f64>,
    /// `R_cam`.
    #[serde(rename = "R_cam")]
    pub camera_rotation: Option<CameraRotation>,
    /// `T_offset` in the torso frame, metres.
    #[serde(rename = "T_offset")]
    pub offset: Option<[f64; 3]>,
    /// Hand length (wrist to middle tip, straight), metres, where known: the scale of monocular depth.
    pub hand_length: Option<f64>,
}
