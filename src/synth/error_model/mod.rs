//! What an estimator gets wrong: errors laid over true hands, and the track that comes of it.
//!
//! The defaults are fitted to the shipped estimator (MediaPipe Hands 0.10.21) on six real clips, 1,580 detections of
//! 14 hands, 40 to 330 pixels large:
//!
//! * **Slow errors of keypoints.** Every frame was looked at twice: as the pipeline does, where the crop follows the
//!   hand, and afresh. What the two views differ by (standard deviation, median over hands, shares of the hand's
//!   extent) is 0.0081 for all keypoints together and 0.0138 for each on its own, with correlations of 0.73 and 0.50
//!   from frame to frame, 0.50 and 0.29 over three. Two equal views differ by √2 of what each is wrong by; what both
//!   have in common cannot be seen, and is taken to be as much again. A difference of 0.014 that stays over a clip is
//!   each keypoint's own, [`ErrorModel::keypoint_bias`].
//! * **White errors**, from third differences of the tracked keypoints (median over hands): 0.0026 for the whole hand,
//!   0.0043 for each keypoint on its own.
//! * **Depth.** The logarithm of the hand's apparent size, by the same two views: 0.0147 after √2, again taken twice.
//!   The fit's own prior on accelerations leaves no more white error in the depth than 0.0003 and correlations of 0.9
//!   and 0.5 over one and three frames in what lies above 1 Hz. An independent reconstruction of one of the clips
//!   differs by 0.026. [`ErrorModel::depth_bias`] is what a hand measured with a ruler is wrong by; for a person whose
//!   hand is not measured it is 0.05, and every method is off by as much.
//! * **Lag**: what tracked keypoints are behind freshly found ones, 0.04 frames on average.
//! * **Spikes** (all keypoints off by over 0.2 on a single frame): 2. **Dropouts** within a track: 11 of 1.1 frames;
//!   longer losses part a track and were not counted, a mean length of 3 allows for them. **Left and right confused**:
//!   14 frames in 4 bursts.
//! * How far joints lie before or behind the wrist is not known on real clips without truth;
//!   [`ErrorModel::relief`] is the better quarter of rendered episodes, on whose hands the estimator does worse.

mod apply;
mod noise;
mod track;

use serde::{Deserialize, Serialize};

pub use noise::{Bursts, Wander};
pub use track::estimated_track;

/// Errors of a hand estimator as the pipeline uses it. Lengths in pictures are shares of the hand's extent, the
/// longer side of the box around its keypoints; depths are logarithms of a factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ErrorModel {
    /// How late the hand is seen, frames.
    pub lag_frames: f64,
    /// Slow error of all keypoints together, each axis.
    pub shift: Wander,
    /// Slow error of every keypoint on its own, each axis.
    pub keypoint: Wander,
    /// Error of every keypoint on every frame, each axis: white.
    pub jitter: f64,
    /// Error of all keypoints together on every frame, each axis: white.
    pub shake: f64,
    /// Constant error of every keypoint over an episode, each axis.
    pub keypoint_bias: f64,
    /// Depth of an episode as a whole: what is wrong with the stated length of the hand.
    pub depth_bias: f64,
    /// Slow error of the depth.
    pub depth: Wander,
    /// Error of the depth on every frame: white.
    pub depth_jitter: f64,
    /// Slow error of a joint's depth before or behind the wrist, metres.
    pub relief: Wander,
    /// Frames on which the hand is seen somewhere else.
    pub spikes: Bursts,
    /// How far away: the spread of a half-normal distribution.
    pub spike_shift: f64,
    /// How much nearer or farther.
    pub spike_depth: f64,
    /// Frames on which the hand is not seen.
    pub dropouts: Bursts,
    /// Frames on which left is taken for right.
    pub swaps: Bursts,
    /// Largest confidence …
    pub confidence: f64,
    /// … and the spread of what is missing to it.
    pub confidence_spread: f64,
}

