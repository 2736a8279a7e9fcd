//! The shadow that hand and arm cast on the ground beside them: it goes with them.
//!
//! Such ground is darker than the plate by a factor that varies little from pixel to pixel, has the plate's
//! hue, and hangs together with the hole. How much of the plate is drawn there follows the darkening, so that
//! soft shadows end softly and nothing flickers.

use opencv::{
    core::{
        CV_8UC1, CV_32F, CV_32FC1, CV_32S, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Rect,
        Scalar, Vec3b,
    },
    imgproc,
};

use super::{InpaintParams, hole::grown};
use crate::vision::{WorkScale, box_blurred};

/// What a frame shows at work scale.
pub(super) struct Ground<'a> {
    /// CV_8UC3: the frame.
    pub frame: &'a Mat,
    /// CV_8UC3: the plate on the frame's grid, in its colours.
    pub plate: &'a Mat,
    /// CV_8UC1: 255 where the plate was really seen.
    pub shown: &'a Mat,
    /// CV_8UC1: any pixel of the hole.
    pub hole: &'a Mat,
    /// CV_8UC1: any pixel of the object.
    pub object: &'a Mat,
}

/// Where a shadow lies, at work scale.
pub(super) struct Shadow {
    /// CV_32FC1: how much of the plate belongs there, 0 to 1.
    pub alpha: Mat,
    /// The box around it, in full-size pixels.
    pub bounds: Rect,
}

/// Light of 1 is full; from here down a pixel is in shadow for certain, above the other value for certain not.
const SHADE: (f32, f32) = (0.93, 0.98);
/// The deepest shadow of a hand.
const DEEPEST: f32 = 0.35;
/// Darker ground tells nothing about hue.
const BLACK: f32 = 24.0;
/// How much the light may differ between neighbours inside a shadow.
const ROUGHEST: f32 = 0.07;

/// Finds the shadow that touches the hole; `None` where there is none worth the work.
pub(super) fn cast_shadow(
    ground: &Ground<'_>,
    scale: WorkScale,
    params: &InpaintParams,
) -> opencv::Result<Option<Shadow>> {
    let (columns, rows) = (ground.frame.cols() as usize, ground.frame.rows() as usize);
    let light = light(ground)?;
    let smooth = box_blurred(&light, 5)?;
    let (light, smooth) = (light.data_typed::<f32>()?, smooth.data_typed::<f32>()?);
    let near = near_the_hole(ground, (params.shadow_reach * columns as f64) as f32)?;
    let dark: Vec<u8> = (0..light.len())
        .map(|i| {
            let even = (light[i] - smooth[i]).abs() < ROUGHEST;
            if near[i] && even && (DEEPEST..SHADE.1).contains(&smooth[i]) { 255 } else { 0 }
        })
        .collect();
    let dark = Mat::new_rows_cols_with_data(rows as i32, columns as i32, &dark)?.try_clone()?;
    let Some(kept) = touching(&dark, ground.hole, smooth)? else { return Ok(None) };
    let wide = box_blurred(&float(&grown(&kept, 4)?)?, 3)?;
    let mut alpha = wide;
    for (i, alpha) in alpha.data_typed_mut::<f32>()?.iter_mut().enumerate() {
        let shade = ((SHADE.1 - smooth[i]) / (SHADE.1 - SHADE.0)).clamp(0.0, 1.0);
        *alpha = if near[i] { *alpha * shade } else { 0.0 };
    }
    let alpha = box_blurred(&alpha, 3)?;
    let bounds = imgproc::bounding_rect(&grown(&kept, 6)?)?;
    let (sx, sy) = scale.factors();
    let place = |at: i32, s: f64| (f64::from(at) / s) as i32;
    let bounds = Rect::new(
        place(bounds.x, sx),
        place(bounds.y, sy),
        place(bounds.width, sx),
        place(bounds.height, sy),
    );
    Ok(Some(Shadow { alpha, bounds }))
}

/// CV_32FC1: the frame's light over the plate's, 1 where nothing is known or the hue differs.
fn light(ground: &Ground<'_>) -> opencv::Result<Mat> {
    let zero = Scalar::all(1.0);
    let mut light =
        Mat::new_rows_cols_with_default(ground.frame.rows(), ground.frame.cols(), CV_32FC1, zero)?;
    let (frame, plate) = (ground.frame.data_typed::<Vec3b>()?, ground.plate.data_typed::<Vec3b>()?);
    let (shown, hole) = (ground.shown.data_typed::<u8>()?, ground.hole.data_typed::<u8>()?);
    for (i, light) in light.data_typed_mut::<f32>()?.iter_mut().enumerate() {
        let (own, lit) = (frame[i].0.map(f32::from), plate[i].0.map(f32::from));
        let (own_sum, lit_sum) = (own.iter().sum::<f32>(), lit.iter().sum::<f32>());
        if shown[i] == 0 || hole[i] != 0 || lit_sum < 3.0 * BLACK {
            continue;
        }
        let factor = own_sum / lit_sum;
        let limit = 6.0 + 0.12 * lit_sum / 3.0 * (1.0 - factor).clamp(0.0, 1.0);
        if own.iter().zip(lit).all(|(own, lit)| (own - factor * lit).abs() < limit) {
            *light = factor;
        }
    }
    Ok(light)
}

