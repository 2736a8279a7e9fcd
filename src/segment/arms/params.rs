//! Parameters of the classical arm masks.

use serde::{Deserialize, Serialize};

/// Parameters of [`super::track_arms`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ArmParams {
    /// Longer side of the picture that masks are made on, pixels. Default 320: an integer divisor of common widths.
    pub work_size: u32,
    /// Frames from which colours are learned, at most, spread over the clip. Default 24.
    pub training_frames: usize,
    /// Rounds of self-training after the first colour model. Default 2.
    pub training_rounds: usize,
    /// GrabCut iterations a frame. Default 1.
    pub cut_iterations: i32,
    /// P(arm) from which a pixel is a candidate. Default 0.5.
    pub threshold: f64,
    /// Lab distance from the background plate below which a pixel is taken for background unless
    /// its colour is arm beyond doubt. Default 7.
    pub still_threshold: f64,
    /// Full-size pixels by which the finished mask is grown. Default 1.
    pub grow: i32,
}

impl Default for ArmParams {
    fn default() -> Self {
        Self {
            work_size: 320,
            training_frames: 24,
            training_rounds: 2,
            cut_iterations: 1,
            threshold: 0.5,
            still_threshold: 7.0,
            grow: 1,
        }
    }
}
