//! Keypoints freed of the estimator's jitter before anything is built on them.

use super::{detection::extent, sides::SideDetections};
use crate::{
    clip::STANDARD_FPS,
    geometry::Pixel,
    landmarks::KEYPOINT_COUNT,
    smoothing::{median, smooth_together},
};

/// Residuals below this share of the hand's extent are noise of a usual estimator, not outliers.
const FLOOR: f64 = 0.02;

/// Smooths every keypoint of one side over each run of frames that saw the hand, without lag and with single
/// jumps held off. Half of a motion's amplitude is left at `cutoff_hz`.
///
/// Frames that repeat the one before (a source slower than the standard rate) count as one sample and keep
/// sharing their keypoints, so that these stay on what the frames show.
pub(super) fn smooth_keypoints(track: &mut SideDetections, cutoff_hz: f64) {
    let mut start = 0;
    while start < track.len() {
        let end = track[start..].iter().position(Option::is_none).map_or(track.len(), |gap| start + gap);
        smooth_run(&mut track[start..end], cutoff_hz);
        start = end + 1;
    }
}

fn smooth_run(run: &mut [Option<super::detection::Detection>], cutoff_hz: f64) {
    let keypoints: Vec<[Pixel; KEYPOINT_COUNT]> = run.iter().flatten().map(|hand| hand.keypoints).collect();
    // The sample that each frame shows.
    let mut samples: Vec<[Pixel; KEYPOINT_COUNT]> = Vec::with_capacity(keypoints.len());
    let mut sample_of = Vec::with_capacity(keypoints.len());
    for hand in &keypoints {
        if samples.last() != Some(hand) {
            samples.push(*hand);
        }
        sample_of.push(samples.len() - 1);
    }
    let rate = STANDARD_FPS * samples.len() as f64 / keypoints.len().max(1) as f64;
    let floor = FLOOR * median(&samples.iter().map(extent).collect::<Vec<_>>());
    let weights = vec![1.0; samples.len()];
    for keypoint in 0..KEYPOINT_COUNT {
        let x: Vec<f64> = samples.iter().map(|hand| hand[keypoint].x).collect();
        let y: Vec<f64> = samples.iter().map(|hand| hand[keypoint].y).collect();
        let smoothed = smooth_together(&[&x, &y], &weights, cutoff_hz / rate, floor);
        for (hand, sample) in run.iter_mut().flatten().zip(&sample_of) {
            hand.keypoints[keypoint] = Pixel::new(smoothed[0][*sample], smoothed[1][*sample]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::Side, hands::detection::Detection};

    fn hand(x: f64) -> Option<Detection> {
        let keypoints = std::array::from_fn(|k| Pixel::new(x + 5.0 * k as f64, 100.0 + 3.0 * k as f64));
        Some(Detection { side: Side::Left, score: 0.9, keypoints, world: None })
    }

    fn wrist(track: &SideDetections, frame: usize) -> f64 {
        track[frame].as_ref().unwrap().keypoints[0].x
    }

    #[test]
    fn jitter_and_a_jump_of_fifty_pixels_go_and_the_motion_stays_within_two() {
        let motion = |t: usize| 200.0 + 60.0 * (t as f64 * 0.1).sin();
        let mut track: SideDetections = (0..90).map(|t| hand(motion(t) + [0.8, -0.8][t % 2])).collect();
        track[40].as_mut().unwrap().keypoints[0].x += 50.0;
        smooth_keypoints(&mut track, 6.0);
        for t in 3..87 {
            assert!(
                (wrist(&track, t) - motion(t)).abs() < 2.0,
                "frame {t}: {}",
                wrist(&track, t) - motion(t)
            );
        }
    }

    #[test]
    fn a_gap_parts_what_is_smoothed_and_stays_a_gap() {
        let mut track: SideDetections = (0..20).map(|_| hand(100.0)).collect();
        track.push(None);
        track.extend((0..20).map(|_| hand(400.0)));
        smooth_keypoints(&mut track, 6.0);
        assert!(track[20].is_none());
        assert!((wrist(&track, 19) - 100.0).abs() < 1e-6 && (wrist(&track, 21) - 400.0).abs() < 1e-6);
    }

    #[test]
    fn repeated_frames_keep_sharing_their_keypoints() {
        let mut track: SideDetections = (0..60).map(|t| hand(100.0 + 6.0 * f64::from(t / 2))).collect();
        smooth_keypoints(&mut track, 6.0);
        for t in (0..60).step_by(2) {
            assert!((wrist(&track, t) - wrist(&track, t + 1)).abs() < 1e-9);
            assert!((wrist(&track, t) - 100.0 - 3.0 * t as f64).abs() < 0.5);
        }
    }
}
