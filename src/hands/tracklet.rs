//! Detections linked over time by position and shape, whatever side the estimator named.

use super::detection::{Detection, distance, interpolate};
use crate::{geometry::Pixel, landmarks::KEYPOINT_COUNT};

/// One hand followed over consecutive frames.
#[derive(Clone, Debug)]
pub(super) struct Tracklet {
    /// Frame number and detection, frames rising.
    pub entries: Vec<(usize, Detection)>,
}

/// Frames a hand may be missing within one tracklet.
const LONGEST_GAP: usize = 6;
/// Largest distance, in hand extents, of a detection to where its tracklet is expected.
const LARGEST_STEP: f64 = 0.40;
/// Two detections of one frame closer than this are the same hand seen twice.
const SAME_HAND: f64 = 0.22;
/// Cosine of the largest angle between a forearm and what lies along it.
const ALONG: f64 = 0.8;
/// A hand this much less sure than another may be that one's forearm.
const DOUBT: f64 = 0.1;
/// Length of the visible forearm, palms.
const FOREARM: f64 = 3.0;

impl Tracklet {
    fn last(&self) -> &(usize, Detection) {
        // A tracklet is made with an entry and never loses one.
        &self.entries[self.entries.len() - 1]
    }

    /// Where the hand is expected on `frame`, by its last displacement, damped over gaps.
    fn expected(&self, frame: usize) -> [Pixel; KEYPOINT_COUNT] {
        let (last_frame, last) = self.last();
        let before = self.entries.iter().rev().skip(1).find(|(f, _)| last_frame - f <= 3);
        let Some((before_frame, before)) = before else {
            return last.keypoints;
        };
        let steps = (frame - last_frame).min(2) as f64 / (last_frame - before_frame) as f64;
        interpolate(&before.keypoints, &last.keypoints, 1.0 + steps)
    }

    /// How far `detection` on `frame` is from this hand: the nearer of standing still and moving on.
    fn distance_to(&self, frame: usize, detection: &Detection) -> f64 {
        let still = distance(&self.last().1.keypoints, &detection.keypoints);
        still.min(distance(&self.expected(frame), &detection.keypoints))
    }
}

/// Links the detections of all frames into tracklets, in order of their first frame.
pub(super) fn link(frames: Vec<Vec<Detection>>) -> Vec<Tracklet> {
    let mut tracklets: Vec<Tracklet> = Vec::new();
    for (frame, detections) in frames.into_iter().enumerate() {
        let detections = without_doubles(detections);
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (t, tracklet) in tracklets.iter().enumerate() {
            let gap = frame - tracklet.last().0;
            if gap > LONGEST_GAP {
                continue;
            }
            let limit = LARGEST_STEP * (1.0 + 0.15 * (gap - 1) as f64);
            for (d, detection) in detections.iter().enumerate() {
                let distance = tracklet.distance_to(frame, detection);
                if distance < limit {
                    pairs.push((distance, t, d));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut detections: Vec<Option<Detection>> = detections.into_iter().map(Some).collect();
        for (_, t, d) in pairs {
            if tracklets[t].last().0 < frame
                && let Some(detection) = detections[d].take()
            {
                tracklets[t].entries.push((frame, detection));
            }
        }
        let left_over = detections.into_iter().flatten();
        tracklets.extend(left_over.map(|detection| Tracklet { entries: vec![(frame, detection)] }));
    }
    tracklets
}

/// The detections of one frame without a second view of the same hand, nor a "hand" that lies along another
/// hand's forearm; the surer one stays.
fn without_doubles(mut detections: Vec<Detection>) -> Vec<Detection> {
    detections.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut kept: Vec<Detection> = Vec::new();
    for detection in detections {
        let doubles = |k: &Detection| {
            distance(&k.keypoints, &detection.keypoints) <= SAME_HAND || lies_on_forearm(&detection, k)
        };
        if !kept.iter().any(doubles) {
            kept.push(detection);
        }
    }
    kept
}

/// Whether `phantom` points the way `hand` does from where the forearm of `hand` is: a tracker that lost its
/// hand often slides down the arm. A real second hand there points across the arm, or the other way.
fn lies_on_forearm(phantom: &Detection, hand: &Detection) -> bool {
    let along = |d: &Detection| (d.keypoints[9].x - d.keypoints[0].x, d.keypoints[9].y - d.keypoints[0].y);
    let cosine =
        |a: (f64, f64), b: (f64, f64)| (a.0 * b.0 + a.1 * b.1) / (a.0.hypot(a.1) * b.0.hypot(b.1)).max(1e-9);
    let (wrist, other) = (hand.keypoints[0], phantom.keypoints[0]);
    let behind = (wrist.x - other.x, wrist.y - other.y);
    let palm = along(hand).0.hypot(along(hand).1);
    let reach = behind.0.hypot(behind.1);
    let (direction, own) = (cosine(behind, along(hand)), cosine(along(phantom), along(hand)));
    let doubtful = phantom.score < hand.score - DOUBT;
    doubtful && direction > ALONG && own > ALONG && (0.5 * palm..FOREARM * palm).contains(&reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Side;

    fn hand(x: f64, y: f64, side: Side) -> Detection {
        let keypoints =
            std::array::from_fn(|k| Pixel::new(x + 20.0 * (k % 5) as f64, y + 20.0 * (k / 5) as f64));
        Detection { side, score: 0.9, keypoints, world: None }
    }

    #[test]
    fn a_hand_that_slid_down_its_own_arm_is_not_a_second_one() {
        let real = hand(300.0, 200.0, Side::Left);
        // The hand points right and down; its forearm lies up and to the left.
        let slid = Detection { score: 0.6, ..hand(200.0, 175.0, Side::Right) };
        assert_eq!(without_doubles(vec![slid, real.clone()]), std::slice::from_ref(&real));
        let beside = Detection { score: 0.6, ..hand(200.0, 400.0, Side::Right) };
        assert_eq!(without_doubles(vec![real, beside]).len(), 2);
    }

    #[test]
    fn two_hands_that_pass_each_other_stay_two_tracklets() {
        let frames = (0..40)
            .map(|t| {
                let t = f64::from(t);
                vec![hand(100.0 + 8.0 * t, 100.0, Side::Left), hand(420.0 - 8.0 * t, 130.0, Side::Right)]
            })
            .collect();
        let tracklets = link(frames);
        assert_eq!(tracklets.len(), 2);
        for tracklet in tracklets {
            let side = tracklet.entries[0].1.side;
            assert!(tracklet.entries.iter().all(|(_, d)| d.side == side));
        }
    }

    #[test]
    fn a_hand_seen_twice_in_a_frame_is_one_hand() {
        let frames = vec![vec![hand(100.0, 100.0, Side::Left), hand(103.0, 101.0, Side::Right)]];
        assert_eq!(link(frames).len(), 1);
    }
}
