//! The method's timeline: 15 Hz, without the frames where no hand is seen.

use nalgebra::Isometry3;

use super::{grasp::Grasp, orientation::slerp};

/// Every so many frames of the 30 FPS clip one is taken.
const STRIDE: usize = 2;

/// A gripper's state on the timeline, torso axes, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct GripperState {
    pub pose: Isometry3<f64>,
    pub width: f64,
}

impl From<Grasp> for GripperState {
    fn from(grasp: Grasp) -> Self {
        Self { pose: grasp.pose, width: grasp.width }
    }
}

/// The frames the method works on: every second one of `count`, dropped where neither hand is `seen`.
pub(super) fn kept_frames(count: usize, seen: impl Fn(usize) -> bool) -> Vec<usize> {
    (0..count).step_by(STRIDE).filter(|&frame| seen(frame)).collect()
}

/// One side on the timeline: a hand that is missing keeps its last state, before it is first seen it has that
/// one already; one that is never seen has `neutral`.
pub(super) fn filled(states: &[Option<GripperState>], neutral: GripperState) -> Vec<GripperState> {
    let mut last = states.iter().copied().flatten().next().unwrap_or(neutral);
    states
        .iter()
        .map(|state| {
            last = state.unwrap_or(last);
            last
        })
        .collect()
}

/// The state on each of `count` frames at 30 FPS: straight between the kept ones, held beyond them.
pub(super) fn resampled(kept: &[usize], states: &[GripperState], count: usize) -> Vec<GripperState> {
    let Some(first) = states.first() else { return Vec::new() };
    let mut next = 0;
    (0..count)
        .map(|frame| {
            while next < kept.len() && kept[next] < frame {
                next += 1;
            }
            match (next.checked_sub(1), states.get(next)) {
                (None, _) => *first,
                (Some(before), None) => states[before],
                (Some(before), Some(after)) => {
                    let span = (kept[next] - kept[before]) as f64;
                    between(&states[before], after, (frame - kept[before]) as f64 / span)
                }
            }
        })
        .collect()
}

fn between(from: &GripperState, to: &GripperState, share: f64) -> GripperState {
    let (a, b) = (&from.pose, &to.pose);
    let point = a.translation.vector.lerp(&b.translation.vector, share);
    GripperState {
        pose: Isometry3::from_parts(point.into(), slerp(&a.rotation, &b.rotation, share)),
        width: from.width + share * (to.width - from.width),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(x: f64) -> GripperState {
        GripperState { pose: Isometry3::translation(x, 0.0, 0.0), width: x }
    }

    #[test]
    fn frames_without_hands_are_dropped_and_bridged_afterwards() {
        let kept = kept_frames(12, |frame| !(4..8).contains(&frame));
        assert_eq!(kept, [0, 2, 8, 10]);
        let states: Vec<GripperState> = kept.iter().map(|&frame| state(frame as f64)).collect();
        let all = resampled(&kept, &states, 12);
        for (frame, state) in all.iter().enumerate() {
            // Straight across the gap, and held after the last.
            assert!((state.width - (frame as f64).min(10.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_missing_hand_keeps_its_last_state() {
        let seen = [None, Some(state(1.0)), None, Some(state(3.0))];
        let widths = |states: &[GripperState]| states.iter().map(|s| s.width).collect::<Vec<_>>();
        assert_eq!(widths(&filled(&seen, state(9.0))), [1.0, 1.0, 1.0, 3.0]);
        assert_eq!(widths(&filled(&[None, None], state(9.0))), [9.0, 9.0]);
    }
}
