//! How clean the object is seen on every frame.

use opencv::{
    core::{CV_32F, Mat, MatTraitConstManual},
    imgproc,
};
use rayon::prelude::*;

use super::{TemplateError, TemplateParams};
use crate::{
    clip::FrameIndex,
    segment::{
        MaskAuthor, MaskFlag, MaskTrack,
        object::{Scene, arm, bounds_of, signed_distance},
    },
};

/// What the score of a frame is made of.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cleanness {
    /// Pixels of the mask at work scale.
    area: f64,
    /// Share of a thin ring around the mask that arms cover.
    touched: f64,
    /// Variance of the Laplacian inside the mask.
    sharpness: f64,
    /// Trust in the mask, halved for every flag.
    trust: f64,
}

/// Clean-frame score of every frame, 0 to 1: visibility, no arm near, sharpness, size, trust.
pub(crate) fn scores(
    scene: &Scene<'_>,
    object: &MaskTrack,
    params: &TemplateParams,
) -> Result<Vec<f64>, TemplateError> {
    let measured = (0..object.frames.len()).into_par_iter().map(|at| {
        scene.watch.check()?;
        measure(scene, object, FrameIndex(at as u32))
    });
    let measured = measured.collect::<Result<Vec<Cleanness>, TemplateError>>()?;
    // Largest and sharpest in the sense of the 90th percentile: single failures do not rule.
    let ninth = |value: fn(&Cleanness) -> f64| {
        let least = f64::from(params.least_area);
        let mut values: Vec<f64> = measured.iter().filter(|m| m.area >= least).map(value).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() * 9 / 10).copied().unwrap_or(1.0).max(1e-6)
    };
    let (large, sharp) = (ninth(|m| m.area), ninth(|m| m.sharpness));
    let score = |m: &Cleanness| {
        if m.area < f64::from(params.least_area) {
            return 0.0;
        }
        // A mask larger than usual is more likely wrong than good.
        let ratio = m.area / large;
        let size = if ratio > 1.3 { 1.3 / ratio } else { ratio.min(1.0) };
        let free = (-6.0 * m.touched).exp();
        let focus = (m.sharpness / sharp).min(1.0).powf(0.35);
        size.powf(1.5) * free * focus * m.trust
    };
    Ok(measured.iter().map(score).collect())
}

fn measure(scene: &Scene<'_>, object: &MaskTrack, index: FrameIndex) -> Result<Cleanness, TemplateError> {
    let frame = object.frame(index);
    if frame.mask.is_empty() {
        return Ok(Cleanness::default());
    }
    let view = scene.view(index)?;
    let mask = scene.scale.shrink_mask(&frame.mask.decode().to_mat()?)?;
    let bytes = mask.data_bytes()?.to_vec();
    let Some(bounds) = bounds_of(&bytes, view.width) else { return Ok(Cleanness::default()) };
    let roi = crate::segment::object::Roi::around(bounds, 10.0, view.width, view.height);
    let shape = roi.crop(&bytes, view.width);
    let distance = signed_distance(&shape, roi.width, roi.height)?;
    let classes = roi.crop(&view.arms, view.width);
    let mut laplacian = Mat::default();
    let border = opencv::core::BORDER_REPLICATE;
    imgproc::laplacian(&roi.crop_mat(&view.gray)?, &mut laplacian, CV_32F, 1, 1.0, 0.0, border)?;
    let laplacian = laplacian.data_typed::<f32>()?;
    let (mut area, mut ring, mut touched, mut sum, mut squares, mut inner) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for at in 0..shape.len() {
        let d = distance.data[at];
        if shape[at] != 0 {
            area += 1.0;
        }
        if d > 2.0 {
            let value = f64::from(laplacian[at]);
            (sum, squares, inner) = (sum + value, squares + value * value, inner + 1.0);
        }
        if d < 0.0 && d > -6.0 {
            ring += 1.0;
            touched += f64::from(u8::from(classes[at] >= arm::MASK));
        }
    }
    let sharpness = if inner > 8.0 { squares / inner - (sum / inner).powi(2) } else { 0.0 };
    let doubts = frame.flags.iter().filter(|flag| **flag != MaskFlag::Occluded).count();
    let human = frame.author == MaskAuthor::Human;
    let trust = if human { 1.0 } else { frame.score.max(0.05) * 0.5_f64.powi(doubts as i32) };
    Ok(Cleanness { area, touched: touched / f64::max(ring, 1.0), sharpness, trust })
}
