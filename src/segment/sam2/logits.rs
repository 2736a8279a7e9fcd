//! Mask logits as pictures: enlarged, freed of specks, cut at zero.

use opencv::{
    core::{CV_32FC1, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar, Size as CvSize},
    imgproc::{INTER_LINEAR, resize},
};

use crate::{
    geometry::Size,
    image::Mask,
    vision::binary::{components, empty},
};

/// Specks and holes of at most this many pixels of the decoder's picture are mistakes.
const SPECK: i32 = 8;
/// What a removed hole or speck becomes: just on the other side.
const BARELY: f32 = 0.1;

/// A square picture of logits.
pub fn square(logits: &[f32], side: usize) -> opencv::Result<Mat> {
    let mut picture = Mat::new_rows_cols_with_default(side as i32, side as i32, CV_32FC1, Scalar::all(0.0))?;
    picture.data_typed_mut::<f32>()?.copy_from_slice(logits);
    Ok(picture)
}

/// Logits between pixels, as the network's own code enlarges them.
pub fn enlarged(logits: &Mat, width: usize, height: usize) -> opencv::Result<Mat> {
    let mut out = Mat::default();
    resize(logits, &mut out, CvSize::new(width as i32, height as i32), 0.0, 0.0, INTER_LINEAR)?;
    Ok(out)
}

/// Without small specks and holes.
pub fn without_specks(logits: &Mat) -> opencv::Result<Mat> {
    let mut out = logits.try_clone()?;
    for inside in [true, false] {
        let mut mask = empty(logits.rows(), logits.cols())?;
        let values = out.data_typed::<f32>()?;
        for (pixel, value) in mask.data_bytes_mut()?.iter_mut().zip(values) {
            *pixel = if (*value > 0.0) == inside { 255 } else { 0 };
        }
        let (found, labels) = components(&mask)?;
        let small: Vec<bool> =
            std::iter::once(false).chain(found.iter().map(|piece| piece.area <= SPECK)).collect();
        for (value, label) in out.data_typed_mut::<f32>()?.iter_mut().zip(labels) {
            if small[label as usize] {
                *value = if inside { -BARELY } else { BARELY };
            }
        }
    }
    Ok(out)
}

/// What lies above zero, at the clip's size.
pub fn mask_of(logits: &Mat, size: Size) -> opencv::Result<Mask> {
    let full = enlarged(logits, size.width as usize, size.height as usize)?;
    let values = full.data_typed::<f32>()?;
    let inside = |x: u32, y: u32| values[(y * size.width + x) as usize] > 0.0;
    Ok(Mask::from_fn(size, inside))
}

/// Sure logits for a mask that somebody drew: `side` × `side`, +10 inside, -10 outside.
pub fn sure(mask: &Mask, side: usize) -> opencv::Result<Mat> {
    let mut soft = Mat::default();
    mask.to_mat()?.convert_to(&mut soft, CV_32FC1, 1.0 / 255.0, 0.0)?;
    let mut out = enlarged(&soft, side, side)?;
    for value in out.data_typed_mut::<f32>()? {
        *value = if *value >= 0.5 { 10.0 } else { -10.0 };
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn specks_and_holes_of_eight_pixels_go_and_larger_ones_stay() {
        let value = |x: usize, y: usize| -> f32 {
            let block = (8..24).contains(&x) && (8..24).contains(&y);
            let hole = (12..16).contains(&x) && (12..14).contains(&y);
            let larger_hole = (18..21).contains(&x) && (18..21).contains(&y);
            let speck = (2..4).contains(&x) && (2..6).contains(&y);
            if (block && !hole && !larger_hole) || speck { 5.0 } else { -5.0 }
        };
        let logits: Vec<f32> = (0..32 * 32).map(|at| value(at % 32, at / 32)).collect();
        let cleaned = without_specks(&square(&logits, 32).unwrap()).unwrap();
        let at = |x: i32, y: i32| *cleaned.at_2d::<f32>(y, x).unwrap();
        assert!(at(13, 12) > 0.0 && at(2, 3) < 0.0, "small ones stayed");
        assert!(at(19, 19) < 0.0 && at(9, 9) > 0.0, "large ones went");
    }

    #[test]
    fn a_drawn_mask_is_as_sure_as_the_network_can_be() {
        let mask = Mask::from_fn(Size::new(640, 480), |x, _| x < 320);
        let logits = sure(&mask, 64).unwrap();
        assert_eq!(
            (*logits.at_2d::<f32>(5, 31).unwrap(), *logits.at_2d::<f32>(5, 32).unwrap()),
            (10.0, -10.0)
        );
    }
}
