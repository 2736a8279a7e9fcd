//! One hand over the clip.

use std::ops::Range;

use nalgebra::{Vector2, Vector3};

use super::{
    FitParams,
    batch::{BatchFrame, ShapePrior, refine_all},
    kinematics::HandPose,
    runs::runs,
    shape::HandShape,
    start::{Hypothesis, hypotheses},
    terms::{Sight, reprojection},
};
use crate::{
    geometry::{Pinhole, Side},
    hands::HandsError,
    landmarks::{HandLandmarks, KEYPOINT_COUNT, LandmarkTrack, keypoint::PARENT},
    progress::Watch,
};

/// A hand's poses, mirrored for right hands.
#[derive(Debug)]
pub(super) struct FittedSide {
    pub shape: HandShape,
    /// One a frame; `None` where the hand is not known.
    pub poses: Vec<Option<HandPose>>,
    /// Spread of keypoints about the fit, normalised coordinates.
    pub sigma: f64,
}

/// Every n-th seen frame gets first guesses; the fit of all frames carries them to the others.
const SEED_STEP: usize = 5;
/// Frames that take part in fitting the shape; more would not change it.
const SHAPE_FRAMES: usize = 360;
/// Frames fitted at once: bounds memory to 30 MB.
const CHUNK: usize = 480;
/// Spread of a finger's base as a share of the hand's length, for each unit of bone spread.
const BASE_SHARE: f64 = 0.4;
/// Evidence on shape that a clip can give, in frames. Errors of keypoints repeat from frame to
/// frame, and lengths found along with one set of angles a frame come out too long (bones only
/// ever look shorter than they are), so more frames must not outweigh what is known of hands.
const INDEPENDENT_FRAMES: f64 = 8.0;
/// Spread of a keypoint before the clip's own is known, in hand extents.
const FIRST_SIGMA: f64 = 0.015;

/// Fits `side`.
pub(super) fn fit_side(
    landmarks: &LandmarkTrack,
    side: Side,
    pinhole: &Pinhole,
    params: &FitParams,
    watch: &dyn Watch,
) -> Result<FittedSide, HandsError> {
    let mut sights: Vec<Option<Sight>> = landmarks
        .iter()
        .map(|hands| hands[side].as_ref().and_then(|hand| sight(hand, side, pinhole)))
        .collect();
    let seen: Vec<bool> = sights.iter().map(Option::is_some).collect();
    let runs = runs(&seen, params.longest_bridge, params.shortest_run.max(1));
    let mut shape = HandShape::average(params.hand_length_mm * 1e-3);
    let mut fitted = FittedSide { shape: shape.clone(), poses: vec![None; seen.len()], sigma: 0.0 };
    if let Some(sigma) = params.keypoint_sigma_px {
        set_sigma(&mut sights, sigma / focal(pinhole));
    }
    for run in &runs {
        seed(&shape, &sights, run.clone(), &mut fitted.poses, watch)?;
    }
    let chosen = longest(&runs, SHAPE_FRAMES);
    let mut frames = batch(&sights, &fitted.poses, &chosen);
    let prior = ShapePrior {
        mean: shape.clone(),
        base_sigma: BASE_SHARE * params.bone_sigma * shape.length(),
        bone_sigma: params.bone_sigma,
        length_sigma: params.hand_length_sigma,
        weight: (frames.len() as f64 / INDEPENDENT_FRAMES).max(1.0),
    };
    // First with a stiff shape, then with the keypoints' own spread and all freedom.
    refine_all(&mut shape, &mut frames, None, 8);
    watch.check()?;
    if params.keypoint_sigma_px.is_none() {
        refine_all(&mut shape, &mut frames, Some(&prior), 4);
        let sigma = keypoint_spread(&shape, &frames, 1.0 / focal(pinhole));
        set_sigma(&mut sights, sigma);
        for frame in &mut frames {
            if let Some(sight) = &mut frame.sight {
                sight.sigma = sigma;
            }
        }
    }
    refine_all(&mut shape, &mut frames, Some(&prior), 10);
    fitted.sigma = keypoint_spread(&shape, &frames, 1.0 / focal(pinhole));
    store(&frames, &chosen, &mut fitted.poses);
    let total: usize = runs.iter().map(ExactSizeIterator::len).sum();
    let mut done = 0;
    for run in &runs {
        fit_run(&mut shape, &sights, run.clone(), &mut fitted.poses, watch)?;
        done += run.len();
        watch.advance(done, total);
    }
    fitted.shape = shape;
    Ok(fitted)
}

