//! What to open: the file, how to turn it, its camera, which part of it.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::geometry::{Pinhole, PinholeError, Pixel, PixelBox, Size};

/// Horizontal field of view taken when nothing is known of the camera, degrees along the longer side.
///
/// Head-worn cameras lie at 85° to 105°, the main lens of a phone at 65° to 70°: 80° lies between.
pub const DEFAULT_FOV_DEG: f64 = 80.0;

/// A clip to open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClipRequest {
    /// The video file.
    pub path: PathBuf,
    /// Turn applied after the container's own rotation.
    #[serde(default)]
    pub rotate: Rotation,
    /// What is known of the camera.
    #[serde(default)]
    pub camera: CameraSpec,
    /// First second of the source that is used.
    #[serde(default)]
    pub start: Option<f64>,
    /// Second of the source where it ends, exclusive.
    #[serde(default)]
    pub end: Option<f64>,
}

impl ClipRequest {
    /// The whole of the file at `path`, unturned, with an unknown camera.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            rotate: Rotation::Deg0,
            camera: CameraSpec::Unknown,
            start: None,
            end: None,
        }
    }
}

/// What is known of the camera, for the picture as decoded (before [`ClipRequest::rotate`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraSpec {
    /// Pinhole intrinsics in pixels.
    Intrinsics {
        /// Focal length along x.
        fx: f64,
        /// Focal length along y.
        fy: f64,
        /// Principal point x.
        cx: f64,
        /// Principal point y.
        cy: f64,
    },
    /// Horizontal field of view, degrees.
    HorizontalFov(f64),
    /// Nothing: [`DEFAULT_FOV_DEG`] along the longer side is taken and the clip is flagged.
    #[default]
    Unknown,
}

impl CameraSpec {
    /// Intrinsics of the decoded picture of `size`, whose pixels are `aspect` times as wide as high.
    ///
    /// # Errors
    /// When the numbers given make no camera.
    pub fn pinhole(&self, size: Size, aspect: f64) -> Result<Pinhole, PinholeError> {
        match *self {
            Self::Intrinsics { fx, fy, cx, cy } => Pinhole::new(fx, fy, cx, cy, size),
            Self::HorizontalFov(degrees) => Self::with_fov(degrees, size, aspect),
            Self::Unknown => {
                let shown_width = f64::from(size.width) * aspect;
                let longer = shown_width.max(f64::from(size.height));
                let half = (0.5 * DEFAULT_FOV_DEG).to_radians().tan() * shown_width / longer;
                Self::with_fov(2.0 * half.atan().to_degrees(), size, aspect)
            }
        }
    }

    fn with_fov(degrees: f64, size: Size, aspect: f64) -> Result<Pinhole, PinholeError> {
        let square = Pinhole::from_horizontal_fov(degrees, size)?;
        Pinhole::new(square.fx, square.fx * aspect, square.cx, square.cy, size)
    }
}

/// A clockwise turn of the picture.
///
/// Written as clockwise degrees: 0, 90, 180 or 270.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "u32", into = "u32")]
pub enum Rotation {
    /// As decoded.
    #[default]
    Deg0,
    /// A quarter turn clockwise.
    Deg90,
    /// Upside down.
    Deg180,
    /// A quarter turn counter-clockwise.
    Deg270,
}

impl TryFrom<u32> for Rotation {
    type Error = String;
    fn try_from(degrees: u32) -> Result<Self, String> {
        let refused = || format!("rotate = {degrees}: expected 0, 90, 180 or 270 degrees clockwise");
        Self::from_degrees(degrees).ok_or_else(refused)
    }
}

impl From<Rotation> for u32 {
    fn from(rotation: Rotation) -> Self {
        rotation.degrees()
    }
}

impl Rotation {
    /// From clockwise degrees; `None` unless 0, 90, 180 or 270.
    pub const fn from_degrees(degrees: u32) -> Option<Self> {
        match degrees {
            0 => Some(Self::Deg0),
            90 => Some(Self::Deg90),
            180 => Some(Self::Deg180),
            270 => Some(Self::Deg270),
            _ => None,
        }
    }

