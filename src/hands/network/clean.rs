//! One side's hands freed of what a network says of single frames: jumps, jitter, a hand that grows and shrinks.

use nalgebra::Vector3;

use super::place::PlacedHand;
use crate::{
    clip::STANDARD_FPS,
    geometry::{Camera, Pinhole, Pixel, Position},
    hands::{HandFrame, HandState, ManoHand, detection::extent},
    landmarks::{KEYPOINT_COUNT, keypoint::WRIST},
    smoothing::{median, smooth_together},
};

/// Half-power frequency of the smoother, Hz, as of an estimator's keypoints.
const CUTOFF_HZ: f64 = 6.0;
/// Frames on either side that a wrist is compared with.
const WINDOW: usize = 5;
/// Robust spreads, but at least so many metres, beyond which a wrist is somewhere else (Hampel).
const SPREADS: f64 = 3.0;
const LEAST_JUMP: f64 = 0.04;
/// Longest gap that is bridged, frames.
const LONGEST_BRIDGE: usize = 5;
/// Share of its trust that a bridged hand keeps for each frame of distance to a seen one.
const BRIDGE_DECAY: f64 = 0.8;
/// Residuals below this are noise: of joints in metres, of keypoints as a share of the hand's extent.
const JOINT_FLOOR: f64 = 0.004;
const KEYPOINT_FLOOR: f64 = 0.02;
/// From the wrist to the middle finger's tip.
const MIDDLE: [usize; 5] = [WRIST, 9, 10, 11, 12];

/// A hand on a frame, and the trust in it.
pub(super) type Seen = Option<(PlacedHand, f64)>;

/// One side's frames and the hand's length in metres.
pub(super) fn cleaned(mut seen: Vec<Seen>, camera: &Pinhole) -> (Vec<HandFrame>, Option<f64>) {
    let length = of_one_length(&mut seen);
    without_jumps(&mut seen);
    let mut start = 0;
    while start < seen.len() {
        let end = seen[start..].iter().position(Option::is_none).map_or(seen.len(), |gap| start + gap);
        smooth_run(&mut seen[start..end]);
        start = end + 1;
    }
    let frame = |hand: &Seen| match hand {
        Some((hand, trust)) => HandFrame {
            state: HandState::Observed,
            confidence: *trust,
            keypoints: hand.keypoints,
            joints: hand.joints,
            mano: hand.mano.map(Box::new),
        },
        None => HandFrame::invalid(),
    };
    let mut frames: Vec<HandFrame> = seen.iter().map(frame).collect();
    bridge(&mut frames, camera);
    (frames, length)
}

/// A person's hand has one length. Nearer and smaller look the same: every hand is moved along its rays to where it is as
/// long as the clip's hands are in the middle.
fn of_one_length(seen: &mut [Seen]) -> Option<f64> {
    let length = |joints: &[Position<Camera>; KEYPOINT_COUNT]| {
        MIDDLE.windows(2).map(|bone| joints[bone[1]].distance(&joints[bone[0]])).sum::<f64>()
    };
    let lengths: Vec<f64> = seen.iter().flatten().map(|(hand, _)| length(&hand.joints)).collect();
    let usual = median(&lengths);
    if usual < 1e-3 {
        return None;
    }
    for (hand, _) in seen.iter_mut().flatten() {
        let factor = usual / length(&hand.joints).max(1e-3);
        for joint in &mut hand.joints {
            joint.xyz *= factor;
        }
    }
    Some(usual)
}

