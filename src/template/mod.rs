//! Clean-frame choice, the object template, its placement per frame.

mod track;

pub use track::{Placement, TemplateTrack};
