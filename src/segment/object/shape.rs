//! Small operations on binary shapes at work scale.

use opencv::{
    core::{CV_8UC1, CV_32S, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar},
    imgproc,
};

use crate::vision::Plane;

/// A CV_8UC1 matrix of 0 and 255 from bytes.
pub(crate) fn byte_mat(bytes: &[u8], width: usize, height: usize) -> opencv::Result<Mat> {
    let mut mat = Mat::new_rows_cols_with_default(height as i32, width as i32, CV_8UC1, Scalar::all(0.0))?;
    for (to, from) in mat.data_bytes_mut()?.iter_mut().zip(bytes) {
        *to = if *from != 0 { 255 } else { 0 };
    }
    Ok(mat)
}

/// Tight bounds `(x0, y0, x1, y1)`, exclusive at the end, of the non-zero bytes.
pub(crate) fn bounds_of(bytes: &[u8], width: usize) -> Option<(f64, f64, f64, f64)> {
    let (mut x0, mut x1, mut y0, mut y1) = (usize::MAX, 0, usize::MAX, 0);
    for (y, row) in bytes.chunks_exact(width).enumerate() {
        if let (Some(first), Some(last)) =
            (row.iter().position(|v| *v != 0), row.iter().rposition(|v| *v != 0))
        {
            (x0, x1) = (x0.min(first), x1.max(last + 1));
            (y0, y1) = (y0.min(y), y + 1);
        }
    }
    (x1 > 0).then_some((x0 as f64, y0 as f64, x1 as f64, y1 as f64))
}

/// Distance to the border in pixels, positive inside; ±0.5 beside it.
pub(crate) fn signed_distance(bytes: &[u8], width: usize, height: usize) -> opencv::Result<Plane> {
    let inside = byte_mat(bytes, width, height)?;
    let mut outside = Mat::default();
    opencv::core::bitwise_not(&inside, &mut outside, &opencv::core::no_array())?;
    let distance = |mat: &Mat| -> opencv::Result<Plane> {
        let mut out = Mat::default();
        imgproc::distance_transform(
            mat,
            &mut out,
            imgproc::DIST_L2,
            imgproc::DIST_MASK_PRECISE,
            opencv::core::CV_32F,
        )?;
        Plane::from_mat(&out)
    };
    let (mut plane, away) = (distance(&inside)?, distance(&outside)?);
    // A shape without an outside (or an inside) has no border: very far from everything.
    let far = (width + height) as f32;
    for (value, away) in plane.data.iter_mut().zip(&away.data) {
        *value = if *value > 0.0 { value.min(far) - 0.5 } else { 0.5 - away.min(far) };
    }
    Ok(plane)
}

/// Keeps the components of `shape` for which `keep(area, overlap with anchor)` holds.
pub(crate) fn keep_components(
    shape: &mut [u8],
    width: usize,
    height: usize,
    anchor: impl Fn(usize) -> bool,
    keep: impl Fn(usize, usize) -> bool,
) -> opencv::Result<()> {
    let mut labels = Mat::default();
    let count = imgproc::connected_components(&byte_mat(shape, width, height)?, &mut labels, 4, CV_32S)?;
    let labels = labels.data_typed::<i32>()?;
    let mut sums = vec![(0_usize, 0_usize); count as usize];
    for (at, label) in labels.iter().enumerate() {
        let sum = &mut sums[*label as usize];
        *sum = (sum.0 + 1, sum.1 + usize::from(anchor(at)));
    }
    for (at, label) in labels.iter().enumerate() {
        let sum = sums[*label as usize];
        if *label != 0 && !keep(sum.0, sum.1) {
            shape[at] = 0;
        }
    }
    Ok(())
}

/// Fills holes of up to `largest` pixels where `allowed`.
pub(crate) fn fill_holes(
    shape: &mut [u8],
    width: usize,
    height: usize,
    largest: usize,
    allowed: impl Fn(usize) -> bool,
) -> opencv::Result<()> {
    let inverse: Vec<u8> = shape.iter().map(|v| u8::from(*v == 0)).collect();
    let (mut labels, mut stats, mut centres) = (Mat::default(), Mat::default(), Mat::default());
    let count = imgproc::connected_components_with_stats(
        &byte_mat(&inverse, width, height)?,
        &mut labels,
        &mut stats,
        &mut centres,
        4,
        CV_32S,
    )?;
    let mut fill = vec![false; count as usize];
    for (label, fill) in fill.iter_mut().enumerate().skip(1) {
        let stat = |column: i32| stats.at_2d::<i32>(label as i32, column).copied();
        let (x, y, w, h, area) = (stat(0)?, stat(1)?, stat(2)?, stat(3)?, stat(4)?);
        let touches = x == 0 || y == 0 || x + w == width as i32 || y + h == height as i32;
        *fill = !touches && area as usize <= largest;
    }
    for (at, label) in labels.data_typed::<i32>()?.iter().enumerate() {
        if fill[*label as usize] && allowed(at) {
            shape[at] = 1;
        }
    }
    Ok(())
}

/// Intersection over union of two shapes; 1 when both are empty.
pub(crate) fn iou(a: &[u8], b: &[u8]) -> f64 {
    let (mut both, mut either) = (0_u32, 0_u32);
    for (a, b) in a.iter().zip(b) {
        both += u32::from(*a != 0 && *b != 0);
        either += u32::from(*a != 0 || *b != 0);
    }
    if either == 0 { 1.0 } else { f64::from(both) / f64::from(either) }
}
