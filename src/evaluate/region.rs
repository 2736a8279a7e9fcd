//! Mask measures of DAVIS (Perazzi et al. 2016): region J and boundary F.

use opencv::{core::Mat, imgproc, prelude::*};

use super::MetricError;
use crate::image::Mask;

/// Region similarity J: intersection over union; 1 when both are empty.
///
/// # Errors
/// [`MetricError::Size`] when the sizes differ.
pub fn region_j(mask: &Mask, truth: &Mask) -> Result<f64, MetricError> {
    check(mask, truth)?;
    Ok(mask.iou(truth))
}

/// Boundary measure F: harmonic mean of the shares of either boundary that lie within
/// 0.8 % of the diagonal of the other; 1 when both are empty.
///
/// # Errors
/// When the sizes differ or OpenCV fails.
pub fn boundary_f(mask: &Mask, truth: &Mask) -> Result<f64, MetricError> {
    check(mask, truth)?;
    let (found, wanted) = (boundary(mask), boundary(truth));
    match (found.is_empty(), wanted.is_empty()) {
        (true, true) => return Ok(1.0),
        (false, false) => {}
        _ => return Ok(0.0),
    }
    let tolerance = (0.008 * truth.size().diagonal()).ceil() as f32;
    let precision = share_near(&found, &wanted, tolerance)?;
    let recall = share_near(&wanted, &found, tolerance)?;
    let sum = precision + recall;
    Ok(if sum > 0.0 { 2.0 * precision * recall / sum } else { 0.0 })
}

fn check(mask: &Mask, truth: &Mask) -> Result<(), MetricError> {
    if mask.size() == truth.size() {
        return Ok(());
    }
    Err(MetricError::Size { expected: truth.size(), found: mask.size() })
}

/// Pixels that differ from their right, lower or lower right neighbour.
fn boundary(mask: &Mask) -> Mask {
    let size = mask.size();
    let (right, bottom) = (size.width.saturating_sub(1), size.height.saturating_sub(1));
    Mask::from_fn(size, |x, y| {
        let here = mask.get(x, y);
        let (x1, y1) = ((x + 1).min(right), (y + 1).min(bottom));
        here != mask.get(x1, y) || here != mask.get(x, y1) || here != mask.get(x1, y1)
    })
}

/// Share of `of`'s pixels that have a pixel of `near` within `tolerance`.
fn share_near(of: &Mask, near: &Mask, tolerance: f32) -> Result<f64, MetricError> {
    let outside = Mask::from_fn(near.size(), |x, y| !near.get(x, y));
    let mut distance = Mat::default();
    let precise = imgproc::DIST_MASK_PRECISE;
    imgproc::distance_transform(
        &outside.to_mat()?,
        &mut distance,
        imgproc::DIST_L2,
        precise,
        opencv::core::CV_32F,
    )?;
    let distance = distance.data_typed::<f32>()?;
    let hits = of.data().iter().zip(distance).filter(|(inside, d)| **inside != 0 && **d <= tolerance);
    Ok(hits.count() as f64 / of.area() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Size;

    fn square(x0: u32) -> Mask {
        Mask::from_fn(Size::new(200, 150), |x, y| (x0..x0 + 40).contains(&x) && (50..90).contains(&y))
    }

    #[test]
    fn the_true_mask_scores_one_and_a_distant_one_zero() {
        assert_eq!(boundary_f(&square(20), &square(20)).unwrap(), 1.0);
        assert_eq!(region_j(&square(20), &square(20)).unwrap(), 1.0);
        assert_eq!(boundary_f(&square(20), &square(120)).unwrap(), 0.0);
        assert_eq!(region_j(&square(20), &square(120)).unwrap(), 0.0);
    }

    #[test]
    fn a_shift_within_the_tolerance_costs_no_f_but_some_j() {
        assert_eq!(boundary_f(&square(21), &square(20)).unwrap(), 1.0);
        assert!((region_j(&square(21), &square(20)).unwrap() - 39.0 / 41.0).abs() < 1e-12);
    }

    #[test]
    fn empty_masks_agree_with_each_other_only() {
        let empty = Mask::new(Size::new(200, 150));
        assert_eq!(boundary_f(&empty, &empty).unwrap(), 1.0);
        assert_eq!(boundary_f(&empty, &square(20)).unwrap(), 0.0);
    }
}
