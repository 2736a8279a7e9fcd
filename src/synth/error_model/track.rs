//! From what an estimator said to the track that a method gets.

use std::ops::Range;

use super::{ErrorModel, apply::seen_hands};
use crate::{
    geometry::{PerSide, Pinhole, Pixel, Side},
    hands::{EstimateParams, FitParams, HandFrame, HandState, HandTrack, follow},
    landmarks::{HandLandmarks, KEYPOINT_COUNT, LandmarkTrack},
    synth::MotionTruth,
};

/// The hand track that the pipeline would hand on for `truth`, had its estimator the errors of `model`.
///
/// What an estimator says passes the pipeline's own cleaning as far as that works without pictures: detections are
/// linked to hands, left and right told apart, jumps removed, keypoints smoothed ([`follow`](fn@follow)), hands seen
/// too briefly left out and short gaps bridged as in the fit. Left out are the magnified second look and hands carried along
/// behind their object, which need pictures and masks, and the fit itself: its errors in depth are part of the model.
pub fn estimated_track(truth: &MotionTruth, model: &ErrorModel) -> HandTrack {
    let smoothing_hz = EstimateParams::default().smoothing_hz;
    let landmarks = follow(seen_hands(truth, model), truth.pinhole.size, smoothing_hz);
    let hands = PerSide::from_fn(|side| side_frames(&landmarks, side, &truth.pinhole));
    let hand_length = PerSide::from_fn(|side: Side| {
        hands[side].iter().any(HandFrame::is_valid).then_some(truth.hand_length)
    });
    HandTrack { hands, hand_length, backend: "error model".to_owned() }
}

fn side_frames(landmarks: &LandmarkTrack, side: Side, pinhole: &Pinhole) -> Vec<HandFrame> {
    let params = FitParams::default();
    let mut frames = vec![HandFrame::invalid(); landmarks.len()];
    let seen: Vec<usize> = (0..landmarks.len()).filter(|frame| landmarks[*frame][side].is_some()).collect();
    for run in runs(&seen, params.longest_bridge) {
        let known: Vec<usize> = seen.iter().copied().filter(|frame| run.contains(frame)).collect();
        if known.len() < params.shortest_run {
            continue;
        }
        for frame in run {
            let next = known.partition_point(|other| *other < frame).min(known.len() - 1);
            let (a, b) = (known[next.saturating_sub(1)], known[next]);
            frames[frame] = match (&landmarks[frame][side], &landmarks[a][side], &landmarks[b][side]) {
                (Some(hand), _, _) => lifted(hand, pinhole, HandState::Observed, hand.confidence),
                (None, Some(before), Some(after)) => bridged(before, after, [a, frame, b], pinhole),
                _ => HandFrame::invalid(),
            };
        }
    }
    frames
}

/// Runs of frames with gaps of at most `longest`.
fn runs(seen: &[usize], longest: usize) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for &frame in seen {
        match runs.last_mut() {
            Some(run) if frame - run.end <= longest => run.end = frame + 1,
            _ => runs.push(frame..frame + 1),
        }
    }
    runs
}

/// The hand whose keypoints lie where they are seen and as deep as they were said to be.
fn lifted(hand: &HandLandmarks, pinhole: &Pinhole, state: HandState, confidence: f64) -> HandFrame {
    let Some(world) = &hand.world else { return HandFrame::invalid() };
    let joints = std::array::from_fn(|k| pinhole.unproject(hand.keypoints[k], world[k].z));
    HandFrame { state, confidence, keypoints: hand.keypoints, joints, mano: None }
}

/// A frame of a gap: keypoints and depths between those on its ends, trusted less the farther they are.
fn bridged(
    before: &HandLandmarks,
    after: &HandLandmarks,
    [first, at, last]: [usize; 3],
    pinhole: &Pinhole,
) -> HandFrame {
    let share = (at - first) as f64 / (last - first) as f64;
    let between = |k: usize| {
        let (a, b) = (before.keypoints[k], after.keypoints[k]);
        Pixel::new(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y))
    };
    let keypoints: [Pixel; KEYPOINT_COUNT] = std::array::from_fn(between);
    let world = before.world.zip(after.world).map(|(a, b)| std::array::from_fn(|k| a[k].lerp(&b[k], share)));
    let fade = |confidence: f64, frames: usize| confidence * 0.9_f64.powi(frames as i32);
    let confidence = fade(before.confidence, at - first).min(fade(after.confidence, last - at));
    let hand = HandLandmarks { keypoints, world, confidence };
    lifted(&hand, pinhole, HandState::Bridged, confidence)
}
