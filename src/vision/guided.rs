//! Guided filtering (He et al. 2010): a coarse mask follows the picture's edges.

use opencv::{
    core::{CV_8U, CV_32F, Mat, MatTraitConst},
    imgproc, ximgproc,
};

/// Enlarges `mask` (CV_8UC1 or CV_32FC1 of any size, 0..255) to the size of `picture` (CV_8UC3 RGB)
/// and lets its edge follow the picture's luminance edges within `radius` pixels. Returns
/// CV_8UC1, 0 to 255: a soft mask; threshold at 127 for a binary one.
///
/// # Errors
/// When OpenCV fails.
pub fn refine_edges(picture: &Mat, mask: &Mat, radius: i32, epsilon: f64) -> opencv::Result<Mat> {
    let mut guide = Mat::default();
    imgproc::cvt_color(picture, &mut guide, imgproc::COLOR_RGB2GRAY, 0)?;
    let mut large = Mat::default();
    imgproc::resize(mask, &mut large, picture.size()?, 0.0, 0.0, imgproc::INTER_LINEAR)?;
    let (mut guide_float, mut mask_float) = (Mat::default(), Mat::default());
    guide.convert_to(&mut guide_float, CV_32F, 1.0 / 255.0, 0.0)?;
    large.convert_to(&mut mask_float, CV_32F, 1.0 / 255.0, 0.0)?;
    let mut filtered = Mat::default();
    ximgproc::guided_filter(&guide_float, &mask_float, &mut filtered, radius, epsilon, -1)?;
    let mut out = Mat::default();
    filtered.convert_to(&mut out, CV_8U, 255.0, 0.0)?;
    Ok(out)
}
