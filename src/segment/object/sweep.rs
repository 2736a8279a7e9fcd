//! Propagation away from annotated frames, and the joining of sweeps that meet.

use std::sync::Arc;

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual},
    imgproc,
};

use super::{
    shape::{bounds_of, byte_mat, signed_distance},
    step::{Measures, State, advance},
    view::{Roi, Scene},
};
use crate::{
    clip::FrameIndex,
    image::Mask,
    segment::{MaskAuthor, MaskFlag, MaskFrame, RleMask, SegmentError},
    vision::{Plane, refine_edges},
};

/// What a sweep found on one frame, at work scale.
#[derive(Clone)]
pub(crate) struct Found {
    pub shape: RleMask,
    pub measures: Measures,
    /// Share of the shape that no arm covers.
    pub visible: f64,
}

impl Found {
    fn of(state: &State, scene: &Scene<'_>) -> Self {
        let mask = Mask::from_bytes(scene.scale.work, state.shape.clone());
        let shape = mask.map_or_else(|| RleMask::empty(scene.scale.work), |m| RleMask::encode(&m));
        Self { shape, measures: state.measures, visible: state.visible }
    }
}

/// Sweeps from `start` (exclusive) over `targets` in their order; calls `done` with every frame.
pub(crate) fn sweep(
    scene: &Scene<'_>,
    start: &State,
    targets: impl Iterator<Item = FrameIndex>,
    done: &(dyn Fn(FrameIndex, &Found) -> Result<(), SegmentError> + Sync),
) -> Result<Vec<Found>, SegmentError> {
    let mut state = start.clone();
    let mut found = Vec::new();
    for index in targets {
        scene.watch.check()?;
        state = advance(scene, &state, Arc::new(scene.view(index)?), index)?;
        let here = Found::of(&state, scene);
        done(index, &here)?;
        found.push(here);
    }
    Ok(found)
}

/// Joins what two sweeps found on one frame; `weight` in [0, 1] is the second's share by distance.
pub(crate) fn join(a: &Found, b: &Found, weight: f64) -> Result<Found, SegmentError> {
    let (score_a, score_b) = (score(a).max(0.02), score(b).max(0.02));
    let (share_a, share_b) = ((1.0 - weight) * score_a * score_a, weight * score_b * score_b);
    let share = share_b / (share_a + share_b).max(1e-9);
    let size = a.shape.size();
    let (width, height) = (size.width as usize, size.height as usize);
    let (da, db) = (
        signed_distance(a.shape.decode().data(), width, height)?,
        signed_distance(b.shape.decode().data(), width, height)?,
    );
    let limit = |d: f32| f64::from(d.clamp(-12.0, 12.0));
    let blended =
        da.data.iter().zip(&db.data).map(|(a, b)| (1.0 - share) * limit(*a) + share * limit(*b) > 0.0);
    let bytes: Vec<u8> = blended.map(u8::from).collect();
    let shape = Mask::from_bytes(size, bytes).map_or_else(|| a.shape.clone(), |m| RleMask::encode(&m));
    let better = if share > 0.5 { b } else { a };
    Ok(Found { shape, ..better.clone() })
}

/// Trust in what was found, 0 to 1.
pub(crate) fn score(found: &Found) -> f64 {
    let m = &found.measures;
    let ramp = |value: f64, low: f64, high: f64| ((value - low) / (high - low)).clamp(0.0, 1.0);
    let shape = ramp(m.overlap, 0.3, 0.9);
    let colour = 1.0 - ramp(m.colour, 0.25, 0.75);
    let seen = 0.3 + 0.7 * ramp(found.visible, 0.0, 0.4);
    shape.min(colour).max(0.3 * m.agreement) * seen * (0.5 + 0.5 * ramp(m.agreement, 0.2, 0.6))
}

/// The finished frame at the clip's own size.
pub(crate) fn finish(
    scene: &Scene<'_>,
    index: FrameIndex,
    found: &Found,
    author: MaskAuthor,
) -> Result<MaskFrame, SegmentError> {
    let mask = full_size(scene, index, &found.shape)?;
    let m = &found.measures;
    let mut flags = Vec::new();
    let occluded = found.visible < scene.params.occluded_share;
    let empty = found.shape.is_empty();
    if !occluded && !(0.6..=1.6).contains(&m.area_ratio) {
        flags.push(MaskFlag::AreaJump);
    }
    if !occluded && m.overlap < 0.5 {
        flags.push(MaskFlag::LowOverlap);
    }
    if !empty && m.colour > 0.6 {
        flags.push(MaskFlag::ColourDrift);
    }
    let size = mask.size();
    let touches = mask.decode().bounding_box().is_some_and(|b| {
        let (right, low) = (f64::from(size.width), f64::from(size.height));
        b.x0 < 1.0 || b.y0 < 1.0 || b.x1 > right - 1.0 || b.y1 > low - 1.0
    });
    if touches {
        flags.push(MaskFlag::TouchesBorder);
    }
    if occluded {
        flags.push(MaskFlag::Occluded);
    }
    if empty && !occluded {
        flags.push(MaskFlag::Lost);
    }
    Ok(MaskFrame { mask, author, score: score(found), flags })
}

/// A work mask at the clip's size, its border drawn to the picture's own edges.
fn full_size(scene: &Scene<'_>, index: FrameIndex, shape: &RleMask) -> Result<RleMask, SegmentError> {
    let scale = &scene.scale;
    if scale.full == scale.work || shape.is_empty() {
        let empty = RleMask::empty(scale.full);
        return Ok(if shape.is_empty() { empty } else { shape.clone() });
    }
    let mask = shape.decode();
    let width = scale.work.width as usize;
    let Some(bounds) = bounds_of(mask.data(), width) else { return Ok(RleMask::empty(scale.full)) };
    let (full_w, full_h) = (scale.full.width as usize, scale.full.height as usize);
    let mut soft = Mat::default();
    let work = byte_mat(mask.data(), width, scale.work.height as usize)?;
    imgproc::gaussian_blur(
        &work,
        &mut soft,
        opencv::core::Size::new(0, 0),
        0.7,
        0.7,
        opencv::core::BORDER_REPLICATE,
    )?;
    let large = Plane::from_mat(&scale.enlarge(&soft)?)?;
    let (sx, sy) = scale.factors();
    let outer = (bounds.0 / sx, bounds.1 / sy, bounds.2 / sx, bounds.3 / sy);
    let roi = Roi::around(outer, 12.0 / sx, full_w, full_h);
    let picture = scene.frames.frame(index)?.to_mat()?;
    let radius = (1.5 / sx).round().max(2.0) as i32;
    let crop = roi.crop_mat(&picture)?;
    let refined = refine_edges(&crop, &roi.crop_plane(&large).to_mat()?, radius, 1e-3)?;
    let refined = refined.data_bytes()?;
    debug_assert_eq!(crop.rows() as usize, roi.height);
    let mut full = Mask::new(scale.full);
    for (at, value) in refined.iter().enumerate() {
        if *value > 127 {
            full.set((at % roi.width + roi.x) as u32, (at / roi.width + roi.y) as u32, true);
        }
    }
    Ok(RleMask::encode(&full))
}
