//! Mask edges at full size: guided filtering (He et al. 2010) fitted on the work picture and applied to the full
//! one (He and Sun 2015), which costs little at any clip size.

use opencv::core::{CV_32F, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual};

use super::Clip;
use crate::vision::{binary, box_blurred};

/// Half the window, work pixels.
const RADIUS: i32 = 2;
/// Variance of luminance (0 to 1) below which there is no edge to follow.
const EPSILON: f32 = 4e-4;
/// Share of arm from which a pixel is inside: recall first.
const INSIDE: f32 = 0.43;

/// Around every work pixel, mask ≈ slope · luminance + offset.
#[derive(Debug)]
pub(super) struct EdgeLine {
    slope: Mat,
    offset: Mat,
}

fn averaged(plane: &Mat) -> opencv::Result<Mat> {
    box_blurred(plane, 2 * RADIUS + 1)
}

fn product(a: &Mat, b: &Mat) -> opencv::Result<Mat> {
    let mut out = Mat::default();
    opencv::core::multiply(a, b, &mut out, 1.0, -1)?;
    Ok(out)
}

impl EdgeLine {
    /// Fitted to `mask` over `grey` (both CV_8UC1 of one size).
    pub fn fitted(grey: &Mat, mask: &Mat) -> opencv::Result<Self> {
        let (mut light, mut inside) = (Mat::default(), Mat::default());
        grey.convert_to(&mut light, CV_32F, 1.0 / 255.0, 0.0)?;
        mask.convert_to(&mut inside, CV_32F, 1.0 / 255.0, 0.0)?;
        let (mean_light, mean_inside) = (averaged(&light)?, averaged(&inside)?);
        let (squares, products) =
            (averaged(&product(&light, &light)?)?, averaged(&product(&light, &inside)?)?);
        let (mut slope, mut offset) = (mean_light.try_clone()?, mean_light.try_clone()?);
        {
            let (ml, mi) = (mean_light.data_typed::<f32>()?, mean_inside.data_typed::<f32>()?);
            let (sq, pr) = (squares.data_typed::<f32>()?, products.data_typed::<f32>()?);
            let (slopes, offsets) = (slope.data_typed_mut::<f32>()?, offset.data_typed_mut::<f32>()?);
            for i in 0..ml.len() {
                slopes[i] = (pr[i] - ml[i] * mi[i]) / (sq[i] - ml[i] * ml[i] + EPSILON);
                offsets[i] = mi[i] - slopes[i] * ml[i];
            }
        }
        Ok(Self { slope: averaged(&slope)?, offset: averaged(&offset)? })
    }

    /// The mask on a part of the full-size picture, whose luminance `grey` has its upper left corner at `corner`.
    pub fn drawn(&self, grey: &Mat, corner: (i32, i32), clip: &Clip<'_>) -> opencv::Result<Mat> {
        let roi = opencv::core::Rect::new(corner.0, corner.1, grey.cols(), grey.rows());
        let slope = clip.scale.enlarge(&self.slope)?.roi(roi)?.try_clone()?;
        let offset = clip.scale.enlarge(&self.offset)?.roi(roi)?.try_clone()?;
        let mut out = binary::empty(grey.rows(), grey.cols())?;
        let lines = slope.data_typed::<f32>()?.iter().zip(offset.data_typed::<f32>()?);
        let values = grey.data_bytes()?.iter().zip(lines);
        for (out, (grey, (slope, offset))) in out.data_bytes_mut()?.iter_mut().zip(values) {
            *out = if slope * f32::from(*grey) / 255.0 + offset > INSIDE { 255 } else { 0 };
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fitted_line_follows_an_edge_that_the_mask_misses_by_a_pixel() {
        let side = 40;
        let (mut grey, mut mask) = (binary::empty(side, side).unwrap(), binary::empty(side, side).unwrap());
        for (i, (grey, mask)) in
            grey.data_bytes_mut().unwrap().iter_mut().zip(mask.data_bytes_mut().unwrap()).enumerate()
        {
            let x = i % side as usize;
            *grey = if x < 20 { 200 } else { 40 };
            *mask = if x < 19 { 255 } else { 0 };
        }
        let line = EdgeLine::fitted(&grey, &mask).unwrap();
        let at = |x: i32, light: f32| {
            line.slope.at_2d::<f32>(20, x).unwrap() * light + line.offset.at_2d::<f32>(20, x).unwrap()
        };
        assert!(at(19, 200.0 / 255.0) > INSIDE, "a light pixel at the edge belongs to the light side");
        assert!(at(20, 40.0 / 255.0) < INSIDE, "a dark one does not");
    }
}
