//! Scores of stages on synthetic episodes, under the keys of the bench table.
//!
//! Every scorer takes an [`Episode`](crate::synth::Episode), whose truth it reads, and what a stage made of its
//! clip; whether that stage was fed with truth or with what the stages before it made is the caller's choice and
//! is to be stated with the figure.

mod composite;
mod figures;
mod hands;
mod masks;
mod plate;

pub use composite::{composite_psnr_db, ideal_composite, true_order};
pub use figures::{Bound, FIGURES, FigureSpec, Figures, Summary};
pub use hands::{HandErrors, hand_errors, noisy_landmarks, wrist_reprojection_px};
pub use masks::{arm_mask_j, first_object_box, object_mask_j, template_iou_occluded};
pub use plate::{background_truth_region, inpaint_psnr_db};

/// Why an episode could not be scored.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The truth cannot be read.
    #[error(transparent)]
    Truth(#[from] crate::synth::SynthError),
    /// The stage's pictures cannot be read.
    #[error(transparent)]
    Frame(#[from] crate::clip::FrameError),
    /// Pictures do not compare.
    #[error(transparent)]
    Metric(#[from] super::MetricError),
    /// The compositor refused.
    #[error(transparent)]
    Composite(#[from] crate::composite::CompositeError),
    /// OpenCV refused.
    #[error("OpenCV failed while scoring: {0}")]
    OpenCv(#[from] opencv::Error),
    /// The artifact belongs to another clip.
    #[error("the {what} has {found} frames, the episode {expected}: score it on the clip it was made from")]
    Length {
        /// Which artifact.
        what: &'static str,
        /// Frames of the episode.
        expected: usize,
        /// Frames of the artifact.
        found: usize,
    },
}

fn same_length(what: &'static str, expected: usize, found: usize) -> Result<(), BenchError> {
    if expected == found { Ok(()) } else { Err(BenchError::Length { what, expected, found }) }
}

/// The mean of `values`; `None` when there are none.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
