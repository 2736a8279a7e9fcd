//! The object's visible mask on every frame, from prompts on a few.
//!
//! A prompt becomes a mask by GrabCut and convex cuts. From every prompt a sweep runs forward and
//! another backward: flow predicts the object's motion, direct alignment of the last keyframe's
//! texture and outline removes its drift, and a convex cut of colours, arm evidence and the carried
//! shape gives the visible part. Sweeps that meet between two prompts are blended.

mod evidence;
mod guess;
mod keyframe;
mod motion;
mod params;
mod rating;
mod recognise;
mod redetect;
mod refine;
mod seed;
mod shape;
mod step;
mod sweep;
mod view;

use std::{
    collections::BTreeMap,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
};

use rayon::prelude::*;

pub(crate) use keyframe::{Keyframe, apply, similarity, turned_about};
pub(crate) use motion::{LocalFlow, Similarity, fit_similarity};
pub use params::{ObjectParams, ObjectPrompt, PromptKind};

pub(crate) use shape::{bounds_of, byte_mat, signed_distance};
pub(crate) use view::{Roi, Scene, View, arm};

use self::{
    step::{Measures, State},
    sweep::Found,
};
use super::{MaskAuthor, MaskFrame, MaskTrack, RleMask, SegmentError};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::Size,
    image::Mask,
    landmarks::LandmarkTrack,
    progress::Watch,
    vision::{WorkScale, single_threaded},
};

/// The back end's name in records.
pub const BACKEND: &str = "classical";

/// Hears of every mask as it is propagated, in any order and from any thread. Where sweeps from two prompts meet, a
/// frame is told twice; what they make together is only in the finished track. Frames of prompts are never told.
pub type MaskSink<'a> = dyn Fn(FrameIndex, &MaskFrame) + Sync + 'a;

/// The visible part of the object on every frame.
///
/// `prompts` speak of the object on at least one frame; where several speak of one frame, the last
/// counts. Human masks come back exactly as given. `arms` are arm masks of every frame (empty ones
/// where unknown), `landmarks` the hands' keypoints of every frame (may be empty).
///
/// # Errors
/// Without a usable prompt, when an input belongs to another clip, when a frame cannot be read,
/// or when cancelled.
pub fn track_object(
    frames: &dyn FrameSource,
    prompts: &[ObjectPrompt],
    arms: &MaskTrack,
    landmarks: &LandmarkTrack,
    params: &ObjectParams,
    sink: Option<&MaskSink<'_>>,
    watch: &dyn Watch,
) -> Result<MaskTrack, SegmentError> {
    single_threaded();
    let (count, size) = (frames.frame_count(), frames.size());
    check_inputs(count, size, prompts, arms)?;
    let scale = WorkScale::fit(size, params.work_side.max(64));
    let mut scene = Scene { frames, arms, landmarks, params, scale, arm_colours: None, watch };
    scene.learn_arm_colours()?;
    let reach: Reaches = prompts.iter().map(|p| (p.frame, p.reach)).collect();
    let prompts: BTreeMap<FrameIndex, &PromptKind> = prompts.iter().map(|p| (p.frame, &p.kind)).collect();
    let seeds = seeds(&scene, &prompts)?;
    if seeds.is_empty() {
        let frame = *prompts.keys().next().ok_or(SegmentError::NoPrompt)?;
        let reason = "nothing there stands out from its surroundings; draw the mask by hand".to_owned();
        return Err(SegmentError::Prompt { frame, reason });
    }
    let tell = |index: FrameIndex, found: &Found| {
        if let Some(sink) = sink
            && !prompts.contains_key(&index)
        {
            sink(index, &sweep::finish(&scene, index, found, MaskAuthor::Propagated)?);
        }
        Ok(())
    };
    let found = propagate(&scene, &seeds, count, &reach, &tell)?;
    let frames = (0..count).into_par_iter().map(|at| {
        watch.check()?;
        let index = FrameIndex(at as u32);
        finished(&scene, index, prompts.get(&index).copied(), &found[at])
    });
    let frames = frames.collect::<Result<Vec<MaskFrame>, SegmentError>>()?;
    Ok(MaskTrack { size, frames, backend: BACKEND.to_owned() })
}

