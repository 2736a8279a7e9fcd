//! Arithmetic of a placement: template pixels to frame pixels.

use agenticfocus::{geometry::Pixel, template::TemplateTrack};
use nalgebra::{Matrix3, Vector3};

/// Where `transform` takes a template pixel.
pub(super) fn apply(transform: &Matrix3<f64>, at: Pixel) -> Pixel {
    let v = transform * Vector3::new(at.x, at.y, 1.0);
    // A placement that runs through infinity has no sensible place; far away is as good as any.
    let w = if v.z.abs() < 1e-9 { 1e-9 } else { v.z };
    Pixel::new(v.x / w, v.y / w)
}

/// `transform` followed by a shift.
pub(super) fn moved(transform: &Matrix3<f64>, dx: f64, dy: f64) -> Matrix3<f64> {
    Matrix3::new(1.0, 0.0, dx, 0.0, 1.0, dy, 0.0, 0.0, 1.0) * transform
}

/// `transform` followed by a scaling and a turn about `centre` of the frame.
pub(super) fn turned(transform: &Matrix3<f64>, centre: Pixel, scale: f64, angle: f64) -> Matrix3<f64> {
    let (sin, cos) = angle.sin_cos();
    let (c, s) = (scale * cos, scale * sin);
    let (x, y) = (centre.x - c * centre.x + s * centre.y, centre.y - s * centre.x - c * centre.y);
    Matrix3::new(c, -s, x, s, c, y, 0.0, 0.0, 1.0) * transform
}

/// The tight rectangle of a template's visible pixels, its corners clockwise from the top left, as positions
/// on the template.
pub(super) fn frame_of(template: &TemplateTrack) -> [Pixel; 4] {
    let size = template.picture.size();
    let (mut low, mut high) = ((u32::MAX, u32::MAX), (0, 0));
    for (at, pixel) in template.picture.pixels().enumerate() {
        if pixel[3] > 127 {
            let (x, y) = (at as u32 % size.width, at as u32 / size.width);
            low = (low.0.min(x), low.1.min(y));
            high = (high.0.max(x), high.1.max(y));
        }
    }
    if low.0 > high.0 {
        (low, high) = ((0, 0), (size.width.saturating_sub(1), size.height.saturating_sub(1)));
    }
    let [x0, y0] = [low.0, low.1].map(|v| f64::from(v) - 0.5);
    let [x1, y1] = [high.0, high.1].map(|v| f64::from(v) + 0.5);
    [Pixel::new(x0, y0), Pixel::new(x1, y0), Pixel::new(x1, y1), Pixel::new(x0, y1)]
}

/// The middle of four corners.
pub(super) fn middle(corners: &[Pixel; 4]) -> Pixel {
    let sum = corners.iter().fold((0.0, 0.0), |sum, at| (sum.0 + at.x, sum.1 + at.y));
    Pixel::new(sum.0 / 4.0, sum.1 / 4.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_and_scaling_leave_the_centre_alone() {
        let start = moved(&Matrix3::identity(), 12.0, -7.0);
        let centre = Pixel::new(31.0, 9.0);
        let back = apply(&start.try_inverse().unwrap(), centre);
        let turned = turned(&start, centre, 1.7, 0.6);
        assert!(apply(&turned, back).distance(centre) < 1e-9);
        let beside = apply(&turned, Pixel::new(back.x + 10.0, back.y));
        assert!((beside.distance(centre) - 17.0).abs() < 1e-9);
        assert!(((beside.y - centre.y).atan2(beside.x - centre.x) - 0.6).abs() < 1e-9);
    }
}
