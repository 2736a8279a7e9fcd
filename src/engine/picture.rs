//! Pictures on demand.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use super::Revision;
use crate::{
    clip::FrameIndex,
    geometry::{Pinhole, Size},
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

impl OrbitCamera {
    /// Takes camera coordinates (x right, y down, z forward) to the torso's: who draws the robot and who draws over
    /// that picture both look from here.
    pub fn pose(&self) -> Isometry3<f64> {
        let (sin, cos) = self.azimuth.sin_cos();
        let (up, level) = self.elevation.sin_cos();
        let forward = Vector3::new(cos * level, sin * level, -up);
        let right = Vector3::new(sin, -cos, 0.0);
        let axes = Matrix3::from_columns(&[right, forward.cross(&right), forward]);
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        Isometry3::from_parts((self.target - self.distance * forward).into(), rotation)
    }

    /// The lens of a picture of `size`.
    pub fn pinhole(&self, size: Size) -> Pinhole {
        let focal = 0.5 * f64::from(size.height) / (0.5 * self.field_of_view).tan();
        let (cx, cy) = (0.5 * (f64::from(size.width) - 1.0), 0.5 * (f64::from(size.height) - 1.0));
        Pinhole { fx: focal, fy: focal, cx, cy, size }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pixel, Position};

    #[test]
    fn an_orbiting_camera_sees_its_target_in_the_middle_upright_and_from_behind_at_azimuth_0() {
        let size = Size::new(321, 241);
        for azimuth in [0.0, 1.0, -2.5] {
            let camera = OrbitCamera { azimuth, ..OrbitCamera::default() };
            let see = |point: Point3<f64>| {
                let seen = camera.pose().inverse() * point;
                camera.pinhole(size).project(&Position::new(seen.coords)).unwrap()
            };
            assert!(see(camera.target).distance(Pixel::new(160.0, 120.0)) < 1e-9);
            assert!(see(camera.target + 0.1 * Vector3::z()).y < 115.0, "up is up");
        }
        let behind = OrbitCamera { azimuth: 0.0, elevation: 0.0, ..OrbitCamera::default() }.pose();
        assert!(behind.translation.vector.x < -1.0);
        assert!(((behind.rotation * Vector3::x()) + Vector3::y()).norm() < 1e-12, "the robot's left is left");
    }
}