    /// Clockwise degrees.
    pub const fn degrees(self) -> u32 {
        match self {
            Self::Deg0 => 0,
            Self::Deg90 => 90,
            Self::Deg180 => 180,
            Self::Deg270 => 270,
        }
    }

    /// The size of a turned picture.
    pub const fn size(self, decoded: Size) -> Size {
        match self {
            Self::Deg0 | Self::Deg180 => decoded,
            Self::Deg90 | Self::Deg270 => Size::new(decoded.height, decoded.width),
        }
    }

    /// Where pixel `p` of the decoded picture of size `decoded` lies once turned.
    pub fn pixel(self, p: Pixel, decoded: Size) -> Pixel {
        let right = f64::from(decoded.width) - 1.0;
        let bottom = f64::from(decoded.height) - 1.0;
        match self {
            Self::Deg0 => p,
            Self::Deg90 => Pixel::new(bottom - p.y, p.x),
            Self::Deg180 => Pixel::new(right - p.x, bottom - p.y),
            Self::Deg270 => Pixel::new(p.y, right - p.x),
        }
    }

    /// Where a box of the decoded picture of size `decoded` lies once turned.
    ///
    /// Box edges lie between pixels (`x1`, `y1` are exclusive), so they turn about the picture's edges.
    pub fn pixel_box(self, b: PixelBox, decoded: Size) -> PixelBox {
        let (w, h) = (f64::from(decoded.width), f64::from(decoded.height));
        let turn = |x: f64, y: f64| match self {
            Self::Deg0 => Pixel::new(x, y),
            Self::Deg90 => Pixel::new(h - y, x),
            Self::Deg180 => Pixel::new(w - x, h - y),
            Self::Deg270 => Pixel::new(y, w - x),
        };
        PixelBox::from_corners(turn(b.x0, b.y0), turn(b.x1, b.y1))
    }

    /// The camera of the turned picture.
    pub fn pinhole(self, camera: &Pinhole) -> Pinhole {
        let centre = self.pixel(Pixel::new(camera.cx, camera.cy), camera.size);
        let (fx, fy) = match self {
            Self::Deg0 | Self::Deg180 => (camera.fx, camera.fy),
            Self::Deg90 | Self::Deg270 => (camera.fy, camera.fx),
        };
        Pinhole { fx, fy, cx: centre.x, cy: centre.y, size: self.size(camera.size) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::new(7, 4);

    #[test]
    fn four_quarter_turns_restore_pixel_box_and_camera() {
        let camera = Pinhole::new(5.0, 6.0, 2.0, 1.0, SIZE).unwrap();
        let start = Pixel::new(1.0, 3.0);
        let start_box = PixelBox { x0: 1.0, y0: 0.0, x1: 3.0, y1: 2.0 };
        let (mut p, mut b, mut k) = (start, start_box, camera);
        for _ in 0..4 {
            let size = k.size;
            p = Rotation::Deg90.pixel(p, size);
            b = Rotation::Deg90.pixel_box(b, size);
            k = Rotation::Deg90.pinhole(&k);
        }
        assert_eq!((p, b, k), (start, start_box, camera));
    }

    #[test]
    fn a_turned_box_covers_the_turned_pixels() {
        let inside = PixelBox { x0: 1.0, y0: 2.0, x1: 3.0, y1: 4.0 };
        for rotation in [Rotation::Deg0, Rotation::Deg90, Rotation::Deg180, Rotation::Deg270] {
            let turned = rotation.pixel_box(inside, SIZE);
            assert_eq!(turned.area(), inside.area());
            for (x, y) in [(1.0, 2.0), (2.0, 2.0), (1.0, 3.0), (2.0, 3.0)] {
                assert!(turned.contains(rotation.pixel(Pixel::new(x, y), SIZE)), "{rotation:?}");
            }
        }
    }

    #[test]
    fn unknown_camera_spans_the_default_angle_along_the_longer_side() {
        for size in [Size::new(1920, 1080), Size::new(1080, 1920)] {
            let camera = CameraSpec::Unknown.pinhole(size, 1.0).unwrap();
            let longer = f64::from(size.width.max(size.height));
            let angle = 2.0 * (0.5 * longer / camera.fx).atan().to_degrees();
            assert!((angle - DEFAULT_FOV_DEG).abs() < 1e-9, "{angle}");
        }
    }
}
