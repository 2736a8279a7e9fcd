//! Cutting the object out with a soft edge and no fringe of background.

use opencv::{
    core::{BORDER_REPLICATE, Mat, MatTraitConst, Size as CvSize},
    imgproc,
};

use super::TemplateError;
use crate::{
    geometry::Size,
    image::{Rgb8, Rgba8},
    segment::object::{Roi, bounds_of, byte_mat},
    vision::Plane,
};

/// The cut-out and the column and row of its top-left pixel.
pub(crate) struct CutOut {
    pub picture: Rgba8,
    pub origin: (u32, u32),
}

/// Cuts `shape` (non-zero inside, of the frame's size) out of `frame`; `solid` (same size) tells
/// where the frame's own colours are the object's. `None` when the shape is empty.
pub(crate) fn cut_out(frame: &Rgb8, shape: &[u8], solid: &[u8]) -> Result<Option<CutOut>, TemplateError> {
    let (width, height) = (frame.size().width as usize, frame.size().height as usize);
    let Some(bounds) = bounds_of(shape, width) else { return Ok(None) };
    // The edge is as soft as a lens makes it: about a pixel at 640, more on larger pictures.
    let softness = (width.max(height) as f64 / 900.0).clamp(0.6, 2.0);
    let roi = Roi::around(bounds, (4.0 * softness).ceil() + 2.0, width, height);
    let alpha =
        Plane::from_mat(&byte_mat(&roi.crop(shape, width), roi.width, roi.height)?)?.blurred(softness)?;
    let inner = inner_weight(&roi.crop(shape, width), &roi.crop(solid, width), &roi, 2.0 * softness)?;
    let picture = frame.to_mat()?;
    let crop = Rgb8::from_mat(&roi.crop_mat(&picture)?)?;
    let colours = spread_inner_colours(&crop, &inner)?;
    let mut data = Vec::with_capacity(roi.area() * 4);
    for (at, own) in crop.pixels().enumerate() {
        let keep = inner.data[at];
        for channel in 0..3 {
            let value = keep * f32::from(own[channel]) + (1.0 - keep) * colours[channel].data[at];
            data.push(value.round().clamp(0.0, 255.0) as u8);
        }
        data.push(alpha.data[at].round().clamp(0.0, 255.0) as u8);
    }
    let size = Size::new(roi.width as u32, roi.height as u32);
    let origin = (roi.x as u32, roi.y as u32);
    Ok(Rgba8::from_data(size, data).map(|picture| CutOut { picture, origin }))
}

/// 1 well inside the shape where colours are the object's own, falling to 0 at its edge.
fn inner_weight(shape: &[u8], solid: &[u8], roi: &Roi, edge: f64) -> Result<Plane, TemplateError> {
    let both: Vec<u8> = shape.iter().zip(solid).map(|(a, b)| u8::from(*a != 0 && *b != 0)).collect();
    let distance = crate::segment::object::signed_distance(&both, roi.width, roi.height)?;
    let weight = distance.data.iter().map(|d| (d / edge as f32).clamp(0.0, 1.0)).collect();
    Ok(Plane { width: roi.width, height: roi.height, data: weight })
}

/// Colours carried outwards from where `inner` is solid: normalised blurs, narrow ones first.
fn spread_inner_colours(crop: &Rgb8, inner: &Plane) -> Result<[Plane; 3], TemplateError> {
    let (width, height) = (inner.width, inner.height);
    let sure =
        Plane { width, height, data: inner.data.iter().map(|w| f32::from(u8::from(*w > 0.99))).collect() };
    let sure = if sure.data.iter().any(|w| *w > 0.0) { sure } else { inner.clone() };
    let mut out = [0, 1, 2].map(|_| Plane::zeros(width, height));
    let mut missing = vec![true; width * height];
    for sigma in [1.5, 4.0, 12.0, 40.0, 160.0] {
        let weight = blur(&sure, sigma)?;
        let mut blurred = Vec::with_capacity(3);
        for channel in 0..3 {
            let data = crop.pixels().zip(&sure.data).map(|(p, w)| f32::from(p[channel]) * w).collect();
            blurred.push(blur(&Plane { width, height, data }, sigma)?);
        }
        for (at, missing) in missing.iter_mut().enumerate() {
            if *missing && weight.data[at] > 0.01 {
                *missing = false;
                for channel in 0..3 {
                    out[channel].data[at] = blurred[channel].data[at] / weight.data[at];
                }
            }
        }
    }
    for (at, pixel) in crop.pixels().enumerate() {
        if missing[at] {
            for channel in 0..3 {
                out[channel].data[at] = f32::from(pixel[channel]);
            }
        }
    }
    Ok(out)
}

/// A blur that is quick for large sigmas too.
fn blur(plane: &Plane, sigma: f64) -> Result<Plane, TemplateError> {
    if sigma <= 4.0 {
        return Ok(plane.blurred(sigma)?);
    }
    let mat = plane.to_mat()?;
    let factor = 2.0 / sigma;
    let mut small = Mat::default();
    let (w, h) = ((mat.cols() as f64 * factor).ceil().max(2.0), (mat.rows() as f64 * factor).ceil().max(2.0));
    imgproc::resize(&mat, &mut small, CvSize::new(w as i32, h as i32), 0.0, 0.0, imgproc::INTER_AREA)?;
    let mut soft = Mat::default();
    imgproc::gaussian_blur(&small, &mut soft, CvSize::new(0, 0), 2.0, 2.0, BORDER_REPLICATE)?;
    let mut large = Mat::default();
    imgproc::resize(&soft, &mut large, mat.size()?, 0.0, 0.0, imgproc::INTER_LINEAR)?;
    Ok(Plane::from_mat(&large)?)
}
