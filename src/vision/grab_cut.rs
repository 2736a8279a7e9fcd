//! GrabCut (Rother et al. 2004) from graded seeds, inside the region that needs deciding.

use opencv::{
    core::{CV_8UC1, Mat, MatTraitConst, MatTraitConstManual, Rect, Scalar},
    imgproc,
    prelude::*,
};

/// Seed value: certainly outside.
pub const SEED_BACKGROUND: u8 = 0;
/// Seed value: certainly inside.
pub const SEED_FOREGROUND: u8 = 1;
/// Seed value: probably outside.
pub const SEED_PROBABLY_BACKGROUND: u8 = 2;
/// Seed value: probably inside.
pub const SEED_PROBABLY_FOREGROUND: u8 = 3;

/// Cuts `picture` (CV_8UC3, any colour space) by `seeds` (CV_8UC1 of `SEED_…` values, same size);
/// returns CV_8UC1, 255 inside. Only the bounding box of what is not certainly outside, grown by
/// `margin` pixels, is looked at. Where either side has no seed at all, the seeds themselves decide.
///
/// # Errors
/// When the sizes differ or OpenCV fails.
pub fn grab_cut(picture: &Mat, seeds: &Mat, iterations: i32, margin: i32) -> opencv::Result<Mat> {
    let mut out = Mat::new_rows_cols_with_default(seeds.rows(), seeds.cols(), CV_8UC1, Scalar::all(0.0))?;
    let tight = imgproc::bounding_rect(seeds)?;
    if tight.width == 0 || tight.height == 0 {
        return Ok(out);
    }
    let whole = Rect::new(0, 0, seeds.cols(), seeds.rows());
    let grown =
        Rect::new(tight.x - margin, tight.y - margin, tight.width + 2 * margin, tight.height + 2 * margin);
    let roi = grown & whole;
    let crop = picture.roi(roi)?.try_clone()?;
    let mut labels = seeds.roi(roi)?.try_clone()?;
    let inside = labels.data_bytes()?.iter().filter(|v| **v & 1 == 1).count();
    let enough = inside >= 8 && labels.data_bytes()?.len() - inside >= 8;
    if enough && iterations > 0 {
        let (mut background, mut foreground) = (Mat::default(), Mat::default());
        let mode = imgproc::GC_INIT_WITH_MASK;
        opencv::core::set_rng_seed(1)?;
        imgproc::grab_cut(
            &crop,
            &mut labels,
            Rect::default(),
            &mut background,
            &mut foreground,
            iterations,
            mode,
        )?;
    }
    let mut target = out.roi_mut(roi)?;
    let binary: Vec<u8> = labels.data_bytes()?.iter().map(|v| if v & 1 == 1 { 255 } else { 0 }).collect();
    let binary = Mat::new_rows_cols_with_bytes::<u8>(roi.height, roi.width, &binary)?.try_clone()?;
    binary.copy_to(&mut target)?;
    drop(target);
    Ok(out)
}