/// The object's visible part on the frame of `prompt` alone: what a person sees at once, before anything is
/// propagated. `arms` is the arm mask of that frame, where it is known.
///
/// # Errors
/// When the prompt lies outside the picture or nothing there stands out, a frame cannot be read, or when cancelled.
pub fn segment_frame(
    frames: &dyn FrameSource,
    prompt: &ObjectPrompt,
    arms: Option<RleMask>,
    params: &ObjectParams,
    watch: &dyn Watch,
) -> Result<RleMask, SegmentError> {
    single_threaded();
    let (count, size) = (frames.frame_count(), frames.size());
    let empty = MaskFrame {
        mask: RleMask::empty(size),
        author: MaskAuthor::Propagated,
        score: 0.0,
        flags: Vec::new(),
    };
    let mut arm_track = MaskTrack { size, frames: vec![empty; count], backend: String::new() };
    check_inputs(count, size, std::slice::from_ref(prompt), &arm_track)?;
    if let Some(arms) = arms.filter(|arms| arms.size() == size) {
        arm_track.frames[prompt.frame.as_usize()].mask = arms;
    }
    let landmarks = LandmarkTrack::new();
    let scale = WorkScale::fit(size, params.work_side.max(64));
    let scene =
        Scene { frames, arms: &arm_track, landmarks: &landmarks, params, scale, arm_colours: None, watch };
    let prompts = BTreeMap::from([(prompt.frame, &prompt.kind)]);
    let seeds = seeds(&scene, &prompts)?;
    let Some((index, state)) = seeds.first() else {
        let reason = "nothing there stands out from its surroundings; draw the mask by hand".to_owned();
        return Err(SegmentError::Prompt { frame: prompt.frame, reason });
    };
    let found = sweep_seed(state, &scene);
    Ok(sweep::finish(&scene, *index, &found, MaskAuthor::Seeded)?.mask)
}

fn check_inputs(
    count: usize,
    size: Size,
    prompts: &[ObjectPrompt],
    arms: &MaskTrack,
) -> Result<(), SegmentError> {
    if prompts.is_empty() {
        return Err(SegmentError::NoPrompt);
    }
    if arms.frames.len() != count || arms.size != size {
        return Err(SegmentError::Mismatch {
            what: "the arm mask track",
            found: arms.frames.len(),
            found_size: arms.size,
            expected: count,
            expected_size: size,
        });
    }
    for prompt in prompts {
        let refuse = |reason: &str| SegmentError::Prompt { frame: prompt.frame, reason: reason.to_owned() };
        if prompt.frame.as_usize() >= count {
            return Err(refuse(&format!("the clip has {count} frames")));
        }
        match &prompt.kind {
            PromptKind::Box(bounds) => match bounds.clipped(size) {
                Some(clipped) if clipped.width() >= 4.0 && clipped.height() >= 4.0 => {}
                _ => return Err(refuse("the box must cover at least 4 by 4 pixels of the picture")),
            },
            PromptKind::Points { positive, .. } => {
                let inside = |p: &crate::geometry::Pixel| {
                    p.x >= 0.0 && p.y >= 0.0 && p.x < f64::from(size.width) && p.y < f64::from(size.height)
                };
                if positive.is_empty() || !positive.iter().all(inside) {
                    return Err(refuse("at least one positive point is needed, all inside the picture"));
                }
            }
            PromptKind::Mask { mask, .. } if mask.size() != size => {
                return Err(refuse("the mask must have the clip's size"));
            }
            PromptKind::Mask { .. } => {}
        }
    }
    Ok(())
}

/// The states on annotated frames on which the object is to be seen.
fn seeds(
    scene: &Scene<'_>,
    prompts: &BTreeMap<FrameIndex, &PromptKind>,
) -> Result<Vec<(FrameIndex, State)>, SegmentError> {
    let mut seeds = Vec::new();
    for (index, kind) in prompts {
        let view = Arc::new(scene.view(*index)?);
        let Some(shape) = seed::seed_shape(scene, &view, *index, kind)? else { continue };
        if let Some(state) = State::seed(view, shape)? {
            seeds.push((*index, state));
        }
    }
    Ok(seeds)
}

