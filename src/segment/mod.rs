//! Object and arm mask tracks.

#[cfg(feature = "engine")]
pub mod arms;
mod coco_text;
#[cfg(feature = "engine")]
mod error;
#[cfg(feature = "engine")]
pub mod object;
mod rle;
#[cfg(feature = "engine")]
pub mod sam2;
mod track;

pub use coco_text::{CocoTextError, counts_from_text, text_from_counts};
#[cfg(feature = "engine")]
pub use error::SegmentError;
pub use rle::{RleError, RleMask};
pub use track::{ArmTrack, MaskAuthor, MaskFlag, MaskFrame, MaskTrack};
