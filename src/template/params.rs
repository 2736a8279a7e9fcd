//! What may be turned, and why the stage fails.

use serde::{Deserialize, Serialize};

use crate::{
    clip::{FrameError, FrameIndex},
    progress::Cancelled,
    segment::SegmentError,
};

/// Parameters of template choice and placement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TemplateParams {
    /// Longest side of the pictures worked on, pixels; 640 by default.
    pub work_side: u32,
    /// Smallest mask that counts as the object seen, work pixels; 60 by default.
    pub least_area: u32,
    /// Whether the placements of all frames are weighed together; any value but 0 switches that on, as
    /// the default of 3 does.
    pub smoothing: u32,
    /// Whether placements may shear and change aspect, not only move, turn and scale; true by default.
    pub affine: bool,
}

impl Default for TemplateParams {
    fn default() -> Self {
        Self { work_side: 640, least_area: 60, smoothing: 3, affine: true }
    }
}

/// Why no template could be made.
#[derive(Debug, thiserror::Error)]
pub enum TemplateError {
    /// A frame could not be read.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Image processing failed.
    #[error("image processing failed while making the template: {0}")]
    Vision(#[from] opencv::Error),
    /// Mask tools failed.
    #[error(transparent)]
    Segment(#[from] SegmentError),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The operator chose a frame on which the object has no mask.
    #[error("{0} was chosen for the template, but the object has no mask there: draw one or choose another")]
    EmptyChoice(FrameIndex),
    /// Inputs of different clips.
    #[error("{what} covers {found} frames, the clip has {expected}")]
    Mismatch {
        /// Which input.
        what: &'static str,
        /// Its frames.
        found: usize,
        /// The clip's frames.
        expected: usize,
    },
}
