//! Clips: decode, standardise to 30 FPS, frame table, intrinsics.

mod frame_index;
mod frame_source;

pub use frame_index::{FrameIndex, STANDARD_FPS};
pub use frame_source::{FrameError, FrameSource, FramesInMemory};
