//! Retargeting of synthetic hands, and of real tracks where `../shared/clips` is present.
#![cfg(feature = "engine")]
#![allow(clippy::unwrap_used, reason = "a broken expectation is a failed test")]

#[path = "support/hands.rs"]
mod hands;

use agenticfocus::{
    geometry::{PerSide, Pinhole, Position, Side},
    hands::{HandFrame, HandTrack},
    landmarks::keypoint::{TIPS, WRIST},
    progress::Unwatched,
    retarget::{Beta, RetargetParams, RobotMotion, Smoothing, WristTurn, retarget},
    robot::RobotModel,
};
use hands::{Joints, assert_sound, camera, hand_frame, shared, synthetic, track_of};
use nalgebra::{Rotation3, Vector3};

fn run(track: &HandTrack, params: &RetargetParams) -> (RobotModel, RobotMotion) {
    let robot = RobotModel::embedded().unwrap();
    let motion = retarget(track, &robot, params, &Unwatched).unwrap();
    assert_sound(&robot, &motion);
    (robot, motion)
}

/// RMS distance in pixels of the robot's wrist, seen by the virtual camera, from the human's, on reachable frames.
fn wrist_reprojection(track: &HandTrack, motion: &RobotMotion, camera: &Pinhole) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for side in Side::BOTH {
        for (human, report) in track.hands[side].iter().zip(&motion.sides[side]) {
            if !report.reachable {
                continue;
            }
            let map = &motion.map;
            let seen = map.rotation.transpose() * (report.reached.position().xyz - map.offset);
            let robot = camera.project(&Position::new(seen)).unwrap();
            sum += robot.distance(camera.project(&human.wrist()).unwrap()).powi(2);
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

fn share(
    motion: &RobotMotion,
    side: Side,
    what: impl Fn(&agenticfocus::retarget::SideReport) -> bool,
) -> f64 {
    let driven: Vec<_> = motion.sides[side].iter().filter(|report| report.driven).collect();
    driven.iter().filter(|report| what(report)).count() as f64 / driven.len().max(1) as f64
}

#[test]
fn the_robots_wrists_stay_on_the_pixels_of_the_humans() {
    let track = synthetic(120);
    let (_, motion) = run(&track, &RetargetParams::default());
    for side in Side::BOTH {
        assert!(share(&motion, side, |report| report.reachable) > 0.95);
        assert!(share(&motion, side, |report| report.error_rotation < 0.1) > 0.9);
    }
    let error = wrist_reprojection(&track, &motion, &camera());
    assert!(error < 1.0, "{error} px");
}

#[test]
fn beta_changes_depth_and_not_pixels() {
    let track = synthetic(60);
    for beta in [0.7, 0.8, 0.9] {
        let params = RetargetParams { beta: Beta::Fixed(beta), ..Default::default() };
        let (_, motion) = run(&track, &params);
        assert_eq!(motion.map.beta, beta);
        assert!(wrist_reprojection(&track, &motion, &camera()) < 1.0);
    }
}

#[test]
fn a_camera_opposite_the_person_gets_a_view_that_suits_it_unless_one_is_given() {
    let mut track = synthetic(60);
    // The same hands seen from the other side of the table, 1.2 m away: half a turn about the vertical.
    for side in Side::BOTH {
        for frame in &mut track.hands[side] {
            let turned = frame.joints.map(|p| Vector3::new(-p.xyz.x, p.xyz.y, 1.2 - p.xyz.z));
            *frame = hand_frame(&turned, &camera());
        }
    }
    let (_, motion) = run(&track, &RetargetParams::default());
    for side in Side::BOTH {
        assert!(share(&motion, side, |report| report.reachable) > 0.9);
    }
    assert!(wrist_reprojection(&track, &motion, &camera()) < 1.0);
    let given = RetargetParams { offset: Vector3::new(0.06, 0.0, 0.43), ..Default::default() };
    assert_eq!(run(&track, &given).1.map.offset, given.offset);
}

#[test]
fn closing_the_human_hand_closes_the_robots() {
    let (robot, motion) = run(&synthetic(126), &RetargetParams::default());
    for side in Side::BOTH {
        let start = agenticfocus::robot::JointAngles::hand_start(side);
        let closed = |frame: usize| {
            (2..6).map(|j| motion.angles[frame].0[start + j] / robot.limits().upper[start + j]).sum::<f64>()
                / 4.0
        };
        // The hands are open at 0 and 126 and closed at 63.
        assert!(closed(0) < 0.05, "{}", closed(0));
        assert!(closed(63) > 0.4, "{}", closed(63));
        let contact = |frame: usize| motion.sides[side][frame].contact;
        assert!(contact(63) > contact(0) + 0.3, "{} {}", contact(0), contact(63));
    }
}

#[test]
fn a_hand_that_goes_and_comes_leaves_its_arm_at_rest_without_a_jump() {
    let mut track = synthetic(150);
    for frame in 40..110 {
        track.hands.right[frame] = HandFrame::invalid();
    }
    let (robot, motion) = run(&track, &RetargetParams::default());
    assert!(motion.sides.right[40..110].iter().all(|report| !report.driven));
    assert!(motion.sides.right[39].driven && motion.sides.right[110].driven);
    for pair in motion.angles.windows(2) {
        let arm = |side: Side| pair[0].side(side).into_iter().zip(pair[1].side(side)).take(7);
        assert!(Side::BOTH.into_iter().flat_map(arm).all(|(a, b)| (a - b).abs() < 0.35));
    }
    let hand = robot.wrist(Side::Right, &motion.angles[75]).position().xyz;
    let seen = motion.map.rotation.transpose() * (hand - motion.map.offset);
    let pixel = camera().project(&Position::new(seen));
    assert!(pixel.is_none_or(|pixel| pixel.y > 480.0), "{pixel:?}");
}

#[test]
fn a_far_wrist_is_reported_and_keeps_its_pixel_as_well_as_it_can() {
    let mut track = synthetic(40);
    for side in Side::BOTH {
        for frame in &mut track.hands[side] {
            frame.joints = frame.joints.map(|joint| Position::new(joint.xyz + frame.joints[WRIST].xyz));
        }
    }
    // A view that a person chose is kept; the default one would be moved to where the hands are.
    let offset = Vector3::new(0.06, 0.0, 0.43);
    let params = RetargetParams { beta: Beta::Fixed(1.0), offset, ..Default::default() };
    let (_, motion) = run(&track, &params);
    for side in Side::BOTH {
        for (human, report) in track.hands[side].iter().zip(&motion.sides[side]) {
            assert!(report.driven && !report.reachable);
            let seen = motion.map.rotation.transpose() * (report.reached.position().xyz - motion.map.offset);
            let robot = camera().project(&Position::new(seen)).unwrap();
            let apart = robot.distance(camera().project(&human.wrist()).unwrap());
            assert!(apart < 3.0, "{apart} px");
        }
    }
}

#[test]
fn nothing_valid_gives_resting_arms_and_not_a_number_harms_nobody() {
    let mut track = synthetic(20);
    track.hands.left = vec![HandFrame::invalid(); 20];
    track.hands.right[7].joints[3] = Position::new(Vector3::repeat(f64::NAN));
    let (_, motion) = run(&track, &RetargetParams::default());
    assert!(motion.sides.left.iter().all(|report| !report.driven));
    assert!(!motion.sides.right[7].driven && motion.sides.right[8].driven);
    assert!(motion.angles.windows(2).all(|pair| pair[0].side(Side::Left) == pair[1].side(Side::Left)));
    let empty = HandTrack { hands: PerSide::default(), ..track };
    assert!(run(&empty, &RetargetParams::default()).1.angles.is_empty());
}

#[test]
fn the_published_average_lags_and_the_zero_phase_form_does_not() {
    let track = synthetic(90);
    let mean_error = |smoothing: Smoothing| {
        let (_, motion) = run(&track, &RetargetParams { smoothing, alpha: 0.3, ..Default::default() });
        let errors = motion.sides.left.iter().map(|report| report.error_position);
        errors.sum::<f64>() / motion.sides.left.len() as f64
    };
    let (published, zero_phase) = (mean_error(Smoothing::Ema), mean_error(Smoothing::ZeroPhase));
    assert!(published > 2e-3 && zero_phase < 1e-4, "{published} {zero_phase}");
}

#[test]
fn a_corrected_wrist_turns_the_whole_hand_about_its_place_and_leaves_the_other_alone() {
    let track = synthetic(60);
    let beta = Beta::Fixed(0.8);
    let (_, straight) = run(&track, &RetargetParams { beta, ..Default::default() });
    let right = WristTurn { pitch_deg: 12.0, ..WristTurn::default() };
    let wrist = PerSide { left: WristTurn::default(), right };
    let (_, turned) = run(&track, &RetargetParams { beta, wrist, ..Default::default() });
    assert_eq!(straight.sides.left, turned.sides.left);
    for (before, after) in straight.sides.right.iter().zip(&turned.sides.right) {
        assert_eq!(before.target.position(), after.target.position());
        let own = before.target.rotation().inverse() * after.target.rotation();
        assert!(own.angle_to(&right.rotation()) < 1e-9);
        // The fingertips go with the hand, not back to where they were in space.
        let tip = |report: &agenticfocus::retarget::SideReport| {
            report.reached.rotation().inverse() * (report.fingertips[2].xyz - report.reached.position().xyz)
        };
        assert!((tip(before) - tip(after)).norm() < 0.012, "{} {}", tip(before), tip(after));
    }
    let mean = |motion: &RobotMotion| {
        let turns = motion.sides.right.iter().map(|report| report.error_rotation);
        turns.sum::<f64>() / motion.sides.right.len() as f64
    };
    assert!(mean(&turned) < mean(&straight) + 0.05, "{} {}", mean(&turned), mean(&straight));
}

fn summary(name: &str, track: &HandTrack, motion: &RobotMotion) {
    println!("{name}: beta {:.3}", motion.map.beta);
    for side in Side::BOTH {
        let reports: Vec<_> = motion.sides[side].iter().filter(|report| report.driven).collect();
        if reports.is_empty() {
            continue;
        }
        let n = reports.len() as f64;
        let mean = |value: &dyn Fn(&agenticfocus::retarget::SideReport) -> f64| {
            reports.iter().map(|report| value(report)).sum::<f64>() / n
        };
        println!(
            "  {}: reach {:.2} position {:.2} mm rotation {:.1} deg margin {:.2} contact {:.2}",
            side.name(),
            mean(&|r| f64::from(u8::from(r.reachable))),
            mean(&|r| r.error_position * 1e3),
            mean(&|r| r.error_rotation.to_degrees()),
            mean(&|r| r.limit_margin),
            mean(&|r| r.contact),
        );
    }
    println!("  wrist reprojection {:.2} px", wrist_reprojection(track, motion, &camera()));
}

#[test]
fn a_real_pinching_hand_closes_the_robots_pinch() {
    let Some(text) = shared("clips/hand_video/human_joint_right.json") else { return };
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let joints: Vec<Joints> = serde_json::from_value(file["joints_wrist_frame"].clone()).unwrap();
    // Wrist-local joints (x out of the palm, z to the fingers): held up before the camera, fingers upwards.
    let turn = Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
        0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0,
    ));
    let track = track_of(None, Some(&joints), |p| turn * p + Vector3::new(0.1, 0.12, 0.42));
    let began = std::time::Instant::now();
    let (robot, motion) = run(&track, &RetargetParams::default());
    println!("{:.3} ms a frame", began.elapsed().as_secs_f64() * 1e3 / joints.len() as f64);
    summary("hand_video", &track, &motion);
    let (mut human_gap, mut robot_gap, mut raw_gap, mut count) = (0.0, 0.0, 0.0, 0.0);
    for (frame, (joints, report)) in joints.iter().zip(&motion.sides.right).enumerate() {
        let at = |i: usize| Vector3::from(joints[i]);
        let gap = (at(TIPS[1]) - at(TIPS[0])).norm();
        if gap < 0.03 {
            human_gap += gap;
            robot_gap += report.fingertips[0].distance(&report.fingertips[1]);
            let raw = robot.fingertips(Side::Right, &motion.raw_angles[frame]);
            raw_gap += raw[0].distance(&raw[1]);
            count += 1.0;
        }
    }
    let cm = |sum: f64| sum / count * 1e2;
    println!(
        "{count} pinch frames: human {:.2} cm, robot as solved {:.2} cm, smoothed {:.2} cm",
        cm(human_gap),
        cm(raw_gap),
        cm(robot_gap)
    );
    assert!(robot_gap / count < 0.02);
}

