//! Every retargeting method on the same hands: what each keeps, and what tells them apart.
#![cfg(feature = "engine")]
#![allow(clippy::unwrap_used, reason = "a broken expectation is a failed test")]

#[path = "support/hands.rs"]
mod hands;

use agenticfocus::{
    geometry::{PerSide, Side},
    hands::{HandFrame, HandTrack},
    landmarks::keypoint::TIPS,
    progress::Unwatched,
    retarget::{Method, RetargetParams, RobotMotion, retarget},
    robot::{JointAngles, RobotModel},
};
use hands::{Joints, assert_sound, shared, synthetic, track_of};
use nalgebra::Vector3;

const BASELINES: [Method; 2] = [Method::Masquerade, Method::DoAsIDo];

fn run(track: &HandTrack, params: &RetargetParams) -> (RobotModel, RobotMotion) {
    let robot = RobotModel::embedded().unwrap();
    let motion = retarget(track, &robot, params, &Unwatched).unwrap();
    assert_eq!(motion.method, params.method);
    assert_eq!(motion.angles.len(), track.frame_count());
    assert_eq!(motion.raw_angles.len(), track.frame_count());
    assert_sound(&robot, &motion);
    (robot, motion)
}

fn by(method: Method) -> RetargetParams {
    RetargetParams { method, ..RetargetParams::default() }
}

fn mean_error(motion: &RobotMotion, side: Side) -> f64 {
    let driven: Vec<f64> = motion.sides[side].iter().filter(|r| r.driven).map(|r| r.error_position).collect();
    driven.iter().sum::<f64>() / driven.len() as f64
}

#[test]
fn every_method_follows_the_hands_and_says_how_far_off_it_is() {
    let track = synthetic(120);
    for method in Method::ALL {
        let (_, motion) = run(&track, &by(method));
        for side in Side::BOTH {
            let error = mean_error(&motion, side);
            let turn = motion.sides[side].iter().map(|r| r.error_rotation.to_degrees()).sum::<f64>() / 120.0;
            let reach = motion.sides[side].iter().filter(|r| r.reachable).count();
            println!("{method}: {} {:.1} mm {turn:.1} deg, {reach} reachable", side.name(), error * 1e3);
            assert!(motion.sides[side].iter().all(|report| report.driven));
            assert!(error < 0.08, "{method}: {error}");
            assert!(reach > 100, "{method}: {reach}");
        }
    }
}

#[test]
fn all_methods_are_judged_by_the_same_wrists() {
    let track = synthetic(60);
    let ours = run(&track, &by(Method::Ours)).1;
    for method in BASELINES {
        let (_, motion) = run(&track, &RetargetParams { shared_map: true, ..by(method) });
        assert_eq!(motion.map, ours.map);
        for side in Side::BOTH {
            for (a, b) in ours.sides[side].iter().zip(&motion.sides[side]) {
                assert_eq!((a.target, a.contact), (b.target, b.contact));
            }
        }
    }
    assert_eq!(run(&track, &by(Method::Masquerade)).1.map.beta, 1.0);
}

#[test]
fn a_hand_that_is_missing_is_held_by_masquerade_and_rests_for_do_as_i_do() {
    let mut track = synthetic(150);
    for frame in 40..110 {
        track.hands.right[frame] = HandFrame::invalid();
    }
    let wrist = |motion: &RobotMotion, frame: usize| motion.sides.right[frame].reached.position();
    let (_, held) = run(&track, &by(Method::Masquerade));
    assert!(wrist(&held, 60).distance(&wrist(&held, 90)) < 0.05);
    let (_, rested) = run(&track, &by(Method::DoAsIDo));
    assert!(wrist(&rested, 75).distance(&wrist(&rested, 39)) > 0.1);
    for motion in [held, rested] {
        assert!(motion.sides.right[40..110].iter().all(|report| !report.driven && !report.reachable));
        assert!(motion.sides.right[39].driven && motion.sides.right[110].driven);
    }
}

#[test]
fn a_spike_does_not_move_do_as_i_do() {
    let track = synthetic(90);
    let mut spiked = track.clone();
    for joint in &mut spiked.hands.left[45].joints {
        joint.xyz += Vector3::new(0.3, -0.2, 0.4);
    }
    let beta = agenticfocus::retarget::Beta::Fixed(0.8);
    let params = RetargetParams { beta, ..by(Method::DoAsIDo) };
    let (clean, healed) = (run(&track, &params).1, run(&spiked, &params).1);
    for (a, b) in clean.sides.left.iter().zip(&healed.sides.left) {
        assert!(a.reached.position().distance(&b.reached.position()) < 0.01);
    }
}

#[test]
fn masquerades_hand_closes_as_one_where_the_human_closes() {
    let (robot, motion) = run(&synthetic(126), &by(Method::Masquerade));
    for side in Side::BOTH {
        let start = JointAngles::hand_start(side);
        let shares = |frame: usize| -> Vec<f64> {
            (0..6).map(|j| motion.raw_angles[frame].0[start + j] / robot.limits().upper[start + j]).collect()
        };
        for frame in [0, 30, 63] {
            assert!(shares(frame).iter().all(|share| (share - shares(frame)[0]).abs() < 1e-9));
        }
        assert!(shares(63)[0] > shares(0)[0] + 0.3, "{:?} {:?}", shares(0), shares(63));
    }
}

