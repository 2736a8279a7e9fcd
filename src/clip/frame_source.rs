//! Random access to the frames of a standardised clip.

use super::FrameIndex;
use crate::{geometry::Size, image::Rgb8};

/// Frames of one size by index: a decoded clip, an inpainted plate, a list in memory.
///
/// Implementations are shared between threads and keep memory bounded by a window of frames.
pub trait FrameSource: Send + Sync {
    /// Number of frames.
    fn frame_count(&self) -> usize;

    /// The size of every frame.
    fn size(&self) -> Size;

    /// Frame `index`.
    ///
    /// # Errors
    /// When the index is beyond the end or the backing store cannot be read.
    fn frame(&self, index: FrameIndex) -> Result<Rgb8, FrameError>;
}

/// Why a frame could not be had.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// Beyond the end.
    #[error("{index} was asked for, but the clip has {count} frames")]
    OutOfRange {
        /// What was asked for.
        index: FrameIndex,
        /// Frames there are.
        count: usize,
    },
    /// The scratch file failed.
    #[error("cannot read {index} from {path}: {source}")]
    Io {
        /// What was asked for.
        index: FrameIndex,
        /// The scratch file.
        path: std::path::PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The scratch file holds something else.
    #[error("{index} in {path} is damaged: {reason}")]
    Damaged {
        /// What was asked for.
        index: FrameIndex,
        /// The scratch file.
        path: std::path::PathBuf,
        /// What was found.
        reason: String,
    },
}

/// Frames held in memory, for short sequences and tests.
#[derive(Debug, Clone)]
pub struct FramesInMemory {
    size: Size,
    frames: Vec<Rgb8>,
}

impl FramesInMemory {
    /// Takes `frames`; `None` when there are none or their sizes differ.
    pub fn new(frames: Vec<Rgb8>) -> Option<Self> {
        let size = frames.first()?.size();
        frames.iter().all(|frame| frame.size() == size).then_some(Self { size, frames })
    }
}

impl FrameSource for FramesInMemory {
    fn frame_count(&self) -> usize {
        self.frames.len()
    }

    fn size(&self) -> Size {
        self.size
    }

    fn frame(&self, index: FrameIndex) -> Result<Rgb8, FrameError> {
        let count = self.frames.len();
        self.frames.get(index.as_usize()).cloned().ok_or(FrameError::OutOfRange { index, count })
    }
}
