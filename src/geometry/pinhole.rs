//! The pinhole camera.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::{Camera, Pixel, Position, Size};

/// Pinhole intrinsics in pixels of a picture of `size`; the principal point may lie off-centre.
///
/// A pixel's centre has integer coordinates, so the exact centre of the picture is
/// `((width - 1) / 2, (height - 1) / 2)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pinhole {
    /// Focal length along x, pixels.
    pub fx: f64,
    /// Focal length along y, pixels.
    pub fy: f64,
    /// Principal point x, pixels.
    pub cx: f64,
    /// Principal point y, pixels.
    pub cy: f64,
    /// The picture these intrinsics belong to.
    pub size: Size,
}

/// Why intrinsics were refused.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum PinholeError {
    /// Not finite or not positive.
    #[error("{name} = {value}: expected a finite value above zero")]
    NotPositive {
        /// The parameter's name.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// The field of view is not between 0° and 180°.
    #[error("hfov_deg = {0}: expected an angle above 0 and below 180")]
    FieldOfView(f64),
    /// The principal point is not finite.
    #[error("principal point ({0}, {1}) is not finite")]
    PrincipalPoint(f64, f64),
}

impl Pinhole {
    /// Checked intrinsics.
    ///
    /// # Errors
    /// When a focal length is not positive or anything is not finite.
    pub fn new(fx: f64, fy: f64, cx: f64, cy: f64, size: Size) -> Result<Self, PinholeError> {
        for (name, value) in [("fx", fx), ("fy", fy)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(PinholeError::NotPositive { name, value });
            }
        }
        if !(cx.is_finite() && cy.is_finite()) {
            return Err(PinholeError::PrincipalPoint(cx, cy));
        }
        Ok(Self { fx, fy, cx, cy, size })
    }

    /// Square pixels, centred principal point, horizontal field of view in degrees.
    ///
    /// # Errors
    /// When the angle is not inside (0°, 180°).
    pub fn from_horizontal_fov(degrees: f64, size: Size) -> Result<Self, PinholeError> {
        if !(degrees > 0.0 && degrees < 180.0) {
            return Err(PinholeError::FieldOfView(degrees));
        }
        let focal = 0.5 * f64::from(size.width) / (0.5 * degrees.to_radians()).tan();
        let (cx, cy) = (0.5 * f64::from(size.width), 0.5 * f64::from(size.height));
        Self::new(focal, focal, cx, cy, size)
    }

    /// Projects a camera point; `None` at or behind the camera plane.
    pub fn project(&self, point: &Position<Camera>) -> Option<Pixel> {
        let p = point.xyz;
        (p.z > 1e-9).then(|| Pixel::new(self.fx * p.x / p.z + self.cx, self.fy * p.y / p.z + self.cy))
    }

    /// The point at `depth` metres (along z) behind pixel `pixel`.
    pub fn unproject(&self, pixel: Pixel, depth: f64) -> Position<Camera> {
        Position::new(Vector3::new(
            (pixel.x - self.cx) / self.fx * depth,
            (pixel.y - self.cy) / self.fy * depth,
            depth,
        ))
    }

    /// The 3×3 camera matrix K.
    pub fn matrix(&self) -> Matrix3<f64> {
        Matrix3::new(self.fx, 0.0, self.cx, 0.0, self.fy, self.cy, 0.0, 0.0, 1.0)
    }

    /// The same camera for the picture resized to `size`.
    pub fn resized(&self, size: Size) -> Self {
        let sx = f64::from(size.width) / f64::from(self.size.width);
        let sy = f64::from(size.height) / f64::from(self.size.height);
        Self {
            fx: self.fx * sx,
            fy: self.fy * sy,
            cx: (self.cx + 0.5) * sx - 0.5,
            cy: (self.cy + 0.5) * sy - 0.5,
            size,
        }
    }
}
