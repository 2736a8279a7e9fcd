//! What is taken out, and what must not teach the background.

use opencv::{
    core::{BORDER_CONSTANT, Mat, Point, Scalar, Size as CvSize},
    imgproc,
};

use super::InpaintParams;
use crate::image::Mask;

/// `M_hand ∩ ¬M_obj`, widened by `hole_dilation` and never into the object (narrowed by
/// `object_erosion`).
///
/// # Errors
/// When OpenCV fails.
pub fn inpaint_mask(arm: &Mask, object: &Mask, params: &InpaintParams) -> opencv::Result<Mask> {
    let core = core_mat(&object.to_mat()?, params)?;
    Mask::from_mat(&hole_mat(&arm.to_mat()?, &core, params)?)
}

/// The object without its rim: pixels that are certainly the object's.
pub(super) fn core_mat(object: &Mat, params: &InpaintParams) -> opencv::Result<Mat> {
    grown(object, -InpaintParams::pixels(params.object_erosion, object.cols_u32(), 1))
}

/// [`inpaint_mask`] on CV_8UC1 matrices, given the object's [`core_mat`].
pub(super) fn hole_mat(arm: &Mat, core: &Mat, params: &InpaintParams) -> opencv::Result<Mat> {
    let width = arm.cols_u32();
    let wide = grown(arm, InpaintParams::pixels(params.hole_dilation, width, 2))?;
    let (mut outside, mut hole) = (Mat::default(), Mat::default());
    opencv::core::bitwise_not_def(core, &mut outside)?;
    opencv::core::bitwise_and_def(&wide, &outside, &mut hole)?;
    Ok(hole)
}

/// Everything that does not show the background: arm and object, widened by `guard`.
pub(super) fn blocked_mat(arm: &Mat, object: &Mat, params: &InpaintParams) -> opencv::Result<Mat> {
    let mut both = Mat::default();
    opencv::core::bitwise_or_def(arm, object, &mut both)?;
    grown(&both, InpaintParams::pixels(params.guard, arm.cols_u32(), 3))
}

trait Columns {
    fn cols_u32(&self) -> u32;
}

impl Columns for Mat {
    fn cols_u32(&self) -> u32 {
        use opencv::core::MatTraitConst as _;
        self.cols().max(0) as u32
    }
}

/// The mask widened by `radius` pixels with a disk, or narrowed where `radius` is negative.
pub(super) fn grown(mask: &Mat, radius: i32) -> opencv::Result<Mat> {
    let side = 2 * radius.abs() + 1;
    let centre = Point::new(-1, -1);
    let disk = imgproc::get_structuring_element(imgproc::MORPH_ELLIPSE, CvSize::new(side, side), centre)?;
    let mut out = Mat::default();
    if radius >= 0 {
        imgproc::dilate(mask, &mut out, &disk, centre, 1, BORDER_CONSTANT, Scalar::all(0.0))?;
    } else {
        // Beyond the picture counts as inside: an object cut by the border is not eaten there.
        imgproc::erode(mask, &mut out, &disk, centre, 1, BORDER_CONSTANT, Scalar::all(255.0))?;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Size;

    #[test]
    fn the_hole_covers_the_hand_generously_but_never_eats_the_object() {
        let size = Size::new(200, 100);
        let arm = Mask::from_fn(size, |x, y| (40..100).contains(&x) && y > 30);
        let object = Mask::from_fn(size, |x, y| (100..150).contains(&x) && y > 40);
        let hole = inpaint_mask(&arm, &object, &InpaintParams::default()).unwrap();
        assert!(hole.get(38, 60) && hole.get(70, 29) && hole.get(70, 99));
        assert!(!hole.get(102, 60) && !hole.get(120, 70));
        assert_eq!(hole.intersection_area(&arm), arm.area());
    }
}
