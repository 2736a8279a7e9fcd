//! Metric hands from image landmarks.
//!
//! Poses start from the perspective-n-point problem of the palm, whose two solutions are both kept
//! until the whole hand and its motion decide; then all frames and one hand shape are fitted
//! together. Depth comes from the hand's size: an error of 5 % in its length is one of 5 % in depth.

mod batch;
mod kinematics;
mod one;
mod priors;
mod runs;
mod score;
mod shape;
mod side;
mod single;
mod start;
mod terms;
mod track;

pub use one::{fit_frame, length_of};
pub use score::{FitScore, score_fit};
use serde::{Deserialize, Serialize};

use super::{HandTrack, HandsError};
use crate::{
    geometry::{PerSide, Pinhole, Side},
    landmarks::LandmarkTrack,
    progress::Watch,
};

/// How landmarks become metric hands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FitParams {
    /// Hand length, wrist to middle fingertip along the straight finger, millimetres (default 187,
    /// the mean of adults). Depth is proportional to it.
    pub hand_length_mm: f64,
    /// Relative spread of that length (default 0.01: all but given).
    pub hand_length_sigma: f64,
    /// Relative spread of single bones in hands of one length (default 0.03: X-rays of adults vary
    /// by 6 to 9 %, half of which is the size of the whole hand).
    pub bone_sigma: f64,
    /// Longest gap that is bridged, frames (default 10).
    pub longest_bridge: usize,
    /// Seen frames a run needs to be believed (default 4).
    pub shortest_run: usize,
    /// Keypoint spread, pixels; `None` (the default) estimates it from the clip.
    pub keypoint_sigma_px: Option<f64>,
}

impl Default for FitParams {
    fn default() -> Self {
        Self {
            hand_length_mm: 187.0,
            hand_length_sigma: 0.01,
            bone_sigma: 0.03,
            longest_bridge: 10,
            shortest_run: 4,
            keypoint_sigma_px: None,
        }
    }
}

/// Fits metric hands in the camera frame to `landmarks`; `backend` is carried into the track.
///
/// # Errors
/// When a parameter is out of bounds, when OpenCV fails, when cancelled.
pub fn fit(
    landmarks: &LandmarkTrack,
    backend: &str,
    pinhole: &Pinhole,
    params: &FitParams,
    watch: &dyn Watch,
) -> Result<HandTrack, HandsError> {
    params.check()?;
    let mut hands = PerSide::from_fn(|_| Vec::new());
    let mut hand_length = PerSide::from_fn(|_| None);
    for side in Side::BOTH {
        let fitted = side::fit_side(landmarks, side, pinhole, params, watch)?;
        (hands[side], hand_length[side]) = track::to_frames(landmarks, side, pinhole, fitted);
    }
    Ok(HandTrack { hands, hand_length, backend: backend.to_owned() })
}

impl FitParams {
    fn check(&self) -> Result<(), HandsError> {
        let bad = |name: &'static str, value: f64, expected: &'static str| {
            Err(HandsError::Parameter { name, value, expected })
        };
        if !(80.0..=300.0).contains(&self.hand_length_mm) {
            return bad("hand_length_mm", self.hand_length_mm, "80 to 300");
        }
        if !(1e-4..=1.0).contains(&self.hand_length_sigma) {
            return bad("hand_length_sigma", self.hand_length_sigma, "0.0001 to 1");
        }
        if !(1e-4..=1.0).contains(&self.bone_sigma) {
            return bad("bone_sigma", self.bone_sigma, "0.0001 to 1");
        }
        match self.keypoint_sigma_px {
            Some(sigma) if !(0.01..=100.0).contains(&sigma) => bad("keypoint_sigma_px", sigma, "0.01 to 100"),
            _ => Ok(()),
        }
    }
}
