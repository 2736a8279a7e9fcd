//! Why segmentation failed.

use crate::{
    clip::{FrameError, FrameIndex},
    geometry::Size,
    onnx::OnnxError,
    progress::Cancelled,
};

/// Why a mask track could not be made.
#[derive(Debug, thiserror::Error)]
pub enum SegmentError {
    /// A frame could not be read.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Image processing failed.
    #[error("image processing failed while making masks: {0}")]
    Vision(#[from] opencv::Error),
    /// The scratch file failed.
    #[error("the scratch file for mask making in {} failed: {source}; is the disk full?", path.display())]
    Scratch {
        /// Its folder.
        path: std::path::PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The network failed.
    #[error("the segmentation network failed: {0}")]
    Network(#[from] OnnxError),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// There is nothing to start from.
    #[error("no object prompt was given: give a box, points or a mask on at least one frame")]
    NoPrompt,
    /// A prompt cannot be used.
    #[error("the object prompt on {frame} cannot be used: {reason}")]
    Prompt {
        /// The prompt's frame.
        frame: FrameIndex,
        /// What is wrong with it and what is expected.
        reason: String,
    },
    /// An input made for another clip.
    #[error("{what} covers {found} frames of {found_size}, the clip has {expected} of {expected_size}")]
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

impl SegmentError {
    /// What the network broke down on, where it was the network.
    pub fn of_model(&self) -> Option<&OnnxError> {
        if let Self::Network(error) = self { Some(error) } else { None }
    }
}
