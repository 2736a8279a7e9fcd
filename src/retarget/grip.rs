//! Pinches and contact, read off the human hand.

use super::{
    human::{HumanPose, HumanSize},
    params::Pinch,
};

/// Strength 0 to 1 of a pinch between thumb and each other finger (index to pinky) for every frame of a run.
///
/// A pinch starts where the fingertips come nearer than `close` and ends where they part beyond `release`
/// (hysteresis as in DexPilot, Handa et al. 2020), then fades over a few frames to both sides.
pub(super) fn pinch_strengths(run: &[HumanPose], size: &HumanSize, params: &Pinch) -> Vec<[f64; 4]> {
    let mut strengths = vec![[0.0; 4]; run.len()];
    for finger in 0..4 {
        let mut closed = false;
        let states: Vec<f64> = run
            .iter()
            .map(|pose| {
                let gap = size.normalised(pose.gaps[finger].norm());
                closed = gap < if closed { params.release } else { params.close };
                f64::from(u8::from(closed))
            })
            .collect();
        for (t, strength) in strengths.iter_mut().enumerate() {
            strength[finger] = faded(&states, t, params.ramp_frames);
        }
    }
    strengths
}

/// The largest state near `t`, less for every frame of distance.
fn faded(states: &[f64], t: usize, ramp: usize) -> f64 {
    let around = t.saturating_sub(ramp)..(t + ramp + 1).min(states.len());
    around
        .map(|other| states[other] * (1.0 - other.abs_diff(t) as f64 / (ramp as f64 + 1.0)))
        .fold(0.0, f64::max)
}

/// Contact 0 to 1 of a hand with itself or an object in it: the larger of how near the thumb is to another
/// fingertip (1 below 3 cm, 0 beyond 9 cm, on a hand of 0.18 m) and of how far index, middle and ring are
/// curled (0 at a fifth, 1 at half of their length drawn in).
pub(super) fn contact(pose: &HumanPose, size: &HumanSize) -> f64 {
    let gap = pose.gaps[..2].iter().map(|gap| size.normalised(gap.norm())).fold(f64::INFINITY, f64::min);
    let curl =
        (1..4).map(|finger| 1.0 - pose.fingers[finger].norm() / size.fingers[finger]).sum::<f64>() / 3.0;
    ramp(0.09, 0.03, gap).max(ramp(0.2, 0.5, curl))
}

fn ramp(from: f64, to: f64, value: f64) -> f64 {
    let share = ((value - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;

    fn run(gaps: &[f64]) -> Vec<HumanPose> {
        let pose = |gap: f64| HumanPose {
            wrist: Vector3::z(),
            palm: UnitQuaternion::identity(),
            fingers: [Vector3::x() * 0.08; 5],
            tips: [Vector3::x() * 0.16; 5],
            gaps: [Vector3::y() * gap; 4],
            weight: 1.0,
        };
        gaps.iter().map(|&gap| pose(gap)).collect()
    }

    const SIZE: HumanSize = HumanSize { fingers: [0.08; 5], hand: 0.18 };

    #[test]
    fn a_pinch_holds_until_the_fingers_part_beyond_release() {
        let params = Pinch { ramp_frames: 0, ..Pinch::default() };
        let strengths = pinch_strengths(&run(&[0.035, 0.02, 0.035, 0.06, 0.035]), &SIZE, &params);
        let index: Vec<f64> = strengths.iter().map(|strength| strength[0]).collect();
        assert_eq!(index, [0.0, 1.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn contact_grows_as_thumb_and_finger_close() {
        let contacts: Vec<f64> =
            run(&[0.12, 0.07, 0.05, 0.02]).iter().map(|pose| contact(pose, &SIZE)).collect();
        assert!(contacts.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!((contacts[0], contacts[3]), (0.0, 1.0));
    }
}
