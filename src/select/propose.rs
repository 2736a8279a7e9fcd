//! From cues to ranked boxes on frames where the object is well visible.

use rayon::prelude::*;

use super::{
    ObjectSelector, Proposal, SelectError, SelectInput, SelectParams,
    arm_colours::ArmColours,
    change::{Change, changes},
    fuse::{Candidate, from_changes, from_held},
    held::held,
    motion::{Moment, moments},
    outline::{self, Rough},
    scene::Scene,
    timeline::Timeline,
};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::PixelBox,
    landmarks::LandmarkTrack,
    progress::Watch,
    segment::MaskTrack,
    vision::single_threaded,
};

/// Proposes what a hand takes, carries or puts down.
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

/// Ranked proposals: what was taken from its place or put down by a hand (two views of one place, before
/// and after), and what keeps its place in a moving hand.
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
    let scene = Scene::new(input, params, watch)?;
    let colours = ArmColours::learn(&scene)?;
    let stretches = stretches(scene.samples.len());
    let found = stretches
        .par_iter()
        .flat_map(|stretch| [(stretch, stretch.first()), (stretch, stretch.last())])
        .filter_map(|(stretch, end)| Some((stretch, *end?)))
        .map(|(stretch, end)| {
            watch.check()?;
            let timeline = Timeline::new(&scene, stretch, end)?;
            changes(&scene, stretch, &timeline, &colours)
        })
        .collect::<Result<Vec<_>, SelectError>>()?;
    let changes: Vec<Change> = found.into_iter().flatten().collect();
    let moments = scene
        .samples
        .par_iter()
        .map(|sample| {
            watch.check()?;
            moments(&scene, sample.index)
        })
        .collect::<Result<Vec<_>, SelectError>>()?;
    let moments: Vec<Moment> = moments.into_iter().flatten().collect();
    let held = held(&moments, &scene.scale, &colours)?;
    let mut candidates = from_changes(&scene, &changes)?;
    candidates.extend(from_held(held));
    candidates.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.index.cmp(&b.index)));
    candidates.truncate(3 * params.proposals);
    let boxes = candidates
        .par_iter()
        .map(|candidate| {
            watch.check()?;
            let (shape, around) = (&candidate.shape, candidate.around.as_ref());
            let rough = Rough { shape, around, scale: &scene.scale };
            outline::bounds(frames, arms, candidate.index, &rough)
        })
        .collect::<Result<Vec<_>, SelectError>>()?;
    Ok(ranked(&candidates, &boxes, params))
}

/// The whole clip, its halves and, where there are samples enough, its quarters.
fn stretches(samples: usize) -> Vec<Vec<usize>> {
    let all: Vec<usize> = (0..samples).collect();
    let middle = samples / 2;
    if samples < 8 {
        return vec![all];
    }
    let mut stretches = vec![all.clone(), all[..middle + 1].to_vec(), all[middle..].to_vec()];
    if samples >= 24 {
        let quarter = samples / 4;
        stretches
            .extend((0..4).map(|part| all[part * quarter..((part + 1) * quarter + 1).min(samples)].to_vec()));
    }
    stretches
}

pub(super) fn overlap(a: &PixelBox, b: &PixelBox) -> f64 {
    let shared = PixelBox { x0: a.x0.max(b.x0), y0: a.y0.max(b.y0), x1: a.x1.min(b.x1), y1: a.y1.min(b.y1) };
    let shared = if shared.width() > 0.0 && shared.height() > 0.0 { shared.area() } else { 0.0 };
    shared / (a.area() + b.area() - shared).max(1e-9)
}

fn ranked(candidates: &[Candidate], boxes: &[Option<PixelBox>], params: &SelectParams) -> Vec<Proposal> {
    let mut kept: Vec<Proposal> = Vec::new();
    for (candidate, bounds) in candidates.iter().zip(boxes) {
        let Some(bounds) = bounds else { continue };
        if kept.len() >= params.proposals || kept.iter().any(|other| overlap(&other.bounds, bounds) > 0.5) {
            continue;
        }
        kept.push(Proposal {
            frame: FrameIndex(candidate.index as u32),
            bounds: *bounds,
            point: None,
            label: "object".to_owned(),
            confidence: candidate.score.clamp(0.0, 1.0),
            reason: candidate.reason.clone(),
            backend: "contact motion".to_owned(),
        });
    }
    kept
}
