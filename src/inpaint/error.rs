//! Why the background could not be restored.

use crate::{clip::FrameError, geometry::Size, onnx::OnnxError, progress::Cancelled};

/// Why the background could not be restored.
#[derive(Debug, thiserror::Error)]
pub enum InpaintError {
    /// A frame could not be read.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Image processing failed.
    #[error("image processing failed while restoring the background: {0}")]
    Vision(#[from] opencv::Error),
    /// The network failed.
    #[error("the background network failed: {0}")]
    Network(#[from] OnnxError),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The receiver of the finished frames failed.
    #[error("a restored frame could not be stored: {0}")]
    Sink(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// An input made for another clip.
    #[error(
        "{what} covers {found} frames of {found_size}, the clip has {expected} of {expected_size}: make it again for this clip"
    )]
    Mismatch {
        /// Which input.
        what: &'static str,
        /// Its frames.
        found: usize,
        /// Its picture size.
        found_size: Size,
        /// The clip's frames.
        expected: usize,
        /// The clip's picture size.
        expected_size: Size,
    },
}

impl InpaintError {
    /// What the network broke down on, where it was the network.
    pub fn of_model(&self) -> Option<&OnnxError> {
        if let Self::Network(error) = self { Some(error) } else { None }
    }
}
