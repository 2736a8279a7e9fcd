//! Do as I Do (arXiv 2606.19333), its kinematic part, ported to a robot with arms.
//!
//! Spikes of the wrist's position and rotation are cleaned ([`signal`], [`spikes`]), then a weighted cost of
//! fingertips, palm and posture ([`cost`]) is followed by a few steps a frame ([`substeps`]) and averaged over
//! three frames ([`average`]).
//!
//! Left out: the physics refinement that follows in the published method (sampling-based control of hand and
//! object in a simulator). It needs a mesh of the object and a graphics processor. What is measured here is the
//! kinematic part alone.
//!
//! What the port adds: the camera map of our own method (the published hand floats and needs none); a start
//! that suits an arm; arms that rest where a hand is missing for more than ten frames; velocity limits.

mod average;
mod cost;
mod signal;
mod spikes;
mod substeps;
mod wrist_frame;

use nalgebra::{Rotation3, UnitQuaternion};

use crate::{
    clip::STANDARD_FPS,
    geometry::{PerSide, Side},
    progress::Cancelled,
    retarget::{
        Method, RobotMotion,
        rest::{fill_gaps, rest_angles},
        solver::SideSolver,
    },
};

use super::{
    BaselineClip,
    judge::{BaselineSide, judged},
};
use average::moving_average;
use cost::HandGoal;
use signal::{WristSignal, cleaned};

/// Retargets `clip` as the kinematic part of Do as I Do does.
pub(in crate::retarget) fn do_as_i_do(clip: &BaselineClip<'_>) -> Result<RobotMotion, Cancelled> {
    let solved = PerSide { left: solve_side(clip, Side::Left)?, right: solve_side(clip, Side::Right)? };
    Ok(judged(clip, Method::DoAsIDo, clip.shared_map, solved))
}

fn solve_side(clip: &BaselineClip<'_>, side: Side) -> Result<BaselineSide, Cancelled> {
    clip.watch.check()?;
    let frames = &clip.hands.hands[side];
    let chain = clip.robot.chain(side);
    let mut solver = SideSolver::new(clip.robot, side, clip.params.weights);
    let rest = rest_angles(&solver, side);
    let mut raw = vec![rest; frames.len()];
    let mut angles = raw.clone();
    let mut spans = Vec::new();
    let signals: Vec<_> = frames.iter().map(|frame| WristSignal::new(side, frame)).collect();
    for (span, run) in cleaned(&signals) {
        let goals: Vec<HandGoal> = run.iter().map(|wrist| goal(clip, side, wrist)).collect();
        let solved = substeps::follow(chain, side, &mut solver, &goals, clip.watch)?;
        angles[span.clone()].copy_from_slice(&moving_average(&solved));
        raw[span.clone()].copy_from_slice(&solved);
        spans.push(span);
    }
    let frames_to_rest = (clip.params.rest_time * STANDARD_FPS).ceil().max(1.0) as usize;
    fill_gaps(&mut raw, &spans, &rest, frames_to_rest);
    fill_gaps(&mut angles, &spans, &rest, frames_to_rest);
    clip.watch.advance(frames.len() * (side.index() + 1), 2 * frames.len());
    Ok(BaselineSide { raw, angles })
}

/// What the robot is to reach: wrist and fingertips through the camera map, rotation from the same frame of
/// palm points on both hands.
fn goal(clip: &BaselineClip<'_>, side: Side, wrist: &WristSignal) -> HandGoal {
    let map = clip.shared_map;
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(map.rotation));
    let place = |point: nalgebra::Vector3<f64>| map.beta * (turn * point) + map.offset;
    let in_wrist = wrist_frame::frame_in_wrist(side, clip.robot.chain(side));
    HandGoal {
        palm: place(wrist.position),
        rotation: turn * wrist.rotation * in_wrist.inverse(),
        tips: wrist.tips.map(|tip| place(wrist.position + wrist.rotation * tip)),
    }
}
