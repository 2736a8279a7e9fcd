//! What is taken out, and what must not teach the background.

use opencv::{
    core::{Mat, MatTraitConst, Point, Size as CvSize},
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
    grown(object, -params.object_inset(object.cols_u32()).cast_signed())
}

/// [`inpaint_mask`] on CV_8UC1 matrices, given the object's [`core_mat`].
pub(super) fn hole_mat(arm: &Mat, core: &Mat, params: &InpaintParams) -> opencv::Result<Mat> {
    let width = arm.cols_u32();
    let wide = grown(arm, params.hole_reach(width).cast_signed())?;
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
        self.cols().max(0) as u32
    }
}

/// The mask widened by `radius` pixels, or narrowed where `radius` is negative, by a regular octagon: a
/// square, then a diamond, which are fast. Beyond the picture counts as more of the same.
pub(super) fn grown(mask: &Mat, radius: i32) -> opencv::Result<Mat> {
    let length = radius.abs();
    let square = ((std::f64::consts::SQRT_2 - 1.0) * f64::from(length)).round() as i32;
    let diamond = length - square;
    let element = |shape: i32, radius: i32| {
        let size = CvSize::new(2 * radius + 1, 2 * radius + 1);
        imgproc::get_structuring_element(shape, size, Point::new(-1, -1))
    };
    let widening = radius >= 0;
    let change = |from: &Mat, shape: i32, radius: i32, times: i32| -> opencv::Result<Mat> {
        let mut out = Mat::default();
        let (kernel, centre) = (element(shape, radius)?, Point::new(-1, -1));
        let beyond = imgproc::morphology_default_border_value()?;
        let widen = if widening { imgproc::dilate } else { imgproc::erode };
        widen(from, &mut out, &kernel, centre, times, opencv::core::BORDER_CONSTANT, beyond)?;
        Ok(out)
    };
    let wide = change(mask, imgproc::MORPH_RECT, square, 1)?;
    change(&wide, imgproc::MORPH_CROSS, 1, diamond)
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