/// Takes out wrists that lie far from the middle of those around them (Hampel's filter).
fn without_jumps(seen: &mut [Seen]) {
    let wrists: Vec<Option<Vector3<f64>>> =
        seen.iter().map(|hand| hand.as_ref().map(|(hand, _)| hand.joints[WRIST].xyz)).collect();
    for (at, hand) in seen.iter_mut().enumerate() {
        let Some(wrist) = wrists[at] else { continue };
        let around = &wrists[at.saturating_sub(WINDOW)..(at + WINDOW + 1).min(wrists.len())];
        let around: Vec<Vector3<f64>> = around.iter().flatten().copied().collect();
        if around.len() < WINDOW {
            continue;
        }
        let middle: [f64; 3] =
            std::array::from_fn(|axis| median(&around.iter().map(|wrist| wrist[axis]).collect::<Vec<_>>()));
        let middle = Vector3::from(middle);
        let spread = median(&around.iter().map(|wrist| (wrist - middle).norm()).collect::<Vec<_>>());
        if (wrist - middle).norm() > (SPREADS * 1.4826 * spread).max(LEAST_JUMP) {
            *hand = None;
        }
    }
}

/// Smooths joints and keypoints without lag. Frames that repeat the one before (a source slower than the standard rate)
/// count as one sample and keep sharing it.
fn smooth_run(run: &mut [Seen]) {
    let mut samples: Vec<PlacedHand> = Vec::with_capacity(run.len());
    let mut sample_of = Vec::with_capacity(run.len());
    for (hand, _) in run.iter().flatten() {
        if samples.last() != Some(hand) {
            samples.push(hand.clone());
        }
        sample_of.push(samples.len() - 1);
    }
    let cutoff = CUTOFF_HZ / (STANDARD_FPS * samples.len() as f64 / run.len().max(1) as f64);
    let weights = vec![1.0; samples.len()];
    let floor =
        KEYPOINT_FLOOR * median(&samples.iter().map(|hand| extent(&hand.keypoints)).collect::<Vec<_>>());
    let mut smoothed = samples.clone();
    for k in 0..KEYPOINT_COUNT {
        let joint: [Vec<f64>; 3] =
            std::array::from_fn(|axis| samples.iter().map(|hand| hand.joints[k].xyz[axis]).collect());
        let joint = smooth_together(&[&joint[0], &joint[1], &joint[2]], &weights, cutoff, JOINT_FLOOR);
        let x: Vec<f64> = samples.iter().map(|hand| hand.keypoints[k].x).collect();
        let y: Vec<f64> = samples.iter().map(|hand| hand.keypoints[k].y).collect();
        let pixel = smooth_together(&[&x, &y], &weights, cutoff, floor);
        for (at, hand) in smoothed.iter_mut().enumerate() {
            hand.joints[k] = Position::new(Vector3::new(joint[0][at], joint[1][at], joint[2][at]));
            hand.keypoints[k] = Pixel::new(pixel[0][at], pixel[1][at]);
        }
    }
    for ((hand, _), sample) in run.iter_mut().flatten().zip(sample_of) {
        *hand = smoothed[sample].clone();
    }
}

/// Joins the hands before and after short gaps.
fn bridge(frames: &mut [HandFrame], camera: &Pinhole) {
    let mut last: Option<usize> = None;
    for at in 0..frames.len() {
        if !frames[at].is_valid() {
            continue;
        }
        if let Some(before) = last
            && (2..=LONGEST_BRIDGE + 1).contains(&(at - before))
        {
            let (from, to) = (frames[before].clone(), frames[at].clone());
            for (step, frame) in (1..).zip(&mut frames[before + 1..at]) {
                let share = f64::from(step) / (at - before) as f64;
                let nearer = f64::from(step).min((at - before) as f64 - f64::from(step));
                if let Some(hand) = between(&from, &to, share, camera) {
                    let trust = from.confidence.min(to.confidence) * BRIDGE_DECAY.powf(nearer);
                    *frame = HandFrame { confidence: trust, ..hand };
                }
            }
        }
        last = Some(at);
    }
}

