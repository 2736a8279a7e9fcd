//! The stage: choose the clean frame, cut the object out, place it on every frame.

use nalgebra::Matrix3;
use opencv::core::MatTraitConstManual;

use super::{
    Placement, TemplateError, TemplateParams, TemplateTrack, clean,
    picture::{CutOut, cut_out},
    placement::{Located, locate},
};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::Pixel,
    landmarks::LandmarkTrack,
    progress::Watch,
    segment::{
        MaskTrack,
        object::{ObjectParams, Scene},
    },
    vision::{WorkScale, single_threaded},
};

/// Chooses the clean frame (the operator's `choice` wins), cuts the object out whole and places it on
/// every frame. `None` when the object has no mask worth cutting on any frame.
///
/// `object` and `arms` are masks of every frame, `landmarks` the hands' keypoints (may be empty).
/// Placements take template pixels (of the crop) to frame pixels, both at the clip's size.
///
/// # Errors
/// When an input belongs to another clip, the chosen frame has no mask, a frame cannot be read, or
/// when cancelled.
pub fn build(
    frames: &dyn FrameSource,
    object: &MaskTrack,
    arms: &MaskTrack,
    choice: Option<FrameIndex>,
    landmarks: &LandmarkTrack,
    params: &TemplateParams,
    watch: &dyn Watch,
) -> Result<Option<TemplateTrack>, TemplateError> {
    single_threaded();
    let count = frames.frame_count();
    for (what, found) in
        [("the object mask track", object.frames.len()), ("the arm mask track", arms.frames.len())]
    {
        if found != count {
            return Err(TemplateError::Mismatch { what, found, expected: count });
        }
    }
    let object_params = ObjectParams { work_side: params.work_side, ..ObjectParams::default() };
    let scale = WorkScale::fit(frames.size(), params.work_side.max(64));
    let scene = Scene { frames, arms, landmarks, params: &object_params, scale, arm_colours: None, watch };
    let scores = clean::scores(&scene, object, params)?;
    let best = scores.iter().enumerate().rev().max_by(|a, b| a.1.total_cmp(b.1));
    let clean = match (choice, best) {
        (Some(choice), _) if choice.as_usize() >= count || object.frame(choice).mask.is_empty() => {
            return Err(TemplateError::EmptyChoice(choice));
        }
        (Some(choice), _) => choice,
        (None, Some((at, score))) if *score > 0.0 => FrameIndex(at as u32),
        _ => return Ok(None),
    };
    let full = object.frame(clean).mask.decode();
    let frame = frames.frame(clean)?;
    let Some(CutOut { picture, origin }) = cut_out(&frame, full.data(), full.data())? else {
        return Ok(None);
    };
    let shape = scale.shrink_mask(&full.to_mat()?)?;
    let shape: Vec<u8> = shape.data_bytes()?.iter().map(|v| u8::from(*v != 0)).collect();
    let located = locate(&scene, object, clean, &shape, params)?;
    let confidences = confidences(&located);
    let placements = located
        .iter()
        .zip(confidences)
        .map(|(entry, confidence)| Some(placement(entry, confidence, &scale, origin)))
        .collect();
    Ok(Some(TemplateTrack { picture, origin, frame: clean, placements, scores }))
}

/// A work-scale location as a placement of the crop at the clip's size.
fn placement(entry: &Located, confidence: f64, scale: &WorkScale, origin: (u32, u32)) -> Placement {
    let (sx, sy) = scale.factors();
    let zero = scale.to_work(Pixel::new(0.0, 0.0));
    let shrink = Matrix3::new(sx, 0.0, zero.x, 0.0, sy, zero.y, 0.0, 0.0, 1.0);
    let enlarge = Matrix3::new(1.0 / sx, 0.0, -zero.x / sx, 0.0, 1.0 / sy, -zero.y / sy, 0.0, 0.0, 1.0);
    let (x, y) = (f64::from(origin.0), f64::from(origin.1));
    let offset = Matrix3::new(1.0, 0.0, x, 0.0, 1.0, y, 0.0, 0.0, 1.0);
    let mut transform = enlarge * entry.transform * shrink * offset;
    transform /= transform[(2, 2)];
    Placement { transform, confidence, visible: entry.visible }
}

/// Evidence of the frame itself, or of its neighbours, fading over about half a second.
fn confidences(located: &[Located]) -> Vec<f64> {
    let fade = 0.93;
    let mut values: Vec<f64> = located.iter().map(|l| l.evidence).collect();
    for k in 1..values.len() {
        values[k] = values[k].max(fade * values[k - 1]);
    }
    for k in (0..values.len().saturating_sub(1)).rev() {
        values[k] = values[k].max(fade * values[k + 1]);
    }
    values
}
