//! The human hand of one side over a clip, smoothed before anything is solved.

use std::ops::Range;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::{clip::STANDARD_FPS, hands::HandFrame, smoothing::smooth_together};

use super::{
    human::{HumanPose, HumanSize},
    params::Cutoff,
};

/// Residuals below these are noise of a usual estimator, not outliers: tangent of an angle (about 2 pixels at
/// f = 600), share of the depth, quaternion component, metres.
const FLOORS: [f64; 4] = [3e-3, 0.02, 0.03, 0.006];

/// One side's human hand.
#[derive(Debug)]
pub(super) struct HumanTrack {
    /// One a frame; `None` where the hand is not valid.
    pub poses: Vec<Option<HumanPose>>,
    /// Runs of valid frames, in order.
    pub spans: Vec<Range<usize>>,
    /// The person's hand; `None` where no frame is valid.
    pub size: Option<HumanSize>,
}

impl HumanTrack {
    /// Reads and smooths one side.
    pub fn new(frames: &[HandFrame], cutoff: &Cutoff) -> Self {
        let mut poses: Vec<Option<HumanPose>> = frames.iter().map(HumanPose::new).collect();
        let spans = valid_spans(&poses);
        for span in &spans {
            let mut run: Vec<HumanPose> = poses[span.clone()].iter().copied().flatten().collect();
            smooth_run(&mut run, cutoff);
            for (slot, pose) in poses[span.clone()].iter_mut().zip(run) {
                *slot = Some(pose);
            }
        }
        Self { poses, spans, size: HumanSize::measure(frames) }
    }
}

fn valid_spans(poses: &[Option<HumanPose>]) -> Vec<Range<usize>> {
    let mut spans: Vec<Range<usize>> = Vec::new();
    for frame in (0..poses.len()).filter(|&frame| poses[frame].is_some()) {
        match spans.last_mut() {
            Some(last) if last.end == frame => last.end = frame + 1,
            _ => spans.push(frame..frame + 1),
        }
    }
    spans
}

fn smooth_run(run: &mut [HumanPose], cutoff: &Cutoff) {
    let weights: Vec<f64> = run.iter().map(|pose| pose.weight).collect();
    smooth_wrist(run, &weights, cutoff);
    smooth_palm(run, &weights, cutoff.rotation_hz);
    for finger in 0..5 {
        smooth_vectors(run, &weights, cutoff.finger_hz, |pose| &mut pose.fingers[finger]);
        smooth_vectors(run, &weights, cutoff.finger_hz, |pose| &mut pose.tips[finger]);
    }
    for finger in 0..4 {
        smooth_vectors(run, &weights, cutoff.finger_hz, |pose| &mut pose.gaps[finger]);
    }
}

/// Across the line of sight in tangents, along it in the logarithm of the depth.
fn smooth_wrist(run: &mut [HumanPose], weights: &[f64], cutoff: &Cutoff) {
    let column = |value: &dyn Fn(&HumanPose) -> f64| run.iter().map(value).collect::<Vec<_>>();
    let x = column(&|pose| pose.wrist.x / pose.wrist.z);
    let y = column(&|pose| pose.wrist.y / pose.wrist.z);
    let depth = column(&|pose| pose.wrist.z.ln());
    let across = smooth_together(&[&x, &y], weights, cutoff.across_hz / STANDARD_FPS, FLOORS[0]);
    let depth = smooth_together(&[&depth], weights, cutoff.depth_hz / STANDARD_FPS, FLOORS[1]);
    for (t, pose) in run.iter_mut().enumerate() {
        let z = depth[0][t].exp();
        pose.wrist = Vector3::new(across[0][t] * z, across[1][t] * z, z);
    }
}

fn smooth_palm(run: &mut [HumanPose], weights: &[f64], cutoff_hz: f64) {
    let mut signals: [Vec<f64>; 4] = Default::default();
    let mut last = run[0].palm.into_inner();
    for pose in run.iter() {
        let mut here = pose.palm.into_inner();
        // A rotation has two quaternions; keep to the one next to the frame before.
        if here.coords.dot(&last.coords) < 0.0 {
            here = -here;
        }
        last = here;
        for (signal, value) in signals.iter_mut().zip(here.coords.iter()) {
            signal.push(*value);
        }
    }
    let columns: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
    let smoothed = smooth_together(&columns, weights, cutoff_hz / STANDARD_FPS, FLOORS[2]);
    for (t, pose) in run.iter_mut().enumerate() {
        let quaternion = Quaternion::new(smoothed[3][t], smoothed[0][t], smoothed[1][t], smoothed[2][t]);
        if quaternion.norm() > 0.1 {
            pose.palm = UnitQuaternion::from_quaternion(quaternion);
        }
    }
}

fn smooth_vectors(
    run: &mut [HumanPose],
    weights: &[f64],
    cutoff_hz: f64,
    vector: impl Fn(&mut HumanPose) -> &mut Vector3<f64>,
) {
    let mut signals: [Vec<f64>; 3] = Default::default();
    for pose in run.iter_mut() {
        let value = *vector(pose);
        for axis in 0..3 {
            signals[axis].push(value[axis]);
        }
    }
    let columns: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
    let smoothed = smooth_together(&columns, weights, cutoff_hz / STANDARD_FPS, FLOORS[3]);
    for (t, pose) in run.iter_mut().enumerate() {
        *vector(pose) = Vector3::new(smoothed[0][t], smoothed[1][t], smoothed[2][t]);
    }
}
