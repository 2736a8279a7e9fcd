//! Detections that contradict their neighbours in time.

use super::{
    detection::{distance, interpolate},
    sides::SideDetections,
};

/// A detection this far from where its neighbours put it, in hand extents, …
const FAR: f64 = 0.5;
/// … is wrong if the neighbours agree with each other this well.
const NEAR: f64 = 0.35;
/// Frames to look for neighbours.
const REACH: usize = 4;

/// Removes single detections and pairs that jump away from the hand and back.
pub(super) fn remove_jumps(track: &mut SideDetections) {
    // Judged against the track as it came, so that the order of removal plays no part.
    let before = track.clone();
    for (frame, slot) in track.iter_mut().enumerate() {
        let Some(detection) = &before[frame] else { continue };
        // Neighbours that are not part of the same jump or the same repeated source frame.
        let differs = |other: usize| {
            before[other].as_ref().filter(|d| distance(&d.keypoints, &detection.keypoints) > FAR)
        };
        let earlier = (frame.saturating_sub(REACH)..frame).rev().find_map(|f| differs(f).map(|d| (f, d)));
        let later =
            (frame + 1..(frame + 1 + REACH).min(before.len())).find_map(|f| differs(f).map(|d| (f, d)));
        let (Some((f0, d0)), Some((f1, d1))) = (earlier, later) else { continue };
        if distance(&d0.keypoints, &d1.keypoints) < NEAR {
            let share = (frame - f0) as f64 / (f1 - f0) as f64;
            let expected = interpolate(&d0.keypoints, &d1.keypoints, share);
            if distance(&expected, &detection.keypoints) > FAR {
                *slot = None;
            }
        }
    }
}
