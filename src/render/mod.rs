//! MuJoCo off-screen passes.
//!
//! [`Offscreen`] draws any MuJoCo model through an exact [`Pinhole`](crate::geometry::Pinhole) camera
//! without a display. [`RobotRenderer`] draws the robot as its virtual camera sees it and cuts it into
//! [`RobotLayers`] for the compositor.

mod egl;
mod error;
mod layers;
mod offscreen;
mod orbit;
mod parts;
mod robot;
mod view;

pub use egl::{DeviceChoice, describe_device};
pub use error::RenderError;
pub use layers::{Coverage, LayerRequest, NearParts, RobotLayers};
pub use offscreen::{GeomFilter, Lighting, Offscreen, RenderOptions, RenderedView, StudioLight};
pub use orbit::OrbitRenderer;
pub use robot::{RobotRenderParams, RobotRenderer};
pub use view::CameraView;