/// Whether the prompt of a frame is spread to earlier and to later frames.
type Reaches = BTreeMap<FrameIndex, (bool, bool)>;

/// Sweeps both ways from every seed, as far as its prompt is to be spread, and joins what meets.
fn propagate(
    scene: &Scene<'_>,
    seeds: &[(FrameIndex, State)],
    count: usize,
    reach: &Reaches,
    tell: &(dyn Fn(FrameIndex, &Found) -> Result<(), SegmentError> + Sync),
) -> Result<Vec<Found>, SegmentError> {
    // Each job: the seed it starts from, its direction, where it ends (exclusive of other seeds).
    let mut jobs = Vec::new();
    for (at, (index, _)) in seeds.iter().enumerate() {
        let here = i64::from(index.0);
        let before = if at == 0 { -1 } else { i64::from(seeds[at - 1].0.0) };
        let after = seeds.get(at + 1).map_or(count as i64, |next| i64::from(next.0.0));
        let (backward, forward) = reach.get(index).copied().unwrap_or((true, true));
        if forward {
            jobs.push((at, (here + 1..after).collect::<Vec<i64>>()));
        }
        if backward {
            jobs.push((at, (before + 1..here).rev().collect::<Vec<i64>>()));
        }
    }
    let total: usize = jobs.iter().map(|job| job.1.len()).sum();
    let finished = AtomicUsize::new(0);
    let done = || scene.watch.advance(finished.fetch_add(1, Ordering::Relaxed) + 1, total);
    let results = jobs.par_iter().map(|(at, targets)| {
        let indices = targets.iter().map(|target| FrameIndex(*target as u32));
        sweep::sweep(scene, &seeds[*at].1, indices, &|index, found| {
            done();
            tell(index, found)
        })
    });
    let results = results.collect::<Result<Vec<_>, SegmentError>>()?;
    let mut found: Vec<Option<Found>> = vec![None; count];
    for (index, state) in seeds {
        found[index.as_usize()] = Some(sweep_seed(state, scene));
    }
    for ((at, targets), sweep) in jobs.iter().zip(results) {
        for (target, new) in targets.iter().zip(sweep) {
            let slot = &mut found[*target as usize];
            *slot = Some(match slot.take() {
                None => new,
                Some(old) => {
                    // Only the sweep backward from seed `at` meets one that came forward.
                    let (low, high) = (seeds[at - 1].0.0, seeds[*at].0.0);
                    let weight = (*target as f64 - f64::from(low)) / f64::from(high - low);
                    sweep::join(&old, &new, weight)?
                }
            });
        }
    }
    let empty =
        Found { shape: RleMask::empty(scene.scale.work), measures: Measures::default(), visible: 0.0 };
    Ok(found.into_iter().map(|slot| slot.unwrap_or_else(|| empty.clone())).collect())
}

fn sweep_seed(state: &State, scene: &Scene<'_>) -> Found {
    let mask = Mask::from_bytes(scene.scale.work, state.shape.clone());
    let shape = mask.map_or_else(|| RleMask::empty(scene.scale.work), |m| RleMask::encode(&m));
    Found { shape, measures: state.measures, visible: state.visible }
}

fn finished(
    scene: &Scene<'_>,
    index: FrameIndex,
    prompt: Option<&PromptKind>,
    found: &Found,
) -> Result<MaskFrame, SegmentError> {
    match prompt {
        Some(PromptKind::Mask { mask, human: true }) => {
            Ok(MaskFrame { mask: mask.clone(), author: MaskAuthor::Human, score: 1.0, flags: Vec::new() })
        }
        Some(PromptKind::Mask { mask, human: false }) => {
            let frame = sweep::finish(scene, index, found, MaskAuthor::Seeded)?;
            Ok(MaskFrame { mask: mask.clone(), ..frame })
        }
        Some(_) => sweep::finish(scene, index, found, MaskAuthor::Seeded),
        None => sweep::finish(scene, index, found, MaskAuthor::Propagated),
    }
}