#[test]
fn real_hands_of_a_video_are_followed() {
    let Some(text) = shared("clips/whisking/whisking_hands.json") else { return };
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let side = |key: &str| serde_json::from_value::<Vec<Joints>>(file[key].clone()).unwrap();
    let (left, right) = (side("left_joints_cam"), side("right_joints_cam"));
    let track = track_of(Some(&left), Some(&right), |p| p);
    let (_, motion) = run(&track, &RetargetParams::default());
    summary("whisking", &track, &motion);
    // A camera opposite the person, 1.2 m away: the default view cannot serve, another is found.
    for side in Side::BOTH {
        assert!(share(&motion, side, |report| report.reachable) > 0.9);
    }
}

#[test]
fn a_captured_hand_is_followed() {
    let Some(text) = shared("clips/dexycb/dexycb_motion.json") else { return };
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let joints: Vec<Joints> = serde_json::from_value(file["joints_world"].clone()).unwrap();
    let middle = joints.iter().map(|j| Vector3::from(j[0])).sum::<Vector3<f64>>() / joints.len() as f64;
    // World axes x forward, y left, z up: a head camera pitched down by 45 degrees sees the path at half a metre.
    let (s, c) = 45_f64.to_radians().sin_cos();
    let to_camera =
        Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(0.0, -1.0, 0.0, -s, 0.0, -c, c, 0.0, -s));
    let track = track_of(None, Some(&joints), |p| to_camera * (p - middle) + Vector3::new(0.05, 0.03, 0.5));
    let (_, motion) = run(&track, &RetargetParams::default());
    summary("dexycb", &track, &motion);
}
