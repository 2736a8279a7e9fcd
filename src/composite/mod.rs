//! The layer stack: cleaned background, full robot pass, object template, near parts of the robot.
//!
//! One compositor serves preview and export. Every edge is a soft alpha, every sum is done in a fixed
//! order, so the same layers give the same bytes everywhere.

mod compositor;
mod error;
mod object;
pub mod order;
mod params;

pub use compositor::{Composite, Compositor, FrameLayers};
pub use error::CompositeError;
pub use object::{ObjectEvidence, ObjectLayer, placed_shape};
pub use params::CompositeParams;
