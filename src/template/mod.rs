//! Clean-frame choice, the object template, its placement per frame.

#[cfg(feature = "engine")]
mod build;
mod by_hand;
#[cfg(feature = "engine")]
mod carry;
#[cfg(feature = "engine")]
mod clean;
#[cfg(feature = "engine")]
mod params;
#[cfg(feature = "engine")]
mod path;
#[cfg(feature = "engine")]
mod picture;
#[cfg(feature = "engine")]
mod placement;
#[cfg(feature = "engine")]
mod pose;
mod track;

#[cfg(feature = "engine")]
pub use build::build;
pub use by_hand::PlacedByHand;
#[cfg(feature = "engine")]
pub use params::{TemplateError, TemplateParams};
pub use track::{Placement, TemplateTrack};
