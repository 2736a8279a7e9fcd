//! Why layers could not be put together.

use crate::geometry::Size;

/// Why layers could not be put together.
#[derive(Debug, thiserror::Error)]
pub enum CompositeError {
    /// A layer has another size than the background.
    #[error("{layer} is {found}, the background is {expected}: render every layer at the clip's size")]
    Size {
        /// Which layer.
        layer: &'static str,
        /// The background's size.
        expected: Size,
        /// The layer's size.
        found: Size,
    },
    /// A placement cannot be inverted.
    #[error("the template's placement is singular or not finite: place the template again on this frame")]
    Placement,
    /// Image processing failed.
    #[error("image processing failed while compositing: {0}")]
    Vision(#[from] opencv::Error),
}
