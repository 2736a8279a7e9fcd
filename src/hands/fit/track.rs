//! From fitted poses to the hand track.

use super::{kinematics::joints, side::FittedSide};
use crate::{
    geometry::{Pinhole, Pixel, Position, Side},
    hands::{HandFrame, HandState},
    landmarks::{KEYPOINT_COUNT, LandmarkTrack},
};

/// Share of confidence a bridged frame keeps for each frame of distance to a seen one.
const BRIDGE_DECAY: f64 = 0.9;
/// A reprojection error of this share of the hand's extent halves the confidence.
const POOR_FIT: f64 = 0.12;

/// One hand's frames and its length in metres.
pub(super) fn to_frames(
    landmarks: &LandmarkTrack,
    side: Side,
    pinhole: &Pinhole,
    fitted: FittedSide,
) -> (Vec<HandFrame>, Option<f64>) {
    let mirror = if side == Side::Right { -1.0 } else { 1.0 };
    let mut frames: Vec<HandFrame> = Vec::with_capacity(landmarks.len());
    for (hands, pose) in landmarks.iter().zip(&fitted.poses) {
        let Some(pose) = pose else {
            frames.push(HandFrame::invalid());
            continue;
        };
        let joints = joints(&fitted.shape, pose).map(|mut p| {
            p.x *= mirror;
            Position::new(p)
        });
        let projected: Option<Vec<Pixel>> = joints.iter().map(|j| pinhole.project(j)).collect();
        let projected: Option<[Pixel; KEYPOINT_COUNT]> = projected.and_then(|p| p.try_into().ok());
        let finite = joints.iter().all(Position::is_finite);
        let Some(projected) = projected.filter(|_| finite) else {
            frames.push(HandFrame::invalid());
            continue;
        };
        frames.push(match &hands[side] {
            Some(seen) => {
                let error = relative_error(&seen.keypoints, &projected);
                let confidence = seen.confidence / (1.0 + (error / POOR_FIT).powi(2));
                HandFrame {
                    state: HandState::Observed,
                    confidence,
                    keypoints: seen.keypoints,
                    joints,
                    mano: None,
                }
            }
            None => HandFrame {
                state: HandState::Bridged,
                confidence: 0.0,
                keypoints: projected,
                joints,
                mano: None,
            },
        });
    }
    fade_bridges(&mut frames);
    let known = frames.iter().any(HandFrame::is_valid);
    (frames, known.then(|| fitted.shape.length()))
}

/// RMS distance as a share of the seen hand's extent.
fn relative_error(seen: &[Pixel; KEYPOINT_COUNT], projected: &[Pixel; KEYPOINT_COUNT]) -> f64 {
    let sum: f64 = seen.iter().zip(projected).map(|(a, b)| a.distance(*b).powi(2)).sum();
    (sum / KEYPOINT_COUNT as f64).sqrt() / crate::hands::detection::extent(seen)
}

/// Confidence of bridged frames from the nearest seen ones on both sides.
fn fade_bridges(frames: &mut [HandFrame]) {
    let seen: Vec<Option<f64>> =
        frames.iter().map(|f| (f.state == HandState::Observed).then_some(f.confidence)).collect();
    for (index, frame) in frames.iter_mut().enumerate() {
        if frame.state != HandState::Bridged {
            continue;
        }
        let reach = |found: Option<(usize, f64)>| {
            found.map_or(0.0, |(at, c)| c * BRIDGE_DECAY.powi(at.abs_diff(index) as i32))
        };
        let known = |f: usize| seen[f].map(|c| (f, c));
        let before = (0..index).rev().find_map(known);
        let after = (index + 1..seen.len()).find_map(known);
        frame.confidence = reach(before).min(reach(after));
    }
}
