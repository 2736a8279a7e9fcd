//! Geometry shared by every stage: pixels, sizes, pinhole cameras, frames of reference.

mod frame;
mod pinhole;
mod pixel;
mod side;

pub use frame::{Camera, Frame, Pose, Position, Torso};
pub use pinhole::{Pinhole, PinholeError};
pub use pixel::{Pixel, PixelBox, Size};
pub use side::{PerSide, Side};
