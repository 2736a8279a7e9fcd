//! Object and arm mask tracks.

#[cfg(feature = "engine")]
pub mod arms;
#[cfg(feature = "engine")]
mod error;
#[cfg(feature = "engine")]
pub mod object;
mod rle;
mod track;

#[cfg(feature = "engine")]
pub use error::SegmentError;
pub use rle::{RleError, RleMask};
pub use track::{ArmTrack, MaskAuthor, MaskFlag, MaskFrame, MaskTrack};
