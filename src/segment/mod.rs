//! Object and arm mask tracks.

mod rle;
mod track;

pub use rle::{RleError, RleMask};
pub use track::{MaskAuthor, MaskFlag, MaskFrame, MaskTrack};
