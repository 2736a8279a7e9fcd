//! Pictures on demand.

use std::sync::Arc;

use nalgebra::Point3;

use super::Revision;
use crate::{
    clip::FrameIndex,
    geometry::Size,
    image::{Rgb8, Rgba8},
};

/// A view from outside onto the robot, torso frame (x forward, y left, z up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitCamera {
    /// The point it turns about, metres.
    pub target: Point3<f64>,
    /// Metres from the target.
    pub distance: f64,
    /// Radians about z; 0 looks along x from behind the robot.
    pub azimuth: f64,
    /// Radians above the horizon.
    pub elevation: f64,
    /// Vertical opening angle, radians.
    pub field_of_view: f64,
}

impl Default for OrbitCamera {
    fn default() -> Self {
        Self {
            target: Point3::new(0.25, 0.0, 0.15),
            distance: 1.3,
            azimuth: -2.5,
            elevation: 0.35,
            field_of_view: 0.7,
        }
    }
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PictureKind {
    /// The frame as filmed.
    Source,
    /// The finished frame and the layers it is made of.
    Composite,
    /// The robot on that frame from outside.
    Orbit {
        /// From where.
        camera: OrbitCamera,
        /// Size of the picture.
        size: Size,
    },
    /// The frame as filmed, small, for a filmstrip.
    Thumbnail {
        /// Pixels high.
        height: u32,
    },
}

/// A picture somebody wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureRequest {
    /// Of which frame.
    pub frame: FrameIndex,
    /// Of what.
    pub kind: PictureKind,
    /// For which document.
    pub revision: Revision,
}

/// The layers of one frame, back to front, and what they make together.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// The exported frame, pixel for pixel.
    pub composite: Rgb8,
    /// Without the human.
    pub background: Rgb8,
    /// All of the robot, straight alpha.
    pub robot: Rgba8,
    /// The object, straight alpha; `None` where it is absent.
    pub object: Option<Rgba8>,
    /// What of the robot lies over the object, straight alpha.
    pub front: Rgba8,
}

/// A picture that was wanted.
#[derive(Clone, Debug)]
pub enum Shown {
    /// One picture.
    Picture(Arc<Rgb8>),
    /// A composite with its layers.
    Layers(Arc<Layers>),
}
