//! A view of the object that others are aligned to.

use nalgebra::Matrix3;
use opencv::{
    core::{BORDER_CONSTANT, Mat, Scalar},
    imgproc,
};

use super::{
    shape::{bounds_of, signed_distance},
    view::{Roi, View},
};
use crate::{
    segment::SegmentError,
    vision::{AlignPoint, Plane},
};

/// A frame on which the object's whole shape is known, cropped around it.
#[derive(Clone)]
pub(crate) struct Keyframe {
    /// Where the crop lies on its frame.
    pub roi: Roi,
    /// The shape, 0 or 1, in the crop.
    pub shape: Plane,
    /// Samples of brightness inside the shape; positions on the frame.
    pub texture: Vec<AlignPoint>,
    /// Samples of the shape around its border; positions on the frame.
    pub outline: Vec<AlignPoint>,
    /// Tight bounds of the shape on its frame.
    tight: (f64, f64, f64, f64),
    /// Centre of the shape on the frame.
    pub centre: (f64, f64),
    /// Radius of the disc of the shape's area.
    pub radius: f64,
    /// Pixels of the shape.
    pub area: f64,
}

impl Keyframe {
    /// Cuts `shape` (0 or 1 a pixel of the work picture) out of `view`; `None` when it is empty.
    pub fn new(view: &View, shape: &[u8]) -> Result<Option<Self>, SegmentError> {
        let Some(bounds) = bounds_of(shape, view.width) else { return Ok(None) };
        let roi = Roi::around(bounds, 14.0, view.width, view.height);
        let cropped = roi.crop(shape, view.width);
        let plane = Plane {
            width: roi.width,
            height: roi.height,
            data: cropped.iter().map(|v| f32::from(u8::from(*v != 0))).collect(),
        };
        let gray = roi.crop_plane(&view.gray_plane).blurred(0.8)?;
        let distance = signed_distance(&cropped, roi.width, roi.height)?;
        let soft = plane.blurred(1.5)?;
        let (mut sum, mut area) = ((0.0, 0.0), 0.0_f64);
        for (at, value) in cropped.iter().enumerate() {
            if *value != 0 {
                sum = (sum.0 + (at % roi.width) as f64, sum.1 + (at / roi.width) as f64);
                area += 1.0;
            }
        }
        let centre = (sum.0 / area + roi.x as f64, sum.1 / area + roi.y as f64);
        Ok(Some(Self {
            texture: texture_points(&gray, &distance, &roi, area),
            outline: outline_points(&soft, &distance, &roi),
            roi,
            tight: bounds,
            shape: plane,
            centre,
            radius: (area / std::f64::consts::PI).sqrt().max(3.0),
            area,
        }))
    }

    /// The shape carried to another frame by `transform`, drawn on `roi` there, 0 to 1.
    pub fn place(&self, transform: &Matrix3<f64>, roi: &Roi) -> opencv::Result<Plane> {
        Plane::from_mat(&self.carry(&self.shape.to_mat()?, transform, roi)?)
    }

    /// A picture of this crop carried to another frame by `transform`, drawn on `roi` there, 0 beside it.
    pub fn carry(&self, picture: &Mat, transform: &Matrix3<f64>, roi: &Roi) -> opencv::Result<Mat> {
        let shift = |x: f64, y: f64| Matrix3::new(1.0, 0.0, x, 0.0, 1.0, y, 0.0, 0.0, 1.0);
        let full =
            shift(-(roi.x as f64), -(roi.y as f64)) * transform * shift(self.roi.x as f64, self.roi.y as f64);
        let rows = [0, 1, 2].map(|r| [full[(r, 0)], full[(r, 1)], full[(r, 2)]]);
        let matrix = Mat::from_slice_2d(&rows)?;
        let mut out = Mat::default();
        let size = opencv::core::Size::new(roi.width as i32, roi.height as i32);
        let (linear, zero) = (imgproc::INTER_LINEAR, Scalar::all(0.0));
        imgproc::warp_perspective(picture, &mut out, &matrix, size, linear, BORDER_CONSTANT, zero)?;
        Ok(out)
    }

    /// Whether two placements lie within `tolerance` pixels of each other.
    pub fn near(&self, a: &Matrix3<f64>, b: &Matrix3<f64>, tolerance: f64) -> bool {
        let ((x, y), r) = (self.centre, self.radius);
        [(x - r, y), (x + r, y), (x, y + r)].iter().all(|(x, y)| {
            let (a, b) = (apply(a, *x, *y), apply(b, *x, *y));
            (a.0 - b.0).hypot(a.1 - b.1) < tolerance
        })
    }

