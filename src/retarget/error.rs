//! Why retargeting fails.

use crate::progress::Cancelled;

/// Why a clip could not be retargeted.
#[derive(Debug, thiserror::Error)]
pub enum RetargetError {
    /// A parameter is not usable.
    #[error("retargeting parameter `{name}` = {value}: {expected}")]
    Parameter {
        /// Its name, as manifests spell it.
        name: &'static str,
        /// What was given.
        value: String,
        /// What is expected.
        expected: &'static str,
    },
    /// The two hands of a track have different numbers of frames.
    #[error("the hand track has {left} left and {right} right frames; expected as many of each")]
    TrackLengths {
        /// Left frames.
        left: usize,
        /// Right frames.
        right: usize,
    },
    /// Stopped from outside.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
