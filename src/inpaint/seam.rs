//! Laying restored background into a frame.

use opencv::core::{CV_32FC1, Mat, MatTraitConst, MatTraitConstManual, Rect, Vec3b};

use super::hole::grown;
use crate::{image::Rgb8, vision::box_blurred};

/// 1 inside the hole, falling to 0 over twice `feather` pixels outside of it.
pub(super) fn seam(hole: &Mat, feather: i32) -> opencv::Result<Mat> {
    let mut soft = Mat::default();
    let wide = grown(hole, feather)?;
    wide.convert_to(&mut soft, CV_32FC1, 1.0 / 255.0, 0.0)?;
    box_blurred(&soft, 2 * feather + 1)
}

/// The colours of a CV_8UC3 picture as floats.
pub(super) fn colours_of(picture: &Mat) -> opencv::Result<Vec<[f32; 3]>> {
    Ok(picture.data_typed::<Vec3b>()?.iter().map(|pixel| pixel.0.map(f32::from)).collect())
}

/// `picture` with `background` laid over its part `region` as far as `alpha` says.
pub(super) fn laid_in(
    picture: &Mat,
    region: Rect,
    background: &[[f32; 3]],
    alpha: &Mat,
) -> opencv::Result<Rgb8> {
    let mut out = Rgb8::from_mat(picture)?;
    let columns = out.size().width as usize;
    let alpha = alpha.data_typed::<f32>()?;
    let data = out.data_mut();
    for y in 0..region.height as usize {
        for x in 0..region.width as usize {
            let i = y * region.width as usize + x;
            if alpha[i] <= 0.0 {
                continue;
            }
            let at = ((region.y as usize + y) * columns + region.x as usize + x) * 3;
            for channel in 0..3 {
                let own = f32::from(data[at + channel]);
                data[at + channel] = (own + alpha[i] * (background[i][channel] - own)).round() as u8;
            }
        }
    }
    Ok(out)
}