fn focal(pinhole: &Pinhole) -> f64 {
    0.5 * (pinhole.fx + pinhole.fy)
}

/// Keypoints as rays, in the mirror for right hands; `None` when they are not finite.
pub(super) fn sight(hand: &HandLandmarks, side: Side, pinhole: &Pinhole) -> Option<Sight> {
    let mirror = if side == Side::Right { -1.0 } else { 1.0 };
    let rays = hand
        .keypoints
        .map(|p| Vector2::new(mirror * (p.x - pinhole.cx) / pinhole.fx, (p.y - pinhole.cy) / pinhole.fy));
    if rays.iter().any(|r| !(r.x.is_finite() && r.y.is_finite())) {
        return None;
    }
    let span = |axis: usize| {
        let values = rays.iter().map(|r| r[axis]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    let extent = span(0).max(span(1));
    if extent < 1e-4 {
        return None;
    }
    let bone_hints = hand.world.and_then(|world| {
        let mut hints = [Vector3::x(); KEYPOINT_COUNT];
        for k in 1..KEYPOINT_COUNT {
            let mut bone = world[k] - world[PARENT[k]];
            bone.x *= mirror;
            hints[k] = bone.try_normalize(1e-9)?;
        }
        Some(hints)
    });
    Some(Sight { rays, sigma: (FIRST_SIGMA * extent).max(1.0 / focal(pinhole)), bone_hints })
}

fn set_sigma(sights: &mut [Option<Sight>], sigma: f64) {
    for sight in sights.iter_mut().flatten() {
        sight.sigma = sigma;
    }
}

/// Robust spread of keypoints about the fit, at least half a pixel.
fn keypoint_spread(shape: &HandShape, frames: &[BatchFrame], pixel: f64) -> f64 {
    let mut errors: Vec<f64> = frames
        .iter()
        .filter_map(|f| f.sight.as_ref().map(|sight| reprojection(shape, &f.pose, sight)))
        .collect();
    if errors.is_empty() {
        return pixel;
    }
    errors.sort_by(f64::total_cmp);
    // Of 42 coordinates a frame the pose takes about half: the spread is larger than what is left.
    (errors[errors.len() / 2] / 2.0_f64.sqrt() * 1.35).max(0.5 * pixel)
}

/// First guesses for every frame of a run.
fn seed(
    shape: &HandShape,
    sights: &[Option<Sight>],
    run: Range<usize>,
    poses: &mut [Option<HandPose>],
    watch: &dyn Watch,
) -> Result<(), HandsError> {
    let seen: Vec<usize> = run.clone().filter(|f| sights[*f].is_some()).collect();
    let mut guesses: Vec<(usize, Vec<Hypothesis>)> = Vec::new();
    for (nth, frame) in seen.iter().enumerate() {
        if nth % SEED_STEP != 0 && nth + 1 != seen.len() {
            continue;
        }
        watch.check()?;
        if let Some(sight) = &sights[*frame] {
            guesses.push((*frame, hypotheses(shape, sight)?));
        }
    }
    let chosen = most_consistent(&guesses);
    for frame in run {
        let after = chosen.partition_point(|(f, _)| *f <= frame);
        let (f0, before) = &chosen[after.saturating_sub(1)];
        let (f1, next) = &chosen[after.min(chosen.len() - 1)];
        let share = if f1 > f0 { (frame.saturating_sub(*f0)) as f64 / (f1 - f0) as f64 } else { 0.0 };
        poses[frame] = Some(before.stepped(&(next.difference(before) * share)));
    }
    Ok(())
}

/// One guess a frame, so that cost and change from guess to guess are least (Viterbi).
fn most_consistent(guesses: &[(usize, Vec<Hypothesis>)]) -> Vec<(usize, HandPose)> {
    let mut best: Vec<Vec<(f64, usize)>> = Vec::with_capacity(guesses.len());
    for (index, (frame, options)) in guesses.iter().enumerate() {
        let row = options.iter().map(|option| {
            if index == 0 {
                return (option.cost, 0);
            }
            let (before, previous) = &guesses[index - 1];
            let gap = (frame - before) as f64;
            let arrive = previous.iter().enumerate().map(|(p, from)| {
                (best[index - 1][p].0 + option.cost + change(&from.pose, &option.pose, gap), p)
            });
            arrive.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::MAX, 0))
        });
        let row: Vec<(f64, usize)> = row.collect();
        best.push(row);
    }
    let Some(last) = best.last() else { return Vec::new() };
    let mut at = (0..last.len()).min_by(|a, b| last[*a].0.total_cmp(&last[*b].0)).unwrap_or(0);
    let mut chosen = Vec::with_capacity(guesses.len());
    for (index, (frame, options)) in guesses.iter().enumerate().rev() {
        chosen.push((*frame, options[at].pose.clone()));
        at = best[index][at].1;
    }
    chosen.reverse();
    chosen
}

