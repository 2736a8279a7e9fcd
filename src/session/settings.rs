//! Parameters a person or a manifest sets for a clip.

use serde::{Deserialize, Serialize};

use crate::retarget::{Beta, CameraRotation};

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