/// Pixels outside the hole, within `reach` of it, and closer to it than to the object, whose shadow is its own.
fn near_the_hole(ground: &Ground<'_>, reach: f32) -> opencv::Result<Vec<bool>> {
    let (hole, object) = (distance_from(ground.hole)?, distance_from(ground.object)?);
    let pairs = hole.data_typed::<f32>()?.iter().zip(object.data_typed::<f32>()?);
    Ok(pairs.map(|(hole, object)| *hole > 0.0 && *hole < reach && *object > 2.0 && hole < object).collect())
}

/// CV_32FC1: distance from the nearest pixel of `mask`; far where it has none.
fn distance_from(mask: &Mat) -> opencv::Result<Mat> {
    let (mut outside, mut distance) = (Mat::default(), Mat::default());
    if opencv::core::count_non_zero(mask)? == 0 {
        return Mat::new_size_with_default(mask.size()?, CV_32FC1, Scalar::all(1e6));
    }
    opencv::core::compare(mask, &Scalar::all(0.0), &mut outside, opencv::core::CMP_EQ)?;
    imgproc::distance_transform(&outside, &mut distance, imgproc::DIST_L2, imgproc::DIST_MASK_3, CV_32F)?;
    Ok(distance)
}

/// CV_8UC1: those connected pieces of `dark` that touch the hole and really are dark somewhere.
fn touching(dark: &Mat, hole: &Mat, light: &[f32]) -> opencv::Result<Option<Mat>> {
    let mut labels = Mat::default();
    let count = imgproc::connected_components(dark, &mut labels, 8, CV_32S)? as usize;
    let labels = labels.data_typed::<i32>()?;
    let beside = grown(hole, 3)?;
    let beside = beside.data_typed::<u8>()?;
    let mut pieces = vec![(0_u32, false); count];
    for (i, label) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        let (area, touches) = &mut pieces[*label as usize];
        *area += u32::from(light[i] < SHADE.0);
        *touches |= beside[i] != 0;
    }
    let keep: Vec<bool> = pieces.iter().map(|(area, touches)| *touches && *area >= 12).collect();
    if !keep.contains(&true) {
        return Ok(None);
    }
    let kept: Vec<u8> = labels.iter().map(|label| if keep[*label as usize] { 255 } else { 0 }).collect();
    Mat::new_rows_cols_with_data(dark.rows(), dark.cols(), &kept)?.try_clone().map(Some)
}

fn float(mask: &Mat) -> opencv::Result<Mat> {
    debug_assert_eq!(mask.typ(), CV_8UC1);
    let mut out = Mat::default();
    mask.convert_to(&mut out, CV_32FC1, 1.0 / 255.0, 0.0)?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::Size,
        image::{Mask, Rgb8},
    };

    const SIZE: Size = Size::new(160, 120);

    /// The alpha found where a hand covers the left quarter and `dark` darkens or colours the ground.
    fn alpha(dark: impl Fn(u32, u32) -> Option<[u8; 3]>) -> Option<Mat> {
        let lit = Rgb8::from_data(SIZE, [160, 140, 120].repeat(SIZE.area())).unwrap();
        let mut frame = lit.clone();
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                if let Some(colour) = dark(x, y) {
                    frame.set_pixel(x, y, colour);
                }
            }
        }
        let mask = |inside: &dyn Fn(u32) -> bool| Mask::from_fn(SIZE, |x, _| inside(x)).to_mat().unwrap();
        let ground = Ground {
            frame: &frame.to_mat().unwrap(),
            plate: &lit.to_mat().unwrap(),
            shown: &mask(&|_| true),
            hole: &mask(&|x| x < 40),
            object: &mask(&|x| x > 150),
        };
        let scale = WorkScale { full: SIZE, work: SIZE };
        cast_shadow(&ground, scale, &InpaintParams::default()).unwrap().map(|shadow| shadow.alpha)
    }

    #[test]
    fn a_shadow_beside_the_hand_is_taken_out_and_one_elsewhere_is_not() {
        let beside = |x: u32, y: u32| (x < 52 && (40..80).contains(&y)).then_some([112, 98, 84]);
        let found = alpha(beside).unwrap();
        assert!(*found.at_2d::<f32>(60, 46).unwrap() > 0.95);
        assert!(*found.at_2d::<f32>(20, 46).unwrap() < 0.05);
        assert!(alpha(|x, y| (x > 80 && (40..80).contains(&y)).then_some([112, 98, 84])).is_none());
    }

    #[test]
    fn a_thing_of_another_hue_is_no_shadow() {
        assert!(alpha(|x, y| (x < 52 && (40..80).contains(&y)).then_some([60, 80, 150])).is_none());
    }
}
