//! Parameters of the selection by contact motion.

use serde::{Deserialize, Serialize};

/// Parameters of [`super::propose`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SelectParams {
    /// Longer side of the picture worked on, pixels. Default 320.
    pub work_size: u32,
    /// Moments looked at, spread over the clip. Default 48.
    pub moments: usize,
    /// Frames between the two pictures of a moment. Default 4.
    pub stride: usize,
    /// How far from a fingertip the object may be touched, palm widths. Default 2.2.
    pub reach: f64,
    /// Proposals handed back at most. Default 5.
    pub proposals: usize,
}

impl Default for SelectParams {
    fn default() -> Self {
        Self { work_size: 320, moments: 48, stride: 4, reach: 2.2, proposals: 5 }
    }
}
