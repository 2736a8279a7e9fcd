//! Hands that go out of sight behind what they hold.
//!
//! An estimator loses a hand that wraps around an object from behind, for as long as it holds it. The hand
//! is still where it grasped: it moves with the object, which is tracked. So a gap in the landmarks is filled
//! with the hand seen last and the hand seen next, both carried along by the object and blended.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use super::{HandFrame, HandState, HandTrack, HandsError, fit_frame, length_of};
use crate::{
    geometry::{PerSide, Pinhole, Pixel, Side},
    landmarks::{HandLandmarks, KEYPOINT_COUNT, LandmarkTrack},
};

/// Longest gap that is filled while an object is known on all of it, frames.
const LONGEST: usize = 120;
/// Longest gap that is filled without one, frames.
const LONGEST_ALONE: usize = 20;
/// An arm is in the picture where its mask has this share of its usual area …
const ARM_SHARE: f64 = 0.25;
/// … and it has to be on this share of the gap's frames.
const ARM_FRAMES: f64 = 0.6;
/// Share of its confidence that a carried hand keeps.
const TRUST: f64 = 0.4;

/// What tells where a hand that is not seen has gone.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// Area of each arm's mask, pixels, one a frame.
    pub arm_area: PerSide<Vec<u64>>,
    /// Takes any fixed coordinates of the object to pixels of each frame; `None` where it is not known.
    pub object: Vec<Option<Matrix3<f64>>>,
}

/// Landmarks with hidden hands filled in, and which ones these are.
#[derive(Clone, Debug)]
pub struct FilledLandmarks {
    /// One a frame, as long as what came in.
    pub landmarks: LandmarkTrack,
    /// Whether a hand was filled in, one a frame.
    pub filled: PerSide<Vec<bool>>,
}

/// Fills gaps in which the arm stays in the picture between two sightings of its hand.
///
/// `landmarks` are in pixels; lists of `around` shorter than them count as not known.
pub fn fill_hidden(landmarks: &LandmarkTrack, around: &Surroundings) -> FilledLandmarks {
    let mut result = FilledLandmarks {
        landmarks: landmarks.clone(),
        filled: PerSide::from_fn(|_| vec![false; landmarks.len()]),
    };
    for side in Side::BOTH {
        let area = &around.arm_area[side];
        let seen = |frame: usize| landmarks[frame][side].as_ref();
        let usual = usual_area(area, |frame| frame < landmarks.len() && seen(frame).is_some());
        for gap in inner_gaps(landmarks.len(), |frame| seen(frame).is_some()) {
            let (before, after) = (gap.start - 1, gap.end);
            let known = |frame: usize| around.object.get(frame).copied().flatten();
            let carried = (before..=after).all(|frame| known(frame).is_some());
            let in_picture = gap
                .clone()
                .filter(|&frame| area.get(frame).is_some_and(|area| *area as f64 >= ARM_SHARE * usual))
                .count();
            let longest = if carried { LONGEST } else { LONGEST_ALONE };
            if gap.len() > longest || (in_picture as f64) < ARM_FRAMES * gap.len() as f64 {
                continue;
            }
            let (Some(first), Some(last)) = (seen(before), seen(after)) else { continue };
            for frame in gap.clone() {
                let share = (frame - before) as f64 / (after - before) as f64;
                let from = |other: usize| moved(known(other), known(frame));
                result.landmarks[frame][side] =
                    Some(blended(first, &from(before), last, &from(after), share));
                result.filled[side][frame] = true;
            }
        }
    }
    result
}

impl FilledLandmarks {
    /// Puts the hands that were filled in into a `track` that was not fitted to the landmarks: each fitted by itself with
    /// the hand's length, as far away as the hands seen before and after say.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn complete(&self, track: &mut HandTrack, camera: &Pinhole) -> Result<(), HandsError> {
        for side in Side::BOTH {
            let length = length_of(Some(track), side);
            let hands = &mut track.hands[side];
            for frame in 0..hands.len().min(self.landmarks.len()) {
                let filled = self.filled[side].get(frame).copied().unwrap_or(false);
                let Some(seen) = self.landmarks[frame][side].as_ref().filter(|_| filled) else { continue };
                if hands[frame].is_valid() {
                    continue;
                }
                let known = |at: usize| hands[at].is_valid().then(|| (at, hands[at].wrist().xyz.z));
                let before = (0..frame).rev().find_map(known);
                let after = (frame + 1..hands.len()).find_map(known);
                let (Some((from, near)), Some((to, far))) = (before, after) else { continue };
                let mut fitted = fit_frame(seen, side, camera, length, Some(&hands[from]))?;
                if !fitted.is_valid() {
                    continue;
                }
                let wanted = near + (far - near) * (frame - from) as f64 / (to - from) as f64;
                let factor = wanted / fitted.wrist().xyz.z;
                for joint in &mut fitted.joints {
                    joint.xyz *= factor;
                }
                hands[frame] = HandFrame { state: HandState::Bridged, ..fitted };
            }
        }
        Ok(())
    }

    /// Marks the frames that were filled in as bridged in the `track` fitted to the landmarks.
    pub fn mark(&self, track: &mut HandTrack) {
        for side in Side::BOTH {
            for (hand, filled) in track.hands[side].iter_mut().zip(&self.filled[side]) {
                if *filled && hand.is_valid() {
                    hand.state = HandState::Bridged;
                }
            }
        }
    }
}

