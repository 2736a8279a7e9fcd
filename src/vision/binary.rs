//! Small operations on binary matrices (CV_8UC1, 0 or 255).

use opencv::{
    core::{CV_8UC1, CV_32S, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Point, Scalar, Size},
    imgproc,
};

/// An empty mask of `rows` by `cols`.
///
/// # Errors
/// When OpenCV cannot allocate.
pub fn empty(rows: i32, cols: i32) -> opencv::Result<Mat> {
    Mat::new_rows_cols_with_default(rows, cols, CV_8UC1, Scalar::all(0.0))
}

fn disc(radius: i32) -> opencv::Result<Mat> {
    let side = Size::new(2 * radius + 1, 2 * radius + 1);
    imgproc::get_structuring_element(imgproc::MORPH_ELLIPSE, side, Point::new(-1, -1))
}

fn morphed(mask: &Mat, operation: i32, radius: i32) -> opencv::Result<Mat> {
    if radius <= 0 {
        return mask.try_clone();
    }
    let mut out = Mat::default();
    let (anchor, border) = (Point::new(-1, -1), opencv::core::BORDER_REPLICATE);
    imgproc::morphology_ex(mask, &mut out, operation, &disc(radius)?, anchor, 1, border, Scalar::default())?;
    Ok(out)
}

/// Grown by a disc of `radius` pixels.
///
/// # Errors
/// When OpenCV fails.
pub fn dilated(mask: &Mat, radius: i32) -> opencv::Result<Mat> {
    morphed(mask, imgproc::MORPH_DILATE, radius)
}

/// Shrunk by a disc of `radius` pixels; the picture's border does not eat into the mask.
///
/// # Errors
/// When OpenCV fails.
pub fn eroded(mask: &Mat, radius: i32) -> opencv::Result<Mat> {
    morphed(mask, imgproc::MORPH_ERODE, radius)
}

/// Gaps up to twice `radius` closed.
///
/// # Errors
/// When OpenCV fails.
pub fn closed(mask: &Mat, radius: i32) -> opencv::Result<Mat> {
    morphed(mask, imgproc::MORPH_CLOSE, radius)
}

/// Specks and bridges up to twice `radius` wide removed.
///
/// # Errors
/// When OpenCV fails.
pub fn opened(mask: &Mat, radius: i32) -> opencv::Result<Mat> {
    morphed(mask, imgproc::MORPH_OPEN, radius)
}

/// One connected component (8-neighbourhood).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Its label in the label matrix.
    pub label: i32,
    /// Its pixels.
    pub area: i32,
    /// Left, top, width, height of its bounding box.
    pub bounds: (i32, i32, i32, i32),
    /// Its centroid, x and y.
    pub centroid: (f64, f64),
}

/// The components of `mask` and the label (0 outside) of every pixel, row after row.
///
/// # Errors
/// When OpenCV fails.
pub fn components(mask: &Mat) -> opencv::Result<(Vec<Component>, Vec<i32>)> {
    let (mut labels, mut stats, mut centroids) = (Mat::default(), Mat::default(), Mat::default());
    let count =
        imgproc::connected_components_with_stats(mask, &mut labels, &mut stats, &mut centroids, 8, CV_32S)?;
    let mut found = Vec::new();
    for label in 1..count {
        let stat = |column: i32| stats.at_2d::<i32>(label, column).copied();
        let bounds = (stat(0)?, stat(1)?, stat(2)?, stat(3)?);
        let centroid = (*centroids.at_2d::<f64>(label, 0)?, *centroids.at_2d::<f64>(label, 1)?);
        found.push(Component { label, area: stat(4)?, bounds, centroid });
    }
    Ok((found, labels.data_typed::<i32>()?.to_vec()))
}

/// The components of `mask` that share a pixel with `seed`.
///
/// # Errors
/// When OpenCV fails.
pub fn touching(mask: &Mat, seed: &Mat) -> opencv::Result<Mat> {
    let (found, labels) = components(mask)?;
    let mut keep = vec![false; found.len() + 1];
    for (label, seed) in labels.iter().zip(seed.data_bytes()?) {
        keep[*label as usize] |= *seed != 0 && *label != 0;
    }
    by_label(mask, &labels, &keep)
}

/// The pixels of `mask` whose label is to be kept.
///
/// # Errors
/// When OpenCV fails.
pub fn by_label(mask: &Mat, labels: &[i32], keep: &[bool]) -> opencv::Result<Mat> {
    let mut out = empty(mask.rows(), mask.cols())?;
    for (value, label) in out.data_bytes_mut()?.iter_mut().zip(labels) {
        *value = if keep[*label as usize] { 255 } else { 0 };
    }
    Ok(out)
}

/// Holes of fewer than `largest` pixels filled.
///
/// # Errors
/// When OpenCV fails.
pub fn small_holes_filled(mask: &Mat, largest: i32) -> opencv::Result<Mat> {
    let inverse = map2(mask, mask, |value, _| if value == 0 { 255 } else { 0 })?;
    let (found, labels) = components(&inverse)?;
    let fill: Vec<bool> = std::iter::once(false).chain(found.iter().map(|c| c.area < largest)).collect();
    let holes = by_label(mask, &labels, &fill)?;
    map2(mask, &holes, |a, b| a | b)
}

/// Combines two masks of one size byte by byte.
///
/// # Errors
/// When OpenCV fails.
pub fn map2(a: &Mat, b: &Mat, combine: impl Fn(u8, u8) -> u8) -> opencv::Result<Mat> {
    let mut out = empty(a.rows(), a.cols())?;
    let values = a.data_bytes()?.iter().zip(b.data_bytes()?);
    for (out, (a, b)) in out.data_bytes_mut()?.iter_mut().zip(values) {
        *out = combine(*a, *b);
    }
    Ok(out)
}

/// Pixels inside.
///
/// # Errors
/// When OpenCV fails.
pub fn area(mask: &Mat) -> opencv::Result<usize> {
    Ok(opencv::core::count_non_zero(mask)? as usize)
}

/// Intersection over union; 1 when both are empty.
///
/// # Errors
/// When OpenCV fails.
pub fn iou(a: &Mat, b: &Mat) -> opencv::Result<f64> {
    let (mut shared, mut either) = (0_usize, 0_usize);
    for (a, b) in a.data_bytes()?.iter().zip(b.data_bytes()?) {
        shared += usize::from(*a != 0 && *b != 0);
        either += usize::from(*a != 0 || *b != 0);
    }
    Ok(if either == 0 { 1.0 } else { shared as f64 / either as f64 })
}
