//! How well the fit does on hands whose truth is known.

use nalgebra::{SVector, UnitQuaternion, Vector3};
use rand::{Rng, RngCore, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::{
    FitParams, fit,
    kinematics::{HandPose, joints},
    priors::angle_priors,
    shape::{HandShape, ShapeVector},
};
use crate::{
    geometry::{Camera, PerSide, Pinhole, Pixel, Position, Side, Size},
    hands::{HandTrack, HandsError},
    landmarks::{HandLandmarks, KEYPOINT_COUNT, LandmarkTrack, keypoint},
    progress::Unwatched,
};

/// Errors of a fitted track against truth, over all frames where both have a hand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FitScore {
    /// Mean absolute wrist depth error, per cent of the depth.
    pub depth_error_pct: f64,
    /// Mean distance of joints relative to the wrist, millimetres.
    pub joint_error_mm: f64,
    /// Hands that were compared, one a frame and side.
    pub hands: usize,
    /// Share of true hands that the track knows.
    pub coverage: f64,
}

impl FitScore {
    /// Compares `track` with the true joints of each side, camera frame, metres, one entry a frame.
    pub fn compare(
        track: &HandTrack,
        truth: &PerSide<Vec<Option<[Position<Camera>; KEYPOINT_COUNT]>>>,
    ) -> Self {
        let mut score = Self::default();
        let mut expected = 0;
        for (side, frames) in truth.iter() {
            for (hand, joints) in track.hands[side].iter().zip(frames) {
                let Some(joints) = joints else { continue };
                expected += 1;
                if !hand.is_valid() {
                    continue;
                }
                let (found, wrist) = (hand.wrist().xyz, joints[keypoint::WRIST].xyz);
                score.hands += 1;
                score.depth_error_pct += 100.0 * ((found.z - wrist.z) / wrist.z).abs();
                let off = |k: usize| ((hand.joints[k].xyz - found) - (joints[k].xyz - wrist)).norm();
                // The wrist itself is the reference: 20 joints are compared.
                score.joint_error_mm +=
                    1e3 * (1..KEYPOINT_COUNT).map(off).sum::<f64>() / (KEYPOINT_COUNT - 1) as f64;
            }
        }
        let count = score.hands.max(1) as f64;
        score.depth_error_pct /= count;
        score.joint_error_mm /= count;
        score.coverage = score.hands as f64 / f64::from(expected.max(1));
        score
    }
}

/// Fits `clips` random smooth motions of random hands (single bones ±3 %, the length of each hand
/// known), seen at 640×480 with 1 px of noise from 0.3 to 0.6 m, and compares with their truth.
///
/// # Errors
/// As [`fit`](super::fit).
pub fn score_fit(seed: u64, clips: usize, frames: usize) -> Result<FitScore, HandsError> {
    let mut total = FitScore::default();
    for clip in 0..clips as u64 {
        let mut random = Pcg64Mcg::seed_from_u64(seed.wrapping_mul(1000).wrapping_add(clip));
        let score = score_clip(&mut random, frames)?;
        total.depth_error_pct += score.depth_error_pct / clips as f64;
        total.joint_error_mm += score.joint_error_mm / clips as f64;
        total.coverage += score.coverage / clips as f64;
        total.hands += score.hands;
    }
    Ok(total)
}

fn score_clip(random: &mut Pcg64Mcg, frames: usize) -> Result<FitScore, HandsError> {
    let size = Size::new(640, 480);
    let focal = random.random_range(500.0..600.0);
    let pinhole = Pinhole { fx: focal, fy: focal, cx: 319.5, cy: 239.5, size };
    let mut truth = PerSide::from_fn(|_| Vec::with_capacity(frames));
    let mut landmarks: LandmarkTrack = vec![PerSide::default(); frames];
    let length = random.random_range(0.170..0.205);
    let shape = varied(length, random);
    for side in Side::BOTH {
        let motion = Motion::random(random);
        for (frame, hands) in landmarks.iter_mut().enumerate() {
            let mirror = if side == Side::Right { -1.0 } else { 1.0 };
            let joints = joints(&shape, &motion.at(frame as f64 / 30.0)).map(|mut p| {
                p.x *= mirror;
                Position::<Camera>::new(p)
            });
            let keypoints = joints.map(|j| {
                let p = pinhole.project(&j).unwrap_or_default();
                Pixel::new(p.x + gaussian(random), p.y + gaussian(random))
            });
            hands[side] = Some(HandLandmarks { keypoints, world: None, confidence: 1.0 });
            truth[side].push(Some(joints));
        }
    }
    let params = FitParams { hand_length_mm: 1e3 * shape.length(), ..FitParams::default() };
    let track = fit(&landmarks, "synthetic", &pinhole, &params, &Unwatched)?;
    Ok(FitScore::compare(&track, &truth))
}

