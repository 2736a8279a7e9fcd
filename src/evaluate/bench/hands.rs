//! Metric hands and the robot's wrists against the truth.

use nalgebra::{Matrix3, Vector3};
use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

use super::{BenchError, same_length};
use crate::{
    clip::FrameIndex,
    geometry::{Camera, PerSide, Pinhole, Position, Side},
    hands::HandTrack,
    landmarks::LandmarkTrack,
    retarget::RobotMotion,
    synth::Episode,
};

/// The true landmarks with normal noise of `sigma` pixels on each coordinate, reproducible from `seed`.
pub fn noisy_landmarks(episode: &Episode, sigma: f64, seed: u64) -> LandmarkTrack {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    // Box and Muller's transform.
    let mut normal = || {
        let (u, v) = (rng.random_range(f64::EPSILON..1.0), rng.random_range(0.0..std::f64::consts::TAU));
        sigma * (-2.0 * f64::ln(u)).sqrt() * f64::cos(v)
    };
    let mut landmarks = episode.landmarks();
    for frame in &mut landmarks {
        for side in Side::BOTH {
            for keypoint in frame[side].iter_mut().flat_map(|hand| &mut hand.keypoints) {
                keypoint.x += normal();
                keypoint.y += normal();
            }
        }
    }
    landmarks
}

/// How far fitted hands are from the true ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandErrors {
    /// Mean of |depth − true depth| / true depth of the wrist, per cent.
    pub depth_pct: f64,
    /// Mean distance of the other 20 joints, both hands moved so that their wrists coincide, millimetres.
    pub joint_mm: f64,
    /// Share of the hands in view that were fitted.
    pub coverage: f64,
}

/// Errors over all hands that are in view and valid in `track`; `None` when there is none.
///
/// # Errors
/// When the lengths differ.
pub fn hand_errors(episode: &Episode, track: &HandTrack) -> Result<Option<HandErrors>, BenchError> {
    same_length("hand track", episode.frame_count(), track.frame_count())?;
    let (mut depth, mut joints, mut fitted, mut seen) = (0.0, 0.0, 0.0, 0.0);
    for index in FrameIndex::all(episode.frame_count()) {
        let truth = &episode.truth.frames[index.as_usize()].hands;
        for side in Side::BOTH {
            let Some(truth) = truth[side].as_ref().filter(|hand| hand.in_view) else { continue };
            seen += 1.0;
            let hand = track.at(index)[side];
            if !hand.is_valid() {
                continue;
            }
            fitted += 1.0;
            let (wrist, true_wrist) = (hand.joints[0].xyz, truth.joints[0].xyz);
            depth += (wrist.z - true_wrist.z).abs() / true_wrist.z;
            let pairs = hand.joints.iter().zip(&truth.joints).skip(1);
            let sum: f64 = pairs.map(|(a, b)| ((a.xyz - wrist) - (b.xyz - true_wrist)).norm()).sum();
            joints += sum / 20.0;
        }
    }
    Ok((fitted > 0.0).then(|| HandErrors {
        depth_pct: 100.0 * depth / fitted,
        joint_mm: 1e3 * joints / fitted,
        coverage: fitted / seen,
    }))
}

/// RMS distance in pixels between the robot's wrist, seen from its virtual camera through the clip's intrinsics,
/// and the hand's wrist of `hands`, over driven and reachable frames; `None` when there are none.
///
/// # Errors
/// When the lengths differ.
pub fn wrist_reprojection_px(
    motion: &RobotMotion,
    hands: &HandTrack,
    pinhole: &Pinhole,
) -> Result<Option<f64>, BenchError> {
    same_length("robot motion", hands.frame_count(), motion.angles.len())?;
    let to_camera: Matrix3<f64> = motion.map.rotation.transpose();
    let seen = |torso: Vector3<f64>| {
        pinhole.project(&Position::<Camera>::new(to_camera * (torso - motion.map.offset)))
    };
    let (mut squares, mut count) = (0.0, 0_usize);
    for index in FrameIndex::all(hands.frame_count()) {
        let frame: PerSide<_> = hands.at(index);
        for side in Side::BOTH {
            let report = &motion.sides[side][index.as_usize()];
            if !(report.driven && report.reachable && frame[side].is_valid()) {
                continue;
            }
            let robot = seen(report.reached.position().xyz);
            if let (Some(robot), Some(human)) = (robot, pinhole.project(&frame[side].wrist())) {
                squares += robot.distance(human).powi(2);
                count += 1;
            }
        }
    }
    Ok((count > 0).then(|| (squares / count as f64).sqrt()))
}
