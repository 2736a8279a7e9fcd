//! What no frame ever saw.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Rect, Vec3b},
    imgproc,
};

use super::{
    InpaintParams,
    plate::{SYNTHESISED, UNKNOWN},
};

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
    let around = grown_rect(bounds, 48, picture.cols(), picture.rows());
    let part = Mat::roi(picture, around)?.try_clone()?;
    // Everything unknown in the part is filled, so that black margins do not bleed in.
    let hole = Mat::roi(&unknown, around)?.try_clone()?;
    let mut filled = Mat::default();
    opencv::photo::inpaint(&part, &hole, &mut filled, 5.0, opencv::photo::INPAINT_TELEA)?;
    let columns = picture.cols() as usize;
    let wanted = wanted.data_typed::<u8>()?;
    let from = filled.data_typed::<Vec3b>()?;
    let (to, kinds) = (picture.data_typed_mut::<Vec3b>()?, origin.data_typed_mut::<u8>()?);
    for y in 0..around.height as usize {
        for x in 0..around.width as usize {
            let at = (around.y as usize + y) * columns + around.x as usize + x;
            if wanted[at] != 0 {
                to[at] = from[y * around.width as usize + x];
                kinds[at] = SYNTHESISED;
            }
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
