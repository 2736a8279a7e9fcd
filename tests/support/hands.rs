//! Hands made up or read from files, before a head camera.
#![allow(dead_code, clippy::unwrap_used, reason = "each test uses its part; a failing unwrap fails the test")]

use agenticfocus::{
    geometry::{Camera, PerSide, Pinhole, Position, Side, Size},
    hands::{HandFrame, HandState, HandTrack},
    retarget::RobotMotion,
    robot::RobotModel,
};
use nalgebra::{Rotation3, Vector3};

pub type Joints = [[f64; 3]; 21];

/// A flat open right hand in its palm frame (x towards the fingers, z towards the thumb), metres; `closing`
/// from 0 to 1 curls it into a pinch-like fist.
pub fn hand_shape(side: Side, closing: f64) -> [Vector3<f64>; 21] {
    // Out of the palm is −y in the left hand's frame and +y in the right's.
    let palm = if side == Side::Left { -1.0 } else { 1.0 };
    let mut joints = [Vector3::zeros(); 21];
    let thumb = Vector3::new(0.55, palm * (0.1 + 0.75 * closing), 0.8 - 0.6 * closing).normalize();
    for (bone, length) in [0.04, 0.04, 0.032, 0.026].into_iter().enumerate() {
        joints[bone + 1] = joints[bone] + thumb * length;
    }
    for (finger, across) in [0.028, 0.008, -0.012, -0.030].into_iter().enumerate() {
        let base = 5 + 4 * finger;
        joints[base] = Vector3::new(0.085, 0.0, across);
        for (bone, length) in [0.042, 0.026, 0.022].into_iter().enumerate() {
            let bend = closing * 0.9 * (bone as f64 + 1.0);
            let direction = Vector3::new(bend.cos(), palm * bend.sin(), 0.0);
            joints[base + bone + 1] = joints[base + bone] + direction * length;
        }
    }
    joints
}

pub fn camera() -> Pinhole {
    Pinhole::from_horizontal_fov(65.0, Size::new(640, 480)).unwrap()
}

pub fn hand_frame(joints: &[Vector3<f64>; 21], camera: &Pinhole) -> HandFrame {
    let joints = joints.map(Position::<Camera>::new);
    let keypoints = joints.map(|joint| camera.project(&joint).unwrap_or_default());
    HandFrame { state: HandState::Observed, confidence: 0.95, keypoints, joints, mano: None }
}

/// Both hands reach, close and part in front of a head camera.
pub fn synthetic(frames: usize) -> HandTrack {
    let hand = |side: Side, frame: usize| {
        let t = frame as f64 / 30.0;
        let out = if side == Side::Left { -1.0 } else { 1.0 };
        let wrist = Vector3::new(
            out * (0.12 - 0.04 * (0.9 * t).sin()),
            0.08 + 0.03 * (1.3 * t).cos(),
            0.42 + 0.05 * (0.7 * t).sin(),
        );
        // Fingers up the picture (away from the body), the palm facing in and down.
        let fingers = Vector3::new(-0.25 * out, -0.75, 0.6).normalize();
        let thumb_hint = Vector3::new(-out, -0.2, -0.5);
        let thumb = (thumb_hint - fingers * fingers.dot(&thumb_hint)).normalize();
        let axes = nalgebra::Matrix3::from_columns(&[fingers, thumb.cross(&fingers), thumb]);
        let wobble = Rotation3::from_euler_angles(0.1 * (1.1 * t).sin(), 0.1 * t.cos(), 0.0);
        let closing = 0.5 - 0.5 * (1.5 * t).cos();
        hand_frame(&hand_shape(side, closing).map(|p| wrist + wobble * (axes * p)), &camera())
    };
    let side = |side: Side| (0..frames).map(|frame| hand(side, frame)).collect();
    HandTrack { hands: PerSide::from_fn(side), hand_length: PerSide::default(), backend: "test".to_owned() }
}

pub fn assert_sound(robot: &RobotModel, motion: &RobotMotion) {
    let limits = robot.limits();
    for (frame, angles) in motion.angles.iter().enumerate() {
        assert!(angles.0.iter().all(|angle| angle.is_finite()), "frame {frame}");
        assert_eq!(limits.position_violations(angles, 1e-9), 0, "frame {frame}");
    }
    for (frame, pair) in motion.angles.windows(2).enumerate() {
        assert_eq!(limits.velocity_violations(&pair[0], &pair[1], 1e-9), 0, "frame {frame}");
    }
}

pub fn shared(path: &str) -> Option<String> {
    let root = std::env::var_os("AGENTICFOCUS_SHARED")
        .map_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/../shared").into(), std::path::PathBuf::from);
    let text = std::fs::read_to_string(root.join(path)).ok();
    if text.is_none() {
        println!("skipped: no {}", root.join(path).display());
    }
    text
}

pub fn track_of(
    left: Option<&[Joints]>,
    right: Option<&[Joints]>,
    place: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> HandTrack {
    let frames = left.or(right).map_or(0, <[Joints]>::len);
    let side = |joints: Option<&[Joints]>| match joints {
        Some(joints) => {
            joints.iter().map(|j| hand_frame(&j.map(|p| place(Vector3::from(p))), &camera())).collect()
        }
        None => vec![HandFrame::invalid(); frames],
    };
    HandTrack {
        hands: PerSide { left: side(left), right: side(right) },
        hand_length: PerSide::default(),
        backend: "imported".to_owned(),
    }
}
