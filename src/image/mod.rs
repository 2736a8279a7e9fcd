//! Plain pictures that own their bytes: what crosses a stage border.
//!
//! OpenCV matrices stay inside a stage; [`mat`] converts at its edge.

mod mask;
#[cfg(feature = "engine")]
pub mod mat;
mod picture;

pub use mask::Mask;
pub use picture::{Rgb8, Rgba8};