/// Price of getting from one pose to another in `gap` frames.
fn change(from: &HandPose, to: &HandPose, gap: f64) -> f64 {
    let step = to.difference(from);
    let moved = step.fixed_rows::<3>(0).norm() / 0.02;
    let turned = step.fixed_rows::<3>(3).norm() / 0.12;
    let bent = step.fixed_rows::<21>(6).norm() / 0.5;
    let squared = (moved * moved + turned * turned + bent * bent) / gap.max(1.0);
    // Robust: one wild frame must not forbid the truth before and after it.
    40.0 * (squared / (40.0 + squared))
}

/// The longest runs with about `frames` frames together.
fn longest(runs: &[Range<usize>], frames: usize) -> Vec<Range<usize>> {
    let mut ranked = runs.to_vec();
    ranked.sort_by_key(|run| (std::cmp::Reverse(run.len()), run.start));
    let mut chosen = Vec::new();
    let mut left = frames;
    for run in ranked {
        if left == 0 {
            break;
        }
        let taken = run.len().min(left);
        chosen.push(run.start..run.start + taken);
        left -= taken;
    }
    chosen
}

fn batch(sights: &[Option<Sight>], poses: &[Option<HandPose>], ranges: &[Range<usize>]) -> Vec<BatchFrame> {
    let frames = ranges.iter().flat_map(|range| {
        range.clone().filter_map(move |frame| {
            poses[frame].clone().map(|pose| BatchFrame {
                pose,
                sight: sights[frame].clone(),
                predecessors: (frame - range.start).min(2),
                fixed: false,
            })
        })
    });
    frames.collect()
}

fn store(frames: &[BatchFrame], ranges: &[Range<usize>], poses: &mut [Option<HandPose>]) {
    let indices = ranges.iter().flat_map(Clone::clone);
    for (index, frame) in indices.zip(frames) {
        poses[index] = Some(frame.pose.clone());
    }
}

/// Fits the poses of a run with the shape as it is, chunk after chunk.
fn fit_run(
    shape: &mut HandShape,
    sights: &[Option<Sight>],
    run: Range<usize>,
    poses: &mut [Option<HandPose>],
    watch: &dyn Watch,
) -> Result<(), HandsError> {
    let mut start = run.start;
    while start < run.end {
        watch.check()?;
        let end = (start + CHUNK).min(run.end);
        // Two frames of the chunk before hold this one to its motion.
        let held = (start - run.start).min(2);
        let range = start - held..end;
        let mut frames = batch(sights, poses, std::slice::from_ref(&range));
        for frame in frames.iter_mut().take(held) {
            frame.fixed = true;
        }
        refine_all(shape, &mut frames, None, 10);
        store(&frames, std::slice::from_ref(&range), poses);
        start = end;
    }
    Ok(())
}