/// A hand of this length with bones of its own.
fn varied(length: f64, random: &mut Pcg64Mcg) -> HandShape {
    let step = ShapeVector::from_fn(|k, _| gaussian(random) * if k < 15 { 0.0015 } else { 0.03 });
    HandShape::average(length).stepped(&step)
}

/// Normal deviate of unit spread (Box–Muller).
fn gaussian(random: &mut impl RngCore) -> f64 {
    let (u, v): (f64, f64) = (random.random(), random.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// A slow wave: mean, amplitude, frequency in Hz, phase.
#[derive(Clone, Copy)]
struct Wave(f64, f64, f64, f64);

impl Wave {
    fn random(low: f64, high: f64, random: &mut Pcg64Mcg) -> Self {
        let (a, b) = (random.random_range(low..=high), random.random_range(low..=high));
        Self(0.5 * (a + b), 0.5 * (b - a), random.random_range(0.15..0.5), random.random_range(0.0..6.3))
    }

    fn at(&self, time: f64) -> f64 {
        self.0 + self.1 * (std::f64::consts::TAU * self.2 * time + self.3).sin()
    }
}

struct Motion {
    wrist: [Wave; 3],
    turn: [Wave; 3],
    angles: Vec<Wave>,
}

impl Motion {
    /// A first-person hand: wrist below the middle, fingers up and away, back or edge to the camera.
    /// Right hands are the mirror of the same, so both sides are drawn alike.
    fn random(random: &mut Pcg64Mcg) -> Self {
        let wrist = [(-0.12, 0.02), (0.02, 0.12), (0.34, 0.58)].map(|(a, b)| Wave::random(a, b, random));
        let turn = [(-0.7, 0.7), (-1.0, 1.0), (-0.6, 0.6)].map(|(a, b)| Wave::random(a, b, random));
        let angles = angle_priors()
            .iter()
            .enumerate()
            .map(|(k, prior)| {
                let (low, high) =
                    if k < 3 { (-0.35, 0.35) } else { (prior.low.max(-0.15), prior.high - 0.3) };
                Wave::random(low, high.max(low + 0.05), random)
            })
            .collect();
        Self { wrist, turn, angles }
    }

    fn at(&self, time: f64) -> HandPose {
        let mut angles = SVector::from_fn(|k, _| self.angles[k].at(time));
        for finger in 0..4 {
            // DIP follows PIP as tendons have it, but not strictly.
            let pip = 5 + 4 * finger + 2;
            angles[pip + 1] = 0.6 * angles[pip] + 0.2 * (angles[pip + 1] - 0.5);
        }
        let wrist = Vector3::from_fn(|k, _| self.wrist[k].at(time));
        // Fingers up the picture and away from the camera, the back of the hand towards it.
        let away = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -0.6);
        let base = nalgebra::Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&[
            -Vector3::y(),
            -Vector3::z(),
            Vector3::x(),
        ]));
        let turned = UnitQuaternion::from_euler_angles(
            self.turn[0].at(time),
            self.turn[1].at(time),
            self.turn[2].at(time),
        );
        HandPose { wrist, rotation: turned * away * UnitQuaternion::from_rotation_matrix(&base), angles }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn true_keypoints_with_one_pixel_of_noise_give_metric_hands() {
        let score = score_fit(7, 2, 60).expect("fits");
        assert!(score.coverage == 1.0);
        assert!(score.depth_error_pct < 2.5, "{score:?}");
        assert!(score.joint_error_mm < 6.0, "{score:?}");
    }
}