    /// Corners of the crop's shape box carried by `transform`: `(x0, y0, x1, y1)`.
    pub fn bounds(&self, transform: &Matrix3<f64>) -> (f64, f64, f64, f64) {
        let (x0, y0, x1, y1) = self.tight;
        let mut bounds = (f64::MAX, f64::MAX, f64::MIN, f64::MIN);
        for (x, y) in [(x0, y0), (x1, y0), (x0, y1), (x1, y1)] {
            let p = apply(transform, x, y);
            bounds = (bounds.0.min(p.0), bounds.1.min(p.1), bounds.2.max(p.0), bounds.3.max(p.1));
        }
        bounds
    }
}

/// Applies a projective transform to a pixel.
pub(crate) fn apply(transform: &Matrix3<f64>, x: f64, y: f64) -> (f64, f64) {
    let v = transform * nalgebra::Vector3::new(x, y, 1.0);
    let w = if v.z.abs() < 1e-9 { 1e-9 } else { v.z };
    (v.x / w, v.y / w)
}

/// The turn by `angle` about `pivot`.
pub(crate) fn turned_about(pivot: (f64, f64), angle: f64) -> Matrix3<f64> {
    similarity(1.0, angle, pivot, pivot)
}

/// A similarity whose scale stays within `most` (a logarithm) of 1, that moves `place` as before.
pub(crate) fn with_growth_within(transform: &Matrix3<f64>, place: (f64, f64), most: f64) -> Matrix3<f64> {
    let to = apply(transform, place.0, place.1);
    let scale = transform[(0, 0)].hypot(transform[(1, 0)]).max(1e-6).ln().clamp(-most, most).exp();
    similarity(scale, transform[(1, 0)].atan2(transform[(0, 0)]), place, to)
}

/// The similarity that turns by `angle`, scales by `scale` and takes `from` to `to`.
pub(crate) fn similarity(scale: f64, angle: f64, from: (f64, f64), to: (f64, f64)) -> Matrix3<f64> {
    let (sin, cos) = angle.sin_cos();
    let (c, s) = (scale * cos, scale * sin);
    let x = to.0 - c * from.0 + s * from.1;
    let y = to.1 - s * from.0 - c * from.1;
    Matrix3::new(c, -s, x, s, c, y, 0.0, 0.0, 1.0)
}

/// Interior samples: denser where there is texture, about seven hundred.
fn texture_points(gray: &Plane, distance: &Plane, roi: &Roi, area: f64) -> Vec<AlignPoint> {
    let step = ((area / 700.0).sqrt().ceil() as usize).max(1);
    let mut points = Vec::new();
    for y in (1..roi.height - 1).step_by(step) {
        for x in (1..roi.width - 1).step_by(step) {
            if distance.at(x, y) < 1.5 {
                continue;
            }
            let gx = gray.at(x + 1, y) - gray.at(x - 1, y);
            let gy = gray.at(x, y + 1) - gray.at(x, y - 1);
            let weight = 0.2 + (0.5 * gx.hypot(gy) / 12.0).min(1.0);
            let (x_frame, y_frame) = ((x + roi.x) as f64, (y + roi.y) as f64);
            points.push(AlignPoint { x: x_frame, y: y_frame, value: gray.at(x, y), weight });
        }
    }
    points
}

/// Samples of the softened shape within 6 pixels of its border.
fn outline_points(soft: &Plane, distance: &Plane, roi: &Roi) -> Vec<AlignPoint> {
    let band = |d: f32| d.abs() <= 6.0;
    let count = distance.data.iter().filter(|d| band(**d)).count();
    let step = ((count as f64 / 700.0).sqrt().ceil() as usize).max(1);
    let mut points = Vec::new();
    for y in (0..roi.height).step_by(step) {
        for x in (0..roi.width).step_by(step) {
            if band(distance.at(x, y)) {
                let (x_frame, y_frame) = ((x + roi.x) as f64, (y + roi.y) as f64);
                points.push(AlignPoint { x: x_frame, y: y_frame, value: soft.at(x, y), weight: 1.0 });
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_limited_about_a_place_that_moves_as_before() {
        let flow = similarity(0.9, 0.2, (30.0, 40.0), (33.0, 38.0));
        let limited = with_growth_within(&flow, (30.0, 40.0), 0.01);
        let to = apply(&limited, 30.0, 40.0);
        assert!((to.0 - 33.0).hypot(to.1 - 38.0) < 1e-9);
        assert!((limited[(0, 0)].hypot(limited[(1, 0)]).ln() + 0.01).abs() < 1e-9);
        assert!((limited[(1, 0)].atan2(limited[(0, 0)]) - 0.2).abs() < 1e-9);
    }
}
