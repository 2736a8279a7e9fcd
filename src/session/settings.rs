//! Parameters a person or a manifest sets for a clip.

use serde::{Deserialize, Serialize};

use crate::{
    geometry::PerSide,
    retarget::{Beta, CameraRotation, Method, Smoothing, WristTurn},
};

/// What retargeting lets a person tune for a clip. `None` leaves the stage's documented default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RetargetSettings {
    /// By which method (default: ours).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// Whether Masquerade works with our camera map (default: no).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared_map: Option<bool>,
    /// Scale β (default: fit).
    pub beta: Option<Beta>,
    /// Smoothing α, 0 < α ≤ 1.
    pub alpha: Option<f64>,
    /// How α is applied.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothing: Option<Smoothing>,
    /// Corrections of the wrists (default: none).
    #[serde(default, skip_serializing_if = "is_straight")]
    pub wrist: PerSide<WristTurn>,
    /// `R_cam`.
    #[serde(rename = "R_cam")]
    pub camera_rotation: Option<CameraRotation>,
    /// `T_offset` in the torso frame, metres.
    #[serde(rename = "T_offset")]
    pub offset: Option<[f64; 3]>,
    /// Hand length (wrist to middle tip, straight), metres, where known: the scale of monocular depth.
    pub hand_length: Option<f64>,
}

/// What is not corrected is not written, so that sessions from before corrections stay as they are.
fn is_straight(wrist: &PerSide<WristTurn>) -> bool {
    *wrist == PerSide::default()
}
