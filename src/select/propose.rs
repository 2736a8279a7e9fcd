//! From moments of contact motion to ranked boxes on frames where the object is well visible.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual},
    imgproc,
};
use rayon::prelude::*;

use super::{
    ObjectSelector, Proposal, SelectError, SelectInput, SelectParams,
    contact::{Look, Moment, look, moments_at},
};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::{Pixel, PixelBox},
    landmarks::LandmarkTrack,
    progress::Watch,
    segment::MaskTrack,
    vision::{FlowQuality, WorkScale, binary, dense_flow, grab_cut, single_threaded},
};

/// Proposes what moves with the hand at contact.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactSelector {
    /// Its parameters.
    pub params: SelectParams,
}

impl ObjectSelector for ContactSelector {
    fn select(&self, input: SelectInput<'_>, watch: &dyn Watch) -> Result<Vec<Proposal>, SelectError> {
        propose(input.frames, input.landmarks, input.arms, &self.params, watch)
    }
}

/// Ranked proposals: what moves with a hand (flow minus the background's homography, near the
/// fingertips, outside the arm), followed back in time to where it is best visible.
///
/// Empty when no hand moves anything; never more than `params.proposals`.
///
/// # Errors
/// When an input does not fit the clip, a frame cannot be read, OpenCV fails or `watch` cancels.
pub fn propose(
    frames: &dyn FrameSource,
    landmarks: &LandmarkTrack,
    arms: &MaskTrack,
    params: &SelectParams,
    watch: &dyn Watch,
) -> Result<Vec<Proposal>, SelectError> {
    single_threaded();
    let count = frames.frame_count();
    for (what, found) in [("the landmark track", landmarks.len()), ("the arm track", arms.frames.len())] {
        if found != count {
            return Err(SelectError::Mismatch { what, found, expected: count });
        }
    }
    let input = SelectInput { frames, landmarks, arms };
    let scale = WorkScale::fit(frames.size(), params.work_size);
    let step = count.div_ceil(params.moments.max(1)).max(1);
    let indices: Vec<usize> = (0..count).step_by(step).collect();
    let mut moments: Vec<Moment> = indices
        .par_iter()
        .map(|index| {
            watch.check()?;
            moments_at(&input, *index, &scale, params)
        })
        .collect::<Result<Vec<_>, SelectError>>()?
        .into_iter()
        .flatten()
        .collect();
    let total: f64 = moments.iter().map(|moment| moment.score).sum();
    moments.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.index.cmp(&b.index)));
    moments.truncate(3 * params.proposals.max(1));
    let tracked = moments
        .par_iter()
        .map(|moment| {
            watch.check()?;
            followed_back(&input, moment, &scale)
        })
        .collect::<Result<Vec<_>, SelectError>>()?;
    Ok(ranked(&tracked, &scale, total, params))
}

/// A moment's object where it is best visible.
struct Sighting {
    index: usize,
    bounds: PixelBox,
    score: f64,
    contact: usize,
}

/// How well a mask can serve as a prompt: large against its size at contact, far from arms.
fn visibility(mask: &Mat, look: &Look, palm_width: f64, reference: f64) -> opencv::Result<f64> {
    let near = binary::dilated(&look.arm, (0.35 * palm_width).round().clamp(2.0, 12.0) as i32)?;
    let touched = binary::area(&binary::map2(mask, &near, |a, b| a & b)?)? as f64;
    let area = binary::area(mask)? as f64;
    if area < 1.0 {
        return Ok(0.0);
    }
    Ok((area / reference).min(1.5) - 0.8 * touched / area)
}

/// Frames between the pictures of one backward step.
const BACK_STRIDE: usize = 3;
/// Backward steps at most.
const BACK_STEPS: usize = 40;

