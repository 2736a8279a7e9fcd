//! Clips: decode, standardise to 30 FPS, frame table, intrinsics.

#[cfg(feature = "engine")]
pub(crate) mod child;
#[cfg(feature = "engine")]
mod decode;
mod error;
mod frame_index;
mod frame_source;
mod frame_table;
mod info;
#[cfg(feature = "engine")]
mod open;
#[cfg(feature = "engine")]
mod probe;
mod request;
#[cfg(feature = "engine")]
mod store;
#[cfg(feature = "engine")]
mod timing;

pub use error::ClipError;
pub use frame_index::{FrameIndex, STANDARD_FPS};
pub use frame_source::{FrameError, FrameSource, FramesInMemory};
pub use frame_table::{Decision, FrameRow, Resampler, SourceTime};
pub use info::{ClipFlag, ClipInfo};
#[cfg(feature = "engine")]
pub use open::{MAX_FRAMES, StandardClip, content_hash, open};
#[cfg(feature = "engine")]
pub use probe::{MAX_PIXELS, StreamProbe, probe};
pub use request::{CameraSpec, ClipRequest, DEFAULT_FOV_DEG, Rotation};
#[cfg(feature = "engine")]
pub use store::{FrameStore, FrameStoreWriter, StoreError};
