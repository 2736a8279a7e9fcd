//! Hands named frame by frame, made two tracks: the part of the estimate that needs no pictures.

use super::{
    detection::Detection,
    outliers::remove_jumps,
    sides::{assign, landmarks_of},
    smooth::smooth_keypoints,
    tracklet::link,
};
use crate::{
    geometry::{Side, Size},
    landmarks::{HandLandmarks, LandmarkTrack},
};

/// A hand in one picture as an estimator names it.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedHand {
    /// The side that the estimator believes in.
    pub side: Side,
    /// What it saw; the confidence is its trust in hand and side.
    pub landmarks: HandLandmarks,
}

/// Follows the hands of `frames` over time, in pictures of `size`: detections are linked, left and right told apart,
/// jumps removed and keypoints smoothed at `smoothing_hz`, as [`estimate`](fn@super::estimate) does; only the second,
/// magnified look at missed hands is not had without pictures. `world` comes through untouched.
pub fn follow(frames: Vec<Vec<NamedHand>>, size: Size, smoothing_hz: f64) -> LandmarkTrack {
    let count = frames.len();
    let detections = frames.into_iter().map(|hands| hands.into_iter().map(detection).collect()).collect();
    let mut sides = assign(link(detections), count, size);
    for side in [&mut sides.left, &mut sides.right] {
        remove_jumps(side);
        smooth_keypoints(side, smoothing_hz);
    }
    landmarks_of(sides)
}

fn detection(hand: NamedHand) -> Detection {
    let HandLandmarks { keypoints, world, confidence } = hand.landmarks;
    Detection { side: hand.side, score: confidence, keypoints, world }
}
