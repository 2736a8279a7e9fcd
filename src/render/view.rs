//! A pinhole camera placed in the MuJoCo world.

use mujoco_rs::mujoco_c::mjvGLCamera;
use nalgebra::{Isometry3, Vector3};

use super::RenderError;
use crate::geometry::Pinhole;

/// Where a picture is taken from and through what lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraView {
    /// Intrinsics; the picture is drawn at `pinhole.size`.
    pub pinhole: Pinhole,
    /// Takes camera coordinates (OpenCV axes: x right, y down, z forward; metres) to the world.
    pub pose: Isometry3<f64>,
    /// Nothing nearer than this is drawn, metres along z.
    pub near: f64,
    /// Nothing farther than this is drawn, metres along z.
    pub far: f64,
}

impl CameraView {
    /// A camera at `pose` that sees from 2 cm to 20 m.
    pub fn new(pinhole: Pinhole, pose: Isometry3<f64>) -> Self {
        Self { pinhole, pose, near: 0.02, far: 20.0 }
    }

    /// The same camera as OpenGL wants it.
    ///
    /// With pixel centres at integers the picture spans `-0.5 .. width - 0.5`, so its left border lies at
    /// `(-0.5 - cx) / fx` on the plane z = 1, and the others likewise; the frustum may be off-centre and
    /// its pixels need not be square.
    pub(super) fn to_gl(self) -> Result<mjvGLCamera, RenderError> {
        let Pinhole { fx, fy, cx, cy, size } = self.pinhole;
        if !(self.near > 0.0 && self.far > self.near && self.far.is_finite()) {
            return Err(RenderError::Clipping { near: self.near, far: self.far });
        }
        let (width, height) = (f64::from(size.width), f64::from(size.height));
        let left = (-0.5 - cx) / fx * self.near;
        let right = (width - 0.5 - cx) / fx * self.near;
        let top = (cy + 0.5) / fy * self.near;
        let bottom = (cy + 0.5 - height) / fy * self.near;
        let rotation = self.pose.rotation;
        let camera = mjvGLCamera {
            pos: self.pose.translation.vector.cast::<f32>().into(),
            forward: (rotation * Vector3::z()).cast::<f32>().into(),
            up: (rotation * -Vector3::y()).cast::<f32>().into(),
            frustum_center: (0.5 * (left + right)) as f32,
            // MuJoCo takes half the width here.
            frustum_width: (0.5 * (right - left)) as f32,
            frustum_bottom: bottom as f32,
            frustum_top: top as f32,
            frustum_near: self.near as f32,
            frustum_far: self.far as f32,
            orthographic: 0,
        };
        let numbers = [left, right, top, bottom];
        let finite = numbers.iter().all(|v| v.is_finite())
            && camera.pos.iter().chain(&camera.forward).chain(&camera.up).all(|v| v.is_finite());
        if finite { Ok(camera) } else { Err(RenderError::NotFinite) }
    }
}