/// Gaps with a sighting on both ends.
fn inner_gaps(count: usize, seen: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let sightings: Vec<usize> = (0..count).filter(|&frame| seen(frame)).collect();
    sightings.windows(2).filter(|pair| pair[1] > pair[0] + 1).map(|pair| pair[0] + 1..pair[1]).collect()
}

/// Median area over the frames that saw the hand.
fn usual_area(area: &[u64], seen: impl Fn(usize) -> bool) -> f64 {
    let areas: Vec<f64> =
        area.iter().enumerate().filter(|(frame, _)| seen(*frame)).map(|(_, area)| *area as f64).collect();
    crate::smoothing::median(&areas).max(1.0)
}

/// How the object moved from one frame to another; not at all where it is unknown or squeezed flat.
fn moved(from: Option<Matrix3<f64>>, to: Option<Matrix3<f64>>) -> Matrix3<f64> {
    let motion = from.zip(to).and_then(|(from, to)| Some(to * from.try_inverse()?));
    motion.filter(|motion| motion.iter().all(|value| value.is_finite())).unwrap_or_else(Matrix3::identity)
}

fn blended(
    first: &HandLandmarks,
    from_first: &Matrix3<f64>,
    last: &HandLandmarks,
    from_last: &Matrix3<f64>,
    share: f64,
) -> HandLandmarks {
    let carry = |motion: &Matrix3<f64>, at: Pixel| {
        let p = motion * Vector3::new(at.x, at.y, 1.0);
        // A keypoint on or beyond the horizon of a homography has no image: it stays.
        if p.z > 1e-6 { Pixel::new(p.x / p.z, p.y / p.z) } else { at }
    };
    let keypoints: [Pixel; KEYPOINT_COUNT] = std::array::from_fn(|k| {
        let (a, b) = (carry(from_first, first.keypoints[k]), carry(from_last, last.keypoints[k]));
        Pixel::new(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y))
    });
    HandLandmarks { keypoints, world: None, confidence: TRUST * first.confidence.min(last.confidence) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hand(x: f64) -> HandLandmarks {
        let keypoints = std::array::from_fn(|k| Pixel::new(x + 4.0 * k as f64, 100.0));
        HandLandmarks { keypoints, world: None, confidence: 0.9 }
    }

    fn track(count: usize, seen: impl Fn(usize) -> Option<f64>) -> LandmarkTrack {
        (0..count).map(|t| PerSide { left: seen(t).map(hand), right: None }).collect()
    }

    fn shift(x: f64) -> Option<Matrix3<f64>> {
        Some(Matrix3::new(1.0, 0.0, x, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
    }

    fn around(count: usize, area: u64, object: impl Fn(usize) -> Option<Matrix3<f64>>) -> Surroundings {
        let arm_area = PerSide { left: vec![area; count], right: vec![0; count] };
        Surroundings { arm_area, object: (0..count).map(object).collect() }
    }

    #[test]
    fn a_hand_behind_what_it_holds_moves_with_it() {
        // Held still, carried by 5 pixels a frame from frame 20 to 40, held still again.
        let carried = |t: usize| 5.0 * (t.clamp(20, 40) - 20) as f64;
        let seen = |t: usize| (!(10..50).contains(&t)).then(|| 200.0 + carried(t));
        let filled = fill_hidden(&track(60, seen), &around(60, 900, |t| shift(carried(t))));
        for t in 10..50 {
            let hand = filled.landmarks[t].left.as_ref().unwrap();
            assert!((hand.keypoints[0].x - 200.0 - carried(t)).abs() < 1e-6, "frame {t}");
            assert!(filled.filled.left[t] && hand.confidence < 0.5);
        }
        assert!(!filled.filled.left[9] && !filled.filled.right.iter().any(|f| *f));
    }

    #[test]
    fn a_hand_that_left_with_its_arm_is_not_invented() {
        let seen = |t: usize| (!(10..50).contains(&t)).then_some(200.0);
        let mut gone = around(60, 900, |_| shift(0.0));
        gone.arm_area.left[12..48].fill(0);
        let filled = fill_hidden(&track(60, seen), &gone);
        assert!(filled.landmarks[30].left.is_none());
    }

    #[test]
    fn without_an_object_only_short_gaps_are_filled() {
        let seen = |t: usize| (!(5..20).contains(&t) && !(30..70).contains(&t)).then_some(t as f64);
        let filled = fill_hidden(&track(80, seen), &around(80, 900, |_| None));
        assert!((filled.landmarks[12].left.as_ref().unwrap().keypoints[0].x - 12.0).abs() < 1e-6);
        assert!(filled.landmarks[50].left.is_none());
    }

    #[test]
    fn ends_of_the_clip_are_not_made_up() {
        let seen = |t: usize| (10..20).contains(&t).then_some(50.0);
        let filled = fill_hidden(&track(30, seen), &around(30, 900, |_| shift(0.0)));
        assert!(filled.filled.left.iter().all(|f| !f));
    }
}
