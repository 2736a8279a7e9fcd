//! What no frame ever saw.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Rect, Vec3b},
    imgproc,
};

use super::{
    InpaintParams,
    plate::{SYNTHESISED, UNKNOWN},
};
use crate::vision::fill_smoothly;

/// Makes up the pixels inside `needed` whose origin is unknown.
pub(super) fn fill_unseen(
    picture: &mut Mat,
    origin: &mut Mat,
    needed: &Mat,
    _params: &InpaintParams,
) -> opencv::Result<()> {
    let mut unknown = Mat::default();
    opencv::core::compare(
        origin,
        &opencv::core::Scalar::all(f64::from(UNKNOWN)),
        &mut unknown,
        opencv::core::CMP_EQ,
    )?;
    let mut wanted = Mat::default();
    opencv::core::bitwise_and_def(&unknown, needed, &mut wanted)?;
    let bounds = imgproc::bounding_rect(&wanted)?;
    if bounds.width == 0 || bounds.height == 0 {
        return Ok(());
    }
    let around = grown_rect(bounds, 64, picture.cols(), picture.rows());
    let (columns, width) = (picture.cols() as usize, around.width as usize);
    let wanted = wanted.data_typed::<u8>()?;
    let (to, kinds) = (picture.data_typed_mut::<Vec3b>()?, origin.data_typed_mut::<u8>()?);
    let place = |i: usize| (around.y as usize + i / width) * columns + around.x as usize + i % width;
    let count = width * around.height as usize;
    let weights: Vec<f32> = (0..count).map(|i| if kinds[place(i)] == UNKNOWN { 0.0 } else { 1.0 }).collect();
    let mut colours: Vec<[f32; 3]> = (0..count).map(|i| to[place(i)].0.map(f32::from)).collect();
    fill_smoothly(&mut colours, &weights, width, around.height as usize);
    for (i, colour) in colours.iter().enumerate() {
        if wanted[place(i)] != 0 {
            to[place(i)] = Vec3b::from(colour.map(|value| value.round().clamp(0.0, 255.0) as u8));
            kinds[place(i)] = SYNTHESISED;
        }
    }
    Ok(())
}

/// `rect` with a margin, inside the picture.
pub(super) fn grown_rect(rect: Rect, margin: i32, columns: i32, rows: i32) -> Rect {
    let (x0, y0) = ((rect.x - margin).max(0), (rect.y - margin).max(0));
    let (x1, y1) = ((rect.x + rect.width + margin).min(columns), (rect.y + rect.height + margin).min(rows));
    Rect::new(x0, y0, x1 - x0, y1 - y0)
}