fn followed_back(
    input: &SelectInput<'_>,
    moment: &Moment,
    scale: &WorkScale,
) -> Result<Sighting, SelectError> {
    let reference = binary::area(&moment.blob)? as f64;
    let mut mask = moment.blob.try_clone()?;
    let mut current = look(input, moment.index, scale)?;
    let mut best = (moment.index, mask.try_clone()?);
    let mut best_score = visibility(&mask, &current, moment.palm_width, reference)?;
    let mut index = moment.index;
    for _ in 0..BACK_STEPS {
        let Some(earlier) = index.checked_sub(BACK_STRIDE).or((index > 0).then_some(0)) else { break };
        let before = look(input, earlier, scale)?;
        let flow = dense_flow(&before.grey, &current.grey, FlowQuality::Medium)?;
        let pulled = flow.pull(&mask)?;
        let pulled = binary::map2(&pulled, &before.arm, |m, arm| if m > 127 && arm == 0 { 255 } else { 0 })?;
        let area = binary::area(&pulled)? as f64;
        if area < 0.4 * reference || area > 2.5 * reference {
            break;
        }
        let score = visibility(&pulled, &before, moment.palm_width, reference)?;
        if score >= best_score {
            best = (earlier, pulled.try_clone()?);
            best_score = score;
        }
        (mask, current, index) = (pulled, before, earlier);
    }
    let look = look(input, best.0, scale)?;
    let whole = completed(&look, &best.1, moment.palm_width)?;
    let rect = imgproc::bounding_rect(&whole)?;
    let corner = |x: i32, y: i32| scale.to_full(Pixel::new(f64::from(x) - 0.5, f64::from(y) - 0.5));
    let bounds =
        PixelBox::from_corners(corner(rect.x, rect.y), corner(rect.x + rect.width, rect.y + rect.height));
    let bounds = bounds.clipped(input.frames.size()).unwrap_or(bounds);
    Ok(Sighting { index: best.0, bounds, score: moment.score, contact: moment.index })
}

/// The whole object around the part whose motion was seen: GrabCut with the arm as background.
fn completed(look: &Look, part: &Mat, palm_width: f64) -> opencv::Result<Mat> {
    let around = binary::dilated(part, (0.8 * palm_width).round().clamp(4.0, 24.0) as i32)?;
    let mut seeds = binary::map2(&around, part, |around, part| match (around != 0, part != 0) {
        (_, true) => grab_cut::SEED_PROBABLY_FOREGROUND,
        (true, false) => grab_cut::SEED_PROBABLY_BACKGROUND,
        _ => grab_cut::SEED_BACKGROUND,
    })?;
    let core = binary::eroded(part, 2)?;
    let certain = seeds.data_bytes_mut()?.iter_mut().zip(core.data_bytes()?);
    for ((seed, core), arm) in certain.zip(look.arm.data_bytes()?) {
        if *arm != 0 {
            *seed = grab_cut::SEED_BACKGROUND;
        } else if *core != 0 {
            *seed = grab_cut::SEED_FOREGROUND;
        }
    }
    let cut = grab_cut::grab_cut(&look.lab, &seeds, 3, 4)?;
    let cut = binary::touching(&binary::opened(&cut, 1)?, part)?;
    let (before, after) = (binary::area(part)? as f64, binary::area(&cut)? as f64);
    if (0.5 * before..=5.0 * before).contains(&after) { Ok(cut) } else { part.try_clone() }
}

fn overlap(a: &PixelBox, b: &PixelBox) -> f64 {
    let shared = PixelBox { x0: a.x0.max(b.x0), y0: a.y0.max(b.y0), x1: a.x1.min(b.x1), y1: a.y1.min(b.y1) };
    let shared = if shared.width() > 0.0 && shared.height() > 0.0 { shared.area() } else { 0.0 };
    shared / (a.area() + b.area() - shared).max(1e-9)
}

/// Merges sightings of one box and ranks by the evidence gathered.
fn ranked(sightings: &[Sighting], scale: &WorkScale, total: f64, params: &SelectParams) -> Vec<Proposal> {
    let (smallest, largest) = (2e-4 * scale.full.area() as f64, 0.6 * scale.full.area() as f64);
    let mut groups: Vec<(&Sighting, f64, usize)> = Vec::new();
    for sighting in sightings.iter().filter(|s| (smallest..largest).contains(&s.bounds.area())) {
        match groups.iter_mut().find(|(first, _, _)| overlap(&first.bounds, &sighting.bounds) > 0.3) {
            Some((_, score, moments)) => {
                *score += sighting.score;
                *moments += 1;
            }
            None => groups.push((sighting, sighting.score, 1)),
        }
    }
    groups.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.index.cmp(&b.0.index)));
    let ranked = groups.into_iter().take(params.proposals).map(|(sighting, score, moments)| Proposal {
        frame: FrameIndex(sighting.index as u32),
        bounds: sighting.bounds,
        label: "object".to_owned(),
        confidence: (score / total.max(1e-9)).clamp(0.0, 1.0) * (score / 2.0).min(1.0),
        reason: format!(
            "moves with a hand in {moments} of the strongest moments, most clearly at {}",
            FrameIndex(sighting.contact as u32)
        ),
        backend: "contact motion".to_owned(),
    });
    ranked.collect()
}