fn between(from: &HandFrame, to: &HandFrame, share: f64, camera: &Pinhole) -> Option<HandFrame> {
    let joints: [Position<Camera>; KEYPOINT_COUNT] =
        std::array::from_fn(|k| Position::new(from.joints[k].xyz.lerp(&to.joints[k].xyz, share)));
    let mut keypoints = [Pixel::default(); KEYPOINT_COUNT];
    for (keypoint, joint) in keypoints.iter_mut().zip(&joints) {
        *keypoint = camera.project(joint)?;
    }
    let mano = from.mano.as_ref().zip(to.mano.as_ref()).map(|(from, to)| {
        let turn = |a: &nalgebra::UnitQuaternion<f64>, b: &nalgebra::UnitQuaternion<f64>| {
            a.try_slerp(b, share, 1e-9).unwrap_or(*a)
        };
        let fingers = std::array::from_fn(|k| turn(&from.fingers[k], &to.fingers[k]));
        Box::new(ManoHand {
            orientation: turn(&from.orientation, &to.orientation),
            fingers,
            shape: from.shape,
        })
    });
    Some(HandFrame { state: HandState::Bridged, confidence: 0.0, keypoints, joints, mano })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Size;

    fn camera() -> Pinhole {
        Pinhole { fx: 500.0, fy: 500.0, cx: 320.0, cy: 240.0, size: Size::new(640, 480) }
    }

    /// A hand `size` times as large as usual, seen at one place whatever its size.
    fn hand(x: f64, size: f64) -> Seen {
        let joints = std::array::from_fn(|k| {
            let at = Vector3::new(x + 0.02 * (k % 5) as f64, 0.03 * (k / 5) as f64, 0.5);
            Position::new(at * size)
        });
        let keypoints = joints.map(|joint| camera().project(&joint).unwrap());
        Some((PlacedHand { joints, keypoints, mano: None }, 0.9))
    }

    #[test]
    fn a_hand_that_grows_on_single_frames_stays_as_far_away_as_it_is() {
        let seen = (0..40).map(|t| hand(0.01 * t as f64, if t % 3 == 0 { 1.08 } else { 1.0 })).collect();
        let (frames, length) = cleaned(seen, &camera());
        assert!(frames.iter().all(|frame| (frame.wrist().xyz.z - 0.5).abs() < 1e-9));
        assert!(length.is_some_and(|length| length > 0.05));
    }

    #[test]
    fn a_wrist_somewhere_else_is_taken_out_and_bridged() {
        let mut seen: Vec<Seen> = (0..40).map(|t| hand(0.002 * t as f64, 1.0)).collect();
        if let Some((hand, _)) = &mut seen[20] {
            for joint in &mut hand.joints {
                joint.xyz.z += 0.3;
            }
        }
        let (frames, _) = cleaned(seen, &camera());
        assert_eq!(frames[20].state, HandState::Bridged);
        assert!((frames[20].wrist().xyz.z - 0.5).abs() < 0.01 && frames[20].confidence < 0.8);
        assert_eq!(frames.iter().filter(|frame| frame.state == HandState::Observed).count(), 39);
    }

    #[test]
    fn a_quick_hand_is_no_jump() {
        // Two metres a second, sideways.
        let seen: Vec<Seen> = (0..20).map(|t| hand(0.067 * t as f64, 1.0)).collect();
        let (frames, _) = cleaned(seen, &camera());
        assert!(frames.iter().all(|frame| frame.state == HandState::Observed));
    }

    #[test]
    fn short_gaps_are_bridged_and_long_ones_are_not() {
        let mut seen: Vec<Seen> = (0..60).map(|t| hand(0.001 * t as f64, 1.0)).collect();
        seen[10..15].fill(None);
        seen[30..36].fill(None);
        let (frames, _) = cleaned(seen, &camera());
        assert!(frames[10..15].iter().all(|frame| frame.state == HandState::Bridged));
        assert!((frames[12].wrist().xyz.x - 0.012).abs() < 1e-6);
        assert!(frames[30..36].iter().all(|frame| !frame.is_valid()));
    }

    #[test]
    fn frames_that_repeat_keep_sharing_their_hand() {
        let seen: Vec<Seen> = (0..40).map(|t| hand(0.004 * f64::from(t / 2), 1.0)).collect();
        let (frames, _) = cleaned(seen, &camera());
        assert!(frames.chunks(2).all(|pair| pair[0].joints == pair[1].joints));
    }
}
