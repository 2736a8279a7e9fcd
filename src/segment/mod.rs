//! Object and arm mask tracks.

#[cfg(feature = "engine")]
pub mod arms;
#[cfg(feature = "engine")]
mod error;
#[cfg(feature = "engine")]
pub mod object;
mod rle;
#[cfg(feature = "engine")]
pub mod sam2;
mod track;

#[cfg(feature = "engine")]
pub use error::SegmentError;
pub use rle::{RleError, RleMask};
pub use track::{ArmTrack, MaskAuthor, MaskFlag, MaskFrame, MaskTrack};
