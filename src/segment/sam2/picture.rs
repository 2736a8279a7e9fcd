//! Pictures as SAM 2 takes them: square, whatever their aspect was.

use opencv::{
    core::{Mat, MatTraitConst, Size as CvSize},
    imgproc::{INTER_AREA, INTER_LINEAR, resize},
};

use crate::onnx::{CheckedModel, OnnxError, Sizes};

/// The side of the square, which its graphs or its description say.
pub(super) fn side_of(model: &CheckedModel, sizes: &Sizes) -> Result<usize, OnnxError> {
    let side = model.size(sizes, "S")?;
    if side == 0 || side % 16 != 0 {
        return Err(model.wrong(format!("S = {side}: a multiple of 16 is expected")));
    }
    Ok(side)
}

/// `picture` as a square of `side` pixels.
pub(super) fn squared(picture: &Mat, side: usize) -> opencv::Result<Mat> {
    let side = side as i32;
    let method = if picture.cols() > side && picture.rows() > side { INTER_AREA } else { INTER_LINEAR };
    let mut square = Mat::default();
    resize(picture, &mut square, CvSize::new(side, side), 0.0, 0.0, method)?;
    Ok(square)
}