impl Default for ErrorModel {
    fn default() -> Self {
        Self {
            lag_frames: 0.04,
            shift: Wander { spread: 0.0081, frames: 3.0 },
            keypoint: Wander { spread: 0.0138, frames: 3.0 },
            jitter: 0.0043,
            shake: 0.0026,
            keypoint_bias: 0.014,
            depth_bias: 0.01,
            depth: Wander { spread: 0.021, frames: 4.0 },
            depth_jitter: 0.0003,
            relief: Wander { spread: 0.005, frames: 4.0 },
            spikes: Bursts { per_second: 0.04, frames: 1.0 },
            spike_shift: 0.5,
            spike_depth: 0.1,
            dropouts: Bursts { per_second: 0.27, frames: 3.0 },
            swaps: Bursts { per_second: 0.08, frames: 3.5 },
            confidence: 0.99,
            confidence_spread: 0.04,
        }
    }
}

impl ErrorModel {
    /// No errors at all.
    pub fn none() -> Self {
        let still = Wander { spread: 0.0, frames: 1.0 };
        let never = Bursts { per_second: 0.0, frames: 1.0 };
        Self {
            lag_frames: 0.0,
            shift: still,
            keypoint: still,
            jitter: 0.0,
            shake: 0.0,
            keypoint_bias: 0.0,
            depth_bias: 0.0,
            depth: still,
            depth_jitter: 0.0,
            relief: still,
            spikes: never,
            spike_shift: 0.0,
            spike_depth: 0.0,
            dropouts: never,
            swaps: never,
            confidence: 1.0,
            confidence_spread: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::Side,
        synth::{EpisodeSpec, MotionTruth, motion_truth},
    };

    fn truth(seed: u64) -> MotionTruth {
        motion_truth(&EpisodeSpec { seed, both_hands: Some(true), ..EpisodeSpec::default() }).unwrap()
    }

    /// Distances of the wrist to the true one where both are known, metres.
    fn wrist_errors(truth: &MotionTruth, model: &ErrorModel) -> Vec<f64> {
        let track = estimated_track(truth, model);
        let of = |side: Side| {
            let pairs = truth.frames.iter().zip(&track.hands[side]);
            pairs.filter_map(move |(frame, hand)| {
                let known = frame[side].as_ref().filter(|hand| hand.in_view)?;
                hand.is_valid().then(|| hand.wrist().distance(&known.joints[0]))
            })
        };
        Side::BOTH.into_iter().flat_map(of).collect()
    }

    #[test]
    fn without_errors_only_the_pipelines_smoothing_stands_between_track_and_truth() {
        let errors = wrist_errors(&truth(7), &ErrorModel::none());
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(errors.len() > 100 && mean < 1e-3, "{} frames, {mean}", errors.len());
    }

    #[test]
    fn a_seed_has_its_errors_and_they_are_as_large_as_stated() {
        let episode = truth(8);
        assert_eq!(
            estimated_track(&episode, &ErrorModel::default()),
            estimated_track(&episode, &ErrorModel::default())
        );
        let all: Vec<f64> =
            (1..12).flat_map(|seed| wrist_errors(&truth(seed), &ErrorModel::default())).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        // About 2 % of half a metre in depth, and a pixel or two across.
        println!("{} frames, mean wrist error {:.2} cm", all.len(), 100.0 * mean);
        assert!((0.005..0.02).contains(&mean), "{mean}");
    }

    #[test]
    fn confused_sides_are_put_right_and_short_gaps_bridged() {
        let model = ErrorModel {
            swaps: Bursts { per_second: 1.0, frames: 3.0 },
            dropouts: Bursts { per_second: 1.0, frames: 2.0 },
            ..ErrorModel::none()
        };
        for seed in [3, 9] {
            let episode = truth(seed);
            let errors = wrist_errors(&episode, &model);
            let in_view: usize = Side::BOTH
                .into_iter()
                .map(|side| episode.frames.iter().flat_map(|f| &f[side]).filter(|hand| hand.in_view).count())
                .sum();
            let worst = errors.iter().copied().fold(0.0, f64::max);
            assert!(worst < 0.05, "seed {seed}: {worst}");
            assert!(errors.len() as f64 > 0.9 * in_view as f64, "seed {seed}: {} of {in_view}", errors.len());
        }
    }
}
