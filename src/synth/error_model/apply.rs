//! What an estimator would have said of true hands.

use nalgebra::Vector3;

use super::{
    ErrorModel,
    noise::{Noise, Wander},
};
use crate::{
    clip::STANDARD_FPS,
    geometry::{PerSide, Pinhole, Pixel, Position, Side},
    hands::NamedHand,
    landmarks::{HandLandmarks, KEYPOINT_COUNT},
    synth::{HandTruth, MotionTruth},
};

/// The hands of every frame as an estimator with the errors of `model` names them; `world` holds the joints in the
/// camera frame, metres.
pub(super) fn seen_hands(truth: &MotionTruth, model: &ErrorModel) -> Vec<Vec<NamedHand>> {
    let count = truth.frames.len();
    let mut common = Noise::new(truth.seed, 0);
    let depth_bias = model.depth_bias * common.normal();
    let swapped = model.swaps.draw(count, STANDARD_FPS, &mut common);
    let errors = PerSide::from_fn(|side| SideErrors::draw(model, count, truth.seed, side));
    let mut frames: Vec<Vec<NamedHand>> = Vec::with_capacity(count);
    for (frame, swapped) in swapped.into_iter().enumerate() {
        let mut hands = Vec::new();
        for side in Side::BOTH {
            let errors = &errors[side];
            let Some(hand) = &truth.frames[frame][side] else { continue };
            if !hand.in_view || errors.missed[frame] {
                continue;
            }
            let late = lagged(truth, side, frame, model.lag_frames).unwrap_or(hand.joints.map(|p| p.xyz));
            if let Some(landmarks) = errors.see(&late, frame, depth_bias, &truth.pinhole) {
                let named = if swapped.is_some() { side.other() } else { side };
                hands.push(NamedHand { side: named, landmarks });
            }
        }
        frames.push(hands);
    }
    frames
}

/// The true joints `lag` frames before `frame`, interpolated; `None` where the hand was not there yet.
fn lagged(truth: &MotionTruth, side: Side, frame: usize, lag: f64) -> Option<[Vector3<f64>; KEYPOINT_COUNT]> {
    let place = (frame as f64 - lag).max(0.0);
    let at = |index: usize| -> Option<&HandTruth> { truth.frames.get(index)?[side].as_ref() };
    let before = place.floor() as usize;
    let (a, b) = (at(before)?, at(before + 1).or_else(|| at(before))?);
    let share = place - before as f64;
    Some(std::array::from_fn(|k| a.joints[k].xyz.lerp(&b.joints[k].xyz, share)))
}

/// A side's errors, drawn for the whole episode, so that they do not depend on what is in view.
struct SideErrors {
    shift: [Vec<f64>; 2],
    own: Vec<[Vec<f64>; 2]>,
    jitter: Vec<[[f64; 2]; KEYPOINT_COUNT]>,
    depth: Vec<f64>,
    relief: Vec<Vec<f64>>,
    spike: Vec<Option<([f64; 2], f64)>>,
    missed: Vec<bool>,
    confidence: Vec<f64>,
}

impl SideErrors {
    fn draw(model: &ErrorModel, count: usize, seed: u64, side: Side) -> Self {
        let stream = |part: u64| Noise::new(seed, 16 * (1 + side.index() as u64) + part);
        let (mut slow, mut quick, mut events) = (stream(0), stream(1), stream(2));
        let mut wander = |wander: &Wander| wander.draw(count, &mut slow);
        let mut shift = [wander(&model.shift), wander(&model.shift)];
        let mut own: Vec<[Vec<f64>; 2]> =
            (0..KEYPOINT_COUNT).map(|_| [wander(&model.keypoint), wander(&model.keypoint)]).collect();
        let mut depth = wander(&model.depth);
        let relief = (0..KEYPOINT_COUNT).map(|_| wander(&model.relief)).collect();
        for value in &mut depth {
            *value += model.depth_jitter * quick.normal();
        }
        for value in shift.iter_mut().flatten() {
            *value += model.shake * quick.normal();
        }
        for axis in own.iter_mut().flatten() {
            let constant = model.keypoint_bias * quick.normal();
            axis.iter_mut().for_each(|value| *value += constant);
        }
        let jitter = (0..count)
            .map(|_| std::array::from_fn(|_| [0; 2].map(|_| model.jitter * quick.normal())))
            .collect();
        let confidence = (0..count)
            .map(|_| (model.confidence - model.confidence_spread * quick.normal().abs()).clamp(0.5, 1.0))
            .collect();
        let spikes = model.spikes.draw(count, STANDARD_FPS, &mut events);
        let strengths: Vec<([f64; 2], f64)> = (0..=count)
            .map(|_| {
                let by = model.spike_shift * events.normal().abs();
                (events.direction().map(|part| part * by), model.spike_depth * events.normal())
            })
            .collect();
        let spike = spikes.into_iter().map(|burst| Some(strengths[burst?])).collect();
        let missed = model.dropouts.draw(count, STANDARD_FPS, &mut events);
        let missed = missed.into_iter().map(|burst| burst.is_some()).collect();
        Self { shift, own, jitter, depth, relief, spike, missed, confidence }
    }

    /// The hand with `joints` as seen on `frame`; `None` where a joint is not before the camera.
    fn see(
        &self,
        joints: &[Vector3<f64>; KEYPOINT_COUNT],
        frame: usize,
        depth_bias: f64,
        pinhole: &Pinhole,
    ) -> Option<HandLandmarks> {
        let mut keypoints = [Pixel::default(); KEYPOINT_COUNT];
        for (pixel, joint) in keypoints.iter_mut().zip(joints) {
            *pixel = pinhole.project(&Position::new(*joint))?;
        }
        let extent = extent(&keypoints);
        let (spike, spike_depth) = self.spike[frame].unwrap_or_default();
        let scale = (depth_bias + self.depth[frame] + spike_depth).exp();
        let mut world = [Vector3::zeros(); KEYPOINT_COUNT];
        for (k, pixel) in keypoints.iter_mut().enumerate() {
            let off: [f64; 2] = std::array::from_fn(|axis| {
                let slow = self.shift[axis][frame] + self.own[k][axis][frame];
                extent * (slow + self.jitter[frame][k][axis] + spike[axis])
            });
            *pixel = Pixel::new(pixel.x + off[0], pixel.y + off[1]);
            let relief = self.relief[k][frame] - self.relief[0][frame];
            let depth = (joints[k].z * scale + relief).max(0.05);
            world[k] = pinhole.unproject(*pixel, depth).xyz;
        }
        Some(HandLandmarks { keypoints, world: Some(world), confidence: self.confidence[frame] })
    }
}

/// Longer side of the box around keypoints, pixels.
fn extent(keypoints: &[Pixel; KEYPOINT_COUNT]) -> f64 {
    let side = |of: &dyn Fn(&Pixel) -> f64| {
        let values = keypoints.iter().map(of);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    side(&|p| p.x).max(side(&|p| p.y)).max(1.0)
}
