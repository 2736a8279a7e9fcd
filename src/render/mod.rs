//! MuJoCo off-screen passes.
//!
//! [`Offscreen`] draws any MuJoCo model through an exact [`Pinhole`](crate::geometry::Pinhole) camera
//! without a display.

mod egl;
mod error;
mod offscreen;
mod view;

pub use egl::{DeviceChoice, describe_device};
pub use error::RenderError;
pub use offscreen::{GeomFilter, Lighting, Offscreen, RenderOptions, RenderedView, StudioLight};
pub use view::CameraView;
