//! Which frames a model is shown.

use crate::{
    clip::FrameIndex,
    geometry::Side,
    landmarks::{HandLandmarks, LandmarkTrack, keypoint},
};

/// Frames around one that must speak for it too: a single lucky frame is no grasp.
const AROUND: usize = 3;

/// At most `most` frames in order: of the first, those at 25 % and 50 % and the best contact; the contact counts most.
pub(super) fn chosen(count: usize, landmarks: &LandmarkTrack, most: usize) -> Vec<FrameIndex> {
    let last = count.saturating_sub(1);
    let contact = best_contact(landmarks).map(|at| at.min(last));
    let wanted = contact.into_iter().chain([0, last.div_ceil(4), last.div_ceil(2)]);
    let mut frames: Vec<FrameIndex> = Vec::new();
    for index in wanted.map(|at| FrameIndex(at as u32)) {
        if frames.len() < most && !frames.contains(&index) {
            frames.push(index);
        }
    }
    frames.sort_unstable();
    frames
}

/// The frame around which a hand is seen best and closest to a grasp; `None` where no hand is.
fn best_contact(landmarks: &LandmarkTrack) -> Option<usize> {
    let grasps: Vec<f64> = landmarks
        .iter()
        .map(|hands| {
            let of = |side: Side| hands[side].as_ref().map_or(0.0, grasp);
            of(Side::Left).max(of(Side::Right))
        })
        .collect();
    let mean = |at: usize| {
        let window = &grasps[at.saturating_sub(AROUND)..(at + AROUND + 1).min(grasps.len())];
        window.iter().sum::<f64>() / (2 * AROUND + 1) as f64
    };
    // The first of equals.
    let best = (0..grasps.len()).map(|at| (at, mean(at))).reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    (best.1 > 0.0).then_some(best.0)
}

/// How much a hand looks like one that grasps, 0 to 1: the thumb near the fingers opposite to it.
fn grasp(hand: &HandLandmarks) -> f64 {
    let at = |index: usize| hand.keypoints[index];
    let palm = at(keypoint::WRIST).distance(at(keypoint::BASES[2])).max(1.0);
    let thumb = at(keypoint::TIPS[0]);
    let gap = (thumb.distance(at(keypoint::TIPS[1])) + thumb.distance(at(keypoint::TIPS[2]))) / (2.0 * palm);
    let closed = 1.0 - ((gap - 0.2) / 1.0).clamp(0.0, 1.0);
    // A confidence that is no number speaks for nothing.
    (hand.confidence.clamp(0.0, 1.0) * (0.1 + 0.9 * closed)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{PerSide, Pixel};

    fn hand(gap: f64) -> HandLandmarks {
        let mut keypoints = [Pixel::new(0.0, 0.0); 21];
        keypoints[9] = Pixel::new(0.0, 50.0);
        keypoints[4] = Pixel::new(gap, 80.0);
        (keypoints[8], keypoints[12]) = (Pixel::new(0.0, 80.0), Pixel::new(0.0, 80.0));
        HandLandmarks { keypoints, world: None, confidence: 0.9 }
    }

    fn track(gaps: &[Option<f64>]) -> LandmarkTrack {
        gaps.iter().map(|gap| PerSide { left: None, right: gap.map(hand) }).collect()
    }

    #[test]
    fn the_grasp_is_shown_beside_the_first_half() {
        let mut gaps = vec![Some(70.0); 100];
        gaps[70..80].fill(Some(10.0));
        let frames = chosen(100, &track(&gaps), 4);
        let contact = frames[3].0;
        assert_eq!(frames[..3], [FrameIndex(0), FrameIndex(25), FrameIndex(50)]);
        assert!((73..=76).contains(&contact), "{contact}");
        assert_eq!(chosen(100, &track(&gaps), 1), [FrameIndex(contact)]);
    }

    #[test]
    fn short_clips_and_clips_without_hands_are_shown_too() {
        assert_eq!(chosen(1, &track(&[None]), 4), [FrameIndex(0)]);
        assert_eq!(chosen(3, &track(&[None, None, None]), 4), [0, 1].map(FrameIndex));
        assert_eq!(chosen(40, &Vec::new(), 1), [FrameIndex(0)]);
    }
}
