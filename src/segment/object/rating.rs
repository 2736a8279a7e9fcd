//! How much a cut inside a prompt looks like one whole object.

use opencv::{
    core::{Mat, Point, Vector},
    imgproc,
};

use super::{
    seed::Hints,
    shape::{bounds_of, byte_mat, signed_distance},
    view::{View, arm},
};
use crate::{segment::SegmentError, vision::ColourModel};

/// Higher is better, about 0 to 4: contrast along the border, colours unlike the surroundings, all four
/// sides of the box reached, a solid outline, agreement with what moves.
pub(super) fn rate(view: &View, hints: &Hints, shape: &[u8]) -> Result<f64, SegmentError> {
    let (width, height) = (hints.roi.width, hints.roi.height);
    let area = shape.iter().filter(|v| **v != 0).count() as f64;
    let Some(tight) = bounds_of(shape, width).filter(|_| area >= 16.0) else { return Ok(-1.0) };
    let lab = hints.roi.crop(&view.lab, view.width);
    let classes = hints.roi.crop(&view.arms, view.width);
    let distance = signed_distance(shape, width, height)?;
    let learn = |inside: bool| {
        let fits = |at: usize| {
            let d = distance.data[at];
            if inside { d > 0.0 } else { d < -1.5 && classes[at] < arm::MASK }
        };
        ColourModel::learn(lab.iter().enumerate().filter(|(at, _)| fits(*at)).map(|(_, lab)| (*lab, 1.0)))
    };
    let unlike = match (learn(true), learn(false)) {
        (Some(object), Some(around)) => object.distance(&around),
        _ => 0.0,
    };
    let contrast = border_contrast(&lab, &distance.data, width, height);
    let reach = hints.bounds.map_or(0.5, |bounds| {
        let (w, h) = (bounds.2 - bounds.0, bounds.3 - bounds.1);
        let gaps = (tight.0 - bounds.0).max(0.0) / w
            + (bounds.2 - tight.2).max(0.0) / w
            + (tight.1 - bounds.1).max(0.0) / h
            + (bounds.3 - tight.3).max(0.0) / h;
        (-4.0 * gaps).exp()
    });
    let solid = area / hull_area(shape, width, height)?.max(1.0);
    let moving = hints.moving.as_ref().map_or(0.0, |moving| super::shape::iou(moving, shape));
    Ok(0.8 * contrast + 1.2 * unlike + 0.7 * reach + 1.2 * solid.min(1.0) + 1.5 * moving)
}

/// Mean colour step across the border, d / (d + 25) in Lab levels, 0 to 1.
fn border_contrast(lab: &[[u8; 3]], distance: &[f32], width: usize, height: usize) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    let step = 2_usize;
    for y in step..height - step {
        for x in step..width - step {
            let at = y * width + x;
            if distance[at].abs() > 0.6 {
                continue;
            }
            // Across the border along the distance's own gradient.
            let gx = distance[at + 1] - distance[at - 1];
            let gy = distance[at + width] - distance[at - width];
            let norm = gx.hypot(gy).max(1e-3);
            let offset = |sign: f32| {
                let px = (x as f32 + sign * step as f32 * gx / norm).round() as usize;
                let py = (y as f32 + sign * step as f32 * gy / norm).round() as usize;
                lab[py * width + px]
            };
            let (inner, outer) = (offset(1.0), offset(-1.0));
            let squared = |c: usize| (f64::from(inner[c]) - f64::from(outer[c])).powi(2);
            let d = (squared(0) + squared(1) + squared(2)).sqrt();
            sum += d / (d + 25.0);
            count += 1.0;
        }
    }
    sum / f64::max(count, 1.0)
}

/// Area of the convex hull of all pixels of the shape.
fn hull_area(shape: &[u8], width: usize, height: usize) -> Result<f64, SegmentError> {
    let mat: Mat = byte_mat(shape, width, height)?;
    let mut points = Vector::<Point>::new();
    opencv::core::find_non_zero(&mat, &mut points)?;
    let mut hull = Vector::<Point>::new();
    imgproc::convex_hull(&points, &mut hull, false, true)?;
    Ok(imgproc::contour_area(&hull, false)?)
}
