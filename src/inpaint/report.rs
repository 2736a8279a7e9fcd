//! How honest the restored background is.

use serde::{Deserialize, Serialize};

/// Where the pixels of one frame's hole come from. Shares add up to 1 unless the hole is empty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameCoverage {
    /// Pixels in the hole.
    pub hole: u64,
    /// Share really seen on another frame, 0 to 1.
    pub seen: f64,
    /// Share made up, 0 to 1; the template's region is left out of it.
    pub synthesised: f64,
    /// Share made up where the template will be drawn anyway, 0 to 1.
    pub behind_template: f64,
}

/// What the stage says about its work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InpaintReport {
    /// One a frame, in order.
    pub coverage: Vec<FrameCoverage>,
    /// Plates built.
    pub plates: usize,
    /// The back end, as the record names it.
    pub backend: String,
}

impl InpaintReport {
    /// Share of all hole pixels of the clip that were really seen; 1 without holes.
    pub fn seen_share(&self) -> f64 {
        let total: f64 = self.coverage.iter().map(|c| c.hole as f64).sum();
        let seen: f64 = self.coverage.iter().map(|c| c.hole as f64 * c.seen).sum();
        if total > 0.0 { seen / total } else { 1.0 }
    }
}
