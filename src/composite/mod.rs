//! The layer stack: cleaned background, full robot pass, object template, near parts of the robot.
//!
//! One compositor serves preview and export. Every edge is a soft alpha, every sum is done in a fixed
//! order, so the same layers give the same bytes everywhere.

#[cfg(feature = "engine")]
mod compositor;
mod decision;
#[cfg(feature = "engine")]
mod error;
#[cfg(feature = "engine")]
mod object;
#[cfg(feature = "engine")]
pub mod order;
#[cfg(feature = "engine")]
mod params;

#[cfg(feature = "engine")]
pub use compositor::{Composite, Compositor, FrameLayers, front_layer};
pub use decision::LayerDecision;
#[cfg(feature = "engine")]
pub use error::CompositeError;
#[cfg(feature = "engine")]
pub use object::{ObjectEvidence, ObjectLayer, placed_shape};
#[cfg(feature = "engine")]
pub use params::CompositeParams;
