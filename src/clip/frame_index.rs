//! Frame identity on the standard 30 FPS timeline.

use serde::{Deserialize, Serialize};

/// Frames per second of the standard timeline, of every record and of every exported video.
pub const STANDARD_FPS: f64 = 30.0;

/// The index of a frame on the standard 30 FPS timeline of one clip, from 0.
///
/// Looked up in the clip's frame table, never computed from a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct FrameIndex(pub u32);

impl FrameIndex {
    /// As an index into a slice with one element a frame.
    pub const fn as_usize(self) -> usize {
        self.0 as usize
    }

    /// All indices of a clip with `count` frames.
    pub fn all(count: usize) -> impl DoubleEndedIterator<Item = Self> + ExactSizeIterator + Clone {
        (0..count as u32).map(Self)
    }
}

impl std::fmt::Display for FrameIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "frame {}", self.0)
    }
}
