//! What tools do to a mask: pure operations on pixels, each telling which rectangle it touched.
//!
//! Positions are [`Pixel`](agenticfocus::geometry::Pixel)s, so a pixel's centre has integer coordinates. Whatever
//! comes in, a position that is no number or far away, the work stays inside the picture.

mod area;
mod grow;
mod holes;
mod outline;
mod polygon;
mod side_split;
mod stroke;

pub use area::Area;
pub use grow::{grow, shrink};
pub use holes::fill_holes;
pub use outline::{Outline, outline};
pub use polygon::{fill_box, fill_polygon};
pub use side_split::SideSplit;
pub use stroke::stroke;
