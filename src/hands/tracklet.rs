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

/// The detections of one frame without a second view of the same hand; the surer one stays.
fn without_doubles(mut detections: Vec<Detection>) -> Vec<Detection> {
    detections.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut kept: Vec<Detection> = Vec::new();
    for detection in detections {
        if kept.iter().all(|k| distance(&k.keypoints, &detection.keypoints) > SAME_HAND) {
            kept.push(detection);
        }
    }
    kept
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
