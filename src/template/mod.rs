//! Clean-frame choice, the object template, its placement per frame.

#[cfg(feature = "engine")]
mod build;
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
#[cfg(feature = "engine")]
pub use params::{TemplateError, TemplateParams};
pub use track::{Placement, TemplateTrack};
