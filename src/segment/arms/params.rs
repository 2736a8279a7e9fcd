//! Parameters of the classical arm masks.

use serde::{Deserialize, Serialize};

/// Parameters of [`super::track_arms`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ArmParams {
    /// Longer side of the picture that masks are made on, pixels. Default 320: an integer divisor of common widths.
    pub work_size: u32,
    /// Frames from which colours are learned, at most, spread over the clip. Default 36.
    pub training_frames: usize,
    /// Rounds of self-training after the first colour model. Default 2.
    pub training_rounds: usize,
    /// GrabCut iterations a frame. Default 1.
    pub cut_iterations: i32,
    /// P(arm | colour) from which a pixel is a candidate. Default 0.5.
    pub colour_threshold: f64,
    /// Lab distance from the background plate from which a change counts as evidence. Default 25.
    pub change_threshold: f64,
    /// Lab distance from the background plate below which a pixel is taken for background unless
    /// its colour is arm beyond doubt. Default 7.
    pub still_threshold: f64,
    /// Frames over which a mask is carried by flow where the landmarks drop out. Default 90.
    pub longest_dropout: usize,
    /// Full-size pixels by which the finished mask is grown. Default 1.
    pub grow: i32,
}

impl Default for ArmParams {
    fn default() -> Self {
        Self {
            work_size: 320,
            training_frames: 36,
            training_rounds: 2,
            cut_iterations: 1,
            colour_threshold: 0.5,
            change_threshold: 25.0,
            still_threshold: 7.0,
            longest_dropout: 90,
            grow: 1,
        }
    }
}