#[test]
fn nothing_valid_and_nothing_at_all_harm_no_method() {
    let mut track = synthetic(20);
    track.hands.left = vec![HandFrame::invalid(); 20];
    track.hands.right[7].joints[3].xyz = Vector3::repeat(f64::NAN);
    for method in BASELINES {
        let (_, motion) = run(&track, &by(method));
        assert!(motion.sides.left.iter().all(|report| !report.driven));
        let none = HandTrack { hands: PerSide::from_fn(|_| vec![HandFrame::invalid(); 5]), ..track.clone() };
        assert_eq!(run(&none, &by(method)).1.angles.len(), 5);
        let empty = HandTrack { hands: PerSide::default(), ..track.clone() };
        assert!(run(&empty, &by(method)).1.angles.is_empty());
    }
}

#[test]
fn parameters_and_motions_from_before_there_were_methods_are_ours() {
    let params: RetargetParams = serde_json::from_str("{\"alpha\": 0.4}").unwrap();
    assert_eq!((params.method, params.shared_map), (Method::Ours, false));
    let (_, motion) = run(&synthetic(3), &by(Method::Ours));
    let mut text = serde_json::to_value(&motion).unwrap();
    text.as_object_mut().unwrap().remove("method");
    assert_eq!(serde_json::from_value::<RobotMotion>(text).unwrap(), motion);
}

#[test]
fn every_method_copes_with_a_real_track() {
    let Some(text) = shared("clips/whisking/whisking_hands.json") else { return };
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let side = |key: &str| serde_json::from_value::<Vec<Joints>>(file[key].clone()).unwrap();
    let (left, right) = (side("left_joints_cam"), side("right_joints_cam"));
    let track = track_of(Some(&left), Some(&right), |p| p);
    for method in Method::ALL {
        for shared_map in [false, true] {
            let began = std::time::Instant::now();
            let (_, motion) = run(&track, &RetargetParams { shared_map, ..by(method) });
            let took = began.elapsed().as_secs_f64() * 1e3 / track.frame_count() as f64;
            let errors = Side::BOTH.map(|side| 1e3 * mean_error(&motion, side));
            println!("{method} shared {shared_map}: {errors:.1?} mm, {took:.2} ms a frame");
        }
    }
}

/// The table this is measured against: tip vectors in the hand's own frame, gap of thumb and index where the human
/// pinches, spread of the second difference of the hand's angles.
#[test]
fn the_fingers_of_a_real_hand_are_met_and_do_not_shake() {
    let Some(text) = shared("clips/hand_video/human_joint_right.json") else { return };
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let joints: Vec<Joints> = serde_json::from_value(file["joints_wrist_frame"].clone()).unwrap();
    let figures = hand_figures(&joints);
    println!("{figures:.4?}");
    assert_eq!(figures.pinches, 27);
    assert!(figures.tip_error_cm[2] <= 1.6, "{figures:?}");
    assert!(figures.gap_cm <= 0.5, "{figures:?}");
    assert!(figures.jerk <= 0.018, "{figures:?}");
}

#[derive(Debug)]
struct HandFigures {
    /// Mean distance of the fingertips, from the wrist, to the human's scaled by 1, 0.95 and 0.9.
    tip_error_cm: [f64; 3],
    gap_cm: f64,
    human_gap_cm: f64,
    pinches: usize,
    jerk: f64,
}

fn hand_figures(joints: &[Joints]) -> HandFigures {
    let turn = nalgebra::Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
        0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0,
    ));
    let track = track_of(None, Some(joints), |p| turn * p + Vector3::new(0.1, 0.12, 0.42));
    let (robot, motion) = run(&track, &RetargetParams::default());
    let to_torso = nalgebra::Rotation3::from_matrix_unchecked(motion.map.rotation) * turn;
    let mut figures =
        HandFigures { tip_error_cm: [0.0; 3], gap_cm: 0.0, human_gap_cm: 0.0, pinches: 0, jerk: 0.0 };
    for (joints, angles) in joints.iter().zip(&motion.angles) {
        let posture = robot.posture(Side::Right, angles);
        let robots = |finger: usize| posture.tips[finger] - posture.wrist;
        let human = |index: usize| to_torso * (Vector3::from(joints[index]) - Vector3::from(joints[0]));
        for (at, scale) in [1.0, 0.95, 0.9].into_iter().enumerate() {
            let misses = (0..5).map(|f| (robots(f) - scale * human(TIPS[f])).norm());
            figures.tip_error_cm[at] += 20.0 * misses.sum::<f64>() / motion.angles.len() as f64;
        }
        let gap = (human(TIPS[1]) - human(TIPS[0])).norm();
        if gap < 0.03 {
            figures.pinches += 1;
            figures.human_gap_cm += 100.0 * gap;
            figures.gap_cm += 100.0 * (posture.tips[1] - posture.tips[0]).norm();
        }
    }
    figures.gap_cm /= figures.pinches as f64;
    figures.human_gap_cm /= figures.pinches as f64;
    let start = JointAngles::hand_start(Side::Right);
    let second: Vec<f64> = motion
        .angles
        .windows(3)
        .flat_map(|w| (start..start + 6).map(|j| w[2].0[j] - 2.0 * w[1].0[j] + w[0].0[j]))
        .collect();
    let mean = second.iter().sum::<f64>() / second.len() as f64;
    figures.jerk = (second.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / second.len() as f64).sqrt();
    figures
}
