//! Which object: contact motion, the operator or a vision-language model, behind one trait.

mod arm_colours;
mod change;
mod fuse;
mod held;
mod motion;
mod operator;
mod outline;
mod params;
mod places;
mod propose;
mod scene;
#[cfg(test)]
mod tests;
mod timeline;
pub mod vlm;

use serde::{Deserialize, Serialize};

use crate::{
    clip::{FrameError, FrameIndex, FrameSource},
    geometry::{Pixel, PixelBox, Size},
    landmarks::LandmarkTrack,
    progress::{Cancelled, Watch},
    segment::MaskTrack,
};

pub use operator::OperatorSelector;
pub use params::SelectParams;
pub use propose::{ContactSelector, propose};

/// One guess at the manipulated object: a ready box prompt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// The frame the box is on; the object is visible there.
    pub frame: FrameIndex,
    /// The object's box, pixels of the clip.
    pub bounds: PixelBox,
    /// A point on it, where that is all the selector can say; the box is then only what lies around.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<Pixel>,
    /// What it is called; `object` where the selector cannot name it.
    pub label: String,
    /// Trust, 0 to 1.
    pub confidence: f64,
    /// Why, as a sentence for the curator.
    pub reason: String,
    /// Who says so, as the record names it, for example `contact motion`.
    pub backend: String,
}

/// What a selector may look at.
#[derive(Clone, Copy)]
pub struct SelectInput<'a> {
    /// The clip.
    pub frames: &'a dyn FrameSource,
    /// Hands, full-size pixels.
    pub landmarks: &'a LandmarkTrack,
    /// Arm masks of every frame.
    pub arms: &'a MaskTrack,
}

impl std::fmt::Debug for SelectInput<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SelectInput").field("frames", &self.frames.frame_count()).finish_non_exhaustive()
    }
}

/// Proposes which object is manipulated.
pub trait ObjectSelector {
    /// Proposals, the surest first; none when nothing speaks for any object.
    ///
    /// # Errors
    /// When an input does not fit the clip, a frame cannot be read or `watch` cancels.
    fn select(&self, input: SelectInput<'_>, watch: &dyn Watch) -> Result<Vec<Proposal>, SelectError>;
}

/// Why no proposals could be made.
#[derive(Debug, thiserror::Error)]
pub enum SelectError {
    /// A frame could not be read.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Image processing failed.
    #[error("image processing failed while looking for the object: {0}")]
    Vision(#[from] opencv::Error),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A model gave no answer.
    #[error(transparent)]
    Model(#[from] vlm::VlmError),
    /// An input made for another clip.
    #[error("{what} covers {found} frames, the clip has {expected}")]
    Mismatch {
        /// Which input.
        what: &'static str,
        /// Its frames.
        found: usize,
        /// The clip's frames.
        expected: usize,
    },
    /// The operator's box cannot be used.
    #[error("the box {bounds:?} on {frame} lies outside the clip: {frames} frames of {size}")]
    Prompt {
        /// The prompt's frame.
        frame: FrameIndex,
        /// The prompt's box.
        bounds: PixelBox,
        /// Frames of the clip.
        frames: usize,
        /// The clip's picture size.
        size: Size,
    },
}
