//! PSNR and SSIM of 8-bit RGB pictures, over the whole picture or inside a mask.

use opencv::{
    core::{BORDER_REFLECT_101, CV_32FC1, Mat, MatTraitConst, MatTraitConstManual, Size as CvSize},
    imgproc,
};

use crate::{
    geometry::Size,
    image::{Mask, Rgb8},
};

/// Why two pictures could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum MetricError {
    /// Sizes differ.
    #[error("cannot compare a {found} picture or mask with a {expected} one: resize it first")]
    Size {
        /// The reference's size.
        expected: Size,
        /// What was given.
        found: Size,
    },
    /// OpenCV refused.
    #[error("OpenCV failed while measuring similarity: {0}")]
    OpenCv(#[from] opencv::Error),
}

fn same_size(expected: Size, found: Size) -> Result<(), MetricError> {
    if expected == found { Ok(()) } else { Err(MetricError::Size { expected, found }) }
}

/// Peak signal-to-noise ratio in dB over all pixels and channels, `10 log10(255² / MSE)`;
/// infinite for equal pictures.
///
/// # Errors
/// [`MetricError::Size`] when the sizes differ.
pub fn psnr(picture: &Rgb8, truth: &Rgb8) -> Result<f64, MetricError> {
    same_size(truth.size(), picture.size())?;
    let pairs = picture.data().iter().zip(truth.data());
    let sum: u64 = pairs.map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum();
    Ok(decibel(sum, truth.data().len()))
}

/// [`psnr`] over the pixels inside `mask` alone; `None` when the mask is empty.
///
/// # Errors
/// [`MetricError::Size`] when the sizes differ.
pub fn psnr_inside(picture: &Rgb8, truth: &Rgb8, mask: &Mask) -> Result<Option<f64>, MetricError> {
    same_size(truth.size(), picture.size())?;
    same_size(truth.size(), mask.size())?;
    let (mut sum, mut count) = (0_u64, 0_usize);
    for ((a, b), inside) in picture.pixels().zip(truth.pixels()).zip(mask.data()) {
        if *inside != 0 {
            sum += a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum::<u64>();
            count += 3;
        }
    }
    Ok((count > 0).then(|| decibel(sum, count)))
}

fn decibel(squares: u64, count: usize) -> f64 {
    if squares == 0 {
        return f64::INFINITY;
    }
    10.0 * (255.0_f64.powi(2) * count as f64 / squares as f64).log10()
}

/// Structural similarity (Wang et al. 2004: luma, Gaussian window 11×11 with σ = 1.5, K = 0.01, 0.03),
/// mean over all pixels; 1 for equal pictures.
///
/// # Errors
/// When the sizes differ or OpenCV fails.
pub fn ssim(picture: &Rgb8, truth: &Rgb8) -> Result<f64, MetricError> {
    let everything = Mask::from_fn(truth.size(), |_, _| true);
    Ok(ssim_inside(picture, truth, &everything)?.unwrap_or(1.0))
}

/// [`ssim`], mean over windows centred inside `mask`; `None` when the mask is empty.
///
/// # Errors
/// When the sizes differ or OpenCV fails.
pub fn ssim_inside(picture: &Rgb8, truth: &Rgb8, mask: &Mask) -> Result<Option<f64>, MetricError> {
    same_size(truth.size(), picture.size())?;
    same_size(truth.size(), mask.size())?;
    let (x, y) = (luma(picture)?, luma(truth)?);
    let product = |a: &Mat, b: &Mat| -> Result<Mat, MetricError> {
        let mut out = Mat::default();
        opencv::core::multiply(a, b, &mut out, 1.0, -1)?;
        smooth(&out)
    };
    let (mean_x, mean_y) = (smooth(&x)?, smooth(&y)?);
    let (xx, yy, xy) = (product(&x, &x)?, product(&y, &y)?, product(&x, &y)?);
    let (mx, my) = (mean_x.data_typed::<f32>()?, mean_y.data_typed::<f32>()?);
    let (xx, yy, xy) = (xx.data_typed::<f32>()?, yy.data_typed::<f32>()?, xy.data_typed::<f32>()?);
    let (c1, c2) = ((0.01_f64 * 255.0).powi(2), (0.03_f64 * 255.0).powi(2));
    let (mut sum, mut count) = (0.0, 0_usize);
    for (i, _) in mask.data().iter().enumerate().filter(|(_, inside)| **inside != 0) {
        let (mx, my) = (f64::from(mx[i]), f64::from(my[i]));
        let (vx, vy) = (f64::from(xx[i]) - mx * mx, f64::from(yy[i]) - my * my);
        let covariance = f64::from(xy[i]) - mx * my;
        sum += (2.0 * mx * my + c1) * (2.0 * covariance + c2) / ((mx * mx + my * my + c1) * (vx + vy + c2));
        count += 1;
    }
    Ok((count > 0).then(|| sum / count as f64))
}

fn luma(picture: &Rgb8) -> Result<Mat, MetricError> {
    let mut gray = Mat::default();
    imgproc::cvt_color_def(&picture.to_mat()?, &mut gray, imgproc::COLOR_RGB2GRAY)?;
    let mut out = Mat::default();
    gray.convert_to(&mut out, CV_32FC1, 1.0, 0.0)?;
    Ok(out)
}

fn smooth(channel: &Mat) -> Result<Mat, MetricError> {
    let mut out = Mat::default();
    imgproc::gaussian_blur(channel, &mut out, CvSize::new(11, 11), 1.5, 1.5, BORDER_REFLECT_101)?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(value: u8) -> Rgb8 {
        let size = Size::new(24, 16);
        Rgb8::from_data(size, vec![value; size.area() * 3]).unwrap()
    }

    #[test]
    fn equal_pictures_are_perfect() {
        assert_eq!(psnr(&flat(7), &flat(7)).unwrap(), f64::INFINITY);
        assert!((ssim(&flat(7), &flat(7)).unwrap() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn an_error_of_ten_levels_is_28_decibel() {
        assert!((psnr(&flat(110), &flat(100)).unwrap() - 28.1308).abs() < 1e-3);
    }

    #[test]
    fn only_the_inside_of_the_mask_counts() {
        let (mut picture, truth) = (flat(100), flat(100));
        picture.set_pixel(0, 0, [255, 255, 255]);
        let mask = Mask::from_fn(truth.size(), |x, _| x > 0);
        assert_eq!(psnr_inside(&picture, &truth, &mask).unwrap(), Some(f64::INFINITY));
        assert!(ssim(&picture, &truth).unwrap() < 0.9999);
        assert_eq!(psnr_inside(&picture, &truth, &Mask::new(truth.size())).unwrap(), None);
    }

    #[test]
    fn sizes_must_agree() {
        let other = Rgb8::new(Size::new(3, 3));
        assert!(matches!(psnr(&flat(1), &other), Err(MetricError::Size { .. })));
    }
}
