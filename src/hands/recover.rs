//! Looking again, magnified, where a hand was missed.

use std::ops::Range;

use opencv::{
    core::{BORDER_REPLICATE, Mat, Scalar, Size as CvSize},
    imgproc::{INTER_LINEAR, WARP_INVERSE_MAP, warp_affine},
};

use super::{
    HandsError,
    detection::{Detection, bounds, distance, extent, interpolate},
    estimate::EstimateParams,
    estimator::{EstimatorProcess, Mode, Request},
    sides::SideDetections,
};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::{PerSide, Pixel, Side},
    image::Rgb8,
    landmarks::KEYPOINT_COUNT,
    progress::Watch,
};

type Keypoints = [Pixel; KEYPOINT_COUNT];

/// Side of the crop in hand extents: MediaPipe's palm detector wants the hand at about a third.
const CROP_EXTENTS: f64 = 2.4;
/// Side of the crop as sent, pixels.
const CROP_PIXELS: i32 = 384;
/// A recovered hand is this near, in extents, to where it was expected.
const NEAR: f64 = 0.55;
/// A recovered hand is at least this far from the other hand.
const APART: f64 = 0.3;
/// Relative change of extent that is believed from one frame to the next.
const GROWTH: f64 = 1.7;

/// Follows each hand from its known frames into the missed ones, forwards and then backwards, with
/// at most `budget` looks. Returns the looks made.
pub(super) fn recover(
    frames: &dyn FrameSource,
    estimator: &mut EstimatorProcess,
    sides: &mut PerSide<SideDetections>,
    params: &EstimateParams,
    mut budget: usize,
    watch: &dyn Watch,
) -> Result<(), HandsError> {
    for side in Side::BOTH {
        for gap in gaps(&sides[side]) {
            for backwards in [false, true] {
                follow(frames, estimator, sides, side, gap.clone(), backwards, params, &mut budget, watch)?;
            }
        }
    }
    Ok(())
}

/// Runs of frames without a hand that border on a frame with one.
fn gaps(track: &SideDetections) -> Vec<Range<usize>> {
    let mut gaps = Vec::new();
    let mut start = 0;
    for frame in 0..=track.len() {
        if frame == track.len() || track[frame].is_some() {
            if frame > start && frame - start < track.len() {
                gaps.push(start..frame);
            }
            start = frame + 1;
        }
    }
    gaps
}

#[expect(clippy::too_many_arguments, reason = "the parts of one loop, split off for length")]
fn follow(
    frames: &dyn FrameSource,
    estimator: &mut EstimatorProcess,
    sides: &mut PerSide<SideDetections>,
    side: Side,
    gap: Range<usize>,
    backwards: bool,
    params: &EstimateParams,
    budget: &mut usize,
    watch: &dyn Watch,
) -> Result<(), HandsError> {
    let mut misses = 0;
    let order: Box<dyn Iterator<Item = usize>> =
        if backwards { Box::new(gap.clone().rev()) } else { Box::new(gap.clone()) };
    for frame in order {
        if sides[side][frame].is_some() {
            continue;
        }
        let Some(expected) = expectation(&sides[side], frame, &gap, backwards) else { return Ok(()) };
        if misses >= params.recover_misses || *budget == 0 {
            return Ok(());
        }
        watch.check()?;
        *budget -= 1;
        let index = FrameIndex(frame as u32);
        let candidates = look(&frames.frame(index)?, index, &expected, misses, estimator)?;
        let other = sides[side.other()][frame].as_ref().map(|d| d.keypoints);
        match choose(candidates, side, &expected, other.as_ref()) {
            Some(found) => {
                sides[side][frame] = Some(found);
                misses = 0;
            }
            None => misses += 1,
        }
    }
    Ok(())
}

/// Where the hand should be: between its known frames on both sides of a gap, or where it was last.
fn expectation(
    track: &SideDetections,
    frame: usize,
    gap: &Range<usize>,
    backwards: bool,
) -> Option<Keypoints> {
    let known = |f: usize| track[f].as_ref().map(|d| (f, d.keypoints));
    let earlier = (gap.start.saturating_sub(1)..frame).rev().find_map(known);
    let later = (frame + 1..(gap.end + 1).min(track.len())).find_map(known);
    match (earlier, later) {
        (Some((f0, k0)), Some((f1, k1))) if f1 - f0 <= 16 => {
            Some(interpolate(&k0, &k1, (frame - f0) as f64 / (f1 - f0) as f64))
        }
        (Some((_, k0)), _) if !backwards => Some(k0),
        (_, Some((_, k1))) if backwards => Some(k1),
        _ => None,
    }
}

/// Sends the magnified surroundings of `expected`; answers are in pixels of the clip.
fn look(
    picture: &Rgb8,
    frame: FrameIndex,
    expected: &Keypoints,
    misses: usize,
    estimator: &mut EstimatorProcess,
) -> Result<Vec<Detection>, HandsError> {
    let centre = bounds(expected).centre();
    let side = extent(expected) * CROP_EXTENTS * (1.0 + 0.15 * misses as f64);
    let scale = side / f64::from(CROP_PIXELS);
    let (x0, y0) = (centre.x - 0.5 * side + 0.5 * scale, centre.y - 0.5 * side + 0.5 * scale);
    let map = Mat::from_slice_2d(&[[scale, 0.0, x0], [0.0, scale, y0]])?;
    let mut crop = Mat::default();
    warp_affine(
        &picture.to_mat()?,
        &mut crop,
        &map,
        CvSize::new(CROP_PIXELS, CROP_PIXELS),
        INTER_LINEAR | WARP_INVERSE_MAP,
        BORDER_REPLICATE,
        Scalar::all(0.0),
    )?;
    let request = Request { frame, mode: Mode::Single, picture: Rgb8::from_mat(&crop)? };
    let mut detections = estimator.ask(request)?;
    for detection in &mut detections {
        for p in &mut detection.keypoints {
            *p = Pixel::new(x0 + scale * p.x, y0 + scale * p.y);
        }
    }
    Ok(detections)
}

/// The candidate nearest to the expectation that is not the other hand.
fn choose(
    candidates: Vec<Detection>,
    side: Side,
    expected: &Keypoints,
    other: Option<&Keypoints>,
) -> Option<Detection> {
    candidates
        .into_iter()
        .map(|candidate| {
            let wrong_side = if candidate.side == side { 0.0 } else { 0.15 };
            (distance(&candidate.keypoints, expected) + wrong_side, candidate)
        })
        .filter(|(distance_to, candidate)| {
            let growth = candidate.extent() / extent(expected);
            *distance_to < NEAR
                && (1.0 / GROWTH..GROWTH).contains(&growth)
                && other.is_none_or(|other| distance(&candidate.keypoints, other) > APART)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        // Seen only when told where to look: a little less to be trusted.
        .map(|(_, candidate)| Detection { side, score: 0.8 * candidate.score, ..candidate })
}
