//! Fitting β: how far away the robot works.

use nalgebra::SVector;

use crate::{
    geometry::{PerSide, Side},
    robot::{RobotModel, SIDE_DOF},
};

use super::{
    CameraMap, human::HumanPose, mapping::SideMap, params::RetargetParams, solver::SideSolver,
    target::SideTarget, track::HumanTrack,
};

/// Candidates lie between these, in steps of 4 %: beyond, the robot's hands look like a giant's or a doll's.
const RANGE: [f64; 2] = [0.5, 1.15];
const STEP: f64 = 1.04;
/// At most so many frames a side are tried.
const SAMPLES: usize = 40;
/// A target counts as reachable when one this much farther is too, so that arms need not be straight.
const HEADROOM: f64 = 1.03;

/// The β nearest to equal apparent hand size (robot hand length over human hand length) that brings the wanted
/// share of frames within reach; where none does, the one with the largest share.
///
/// The picture does not depend on β: scaling about the virtual camera keeps every wrist on its pixel.
pub(super) fn fit_beta(
    tracks: &PerSide<HumanTrack>,
    robot: &RobotModel,
    params: &RetargetParams,
    map: CameraMap,
) -> f64 {
    let natural = natural_beta(tracks, robot);
    let mut best = (natural, -1.0);
    for beta in candidates(natural) {
        let found = reach(tracks, robot, params, CameraMap { beta, ..map });
        if found.share >= params.beta_reach {
            return beta;
        }
        if found.value > best.1 + 1e-9 {
            best = (beta, found.value);
        }
    }
    best.0
}

/// Robot hand length over human hand length, over both sides.
pub(super) fn natural_beta(tracks: &PerSide<HumanTrack>, robot: &RobotModel) -> f64 {
    let ratios: Vec<f64> = tracks
        .iter()
        .filter_map(|(side, track)| {
            let length = robot.chain(side).open_tips_in_palm()[2].norm();
            track.size.map(|size| length / size.hand)
        })
        .collect();
    let mean = if ratios.is_empty() { 0.85 } else { ratios.iter().sum::<f64>() / ratios.len() as f64 };
    mean.clamp(0.7, 1.0)
}

/// From `natural` outwards, nearest first.
fn candidates(natural: f64) -> Vec<f64> {
    let mut all: Vec<f64> = (-20..=20).map(|k| natural * STEP.powi(k)).collect();
    all.retain(|beta| (RANGE[0]..=RANGE[1]).contains(beta));
    all.sort_by(|a, b| (a / natural).ln().abs().total_cmp(&(b / natural).ln().abs()));
    all
}

/// How a map suits the wrists of a clip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// Share of the tried frames that are reached.
    pub share: f64,
    /// The same, with partial credit for near misses: a miss by 10 cm counts a third.
    pub value: f64,
    /// Mean angle that the wrists stay short of their targets, radians.
    pub turn: f64,
}

/// Tries a sample of the frames, wrists alone.
pub(super) fn reach(
    tracks: &PerSide<HumanTrack>,
    robot: &RobotModel,
    params: &RetargetParams,
    map: CameraMap,
) -> Reach {
    let (mut tried, mut sum) = (0.0, Reach { share: 0.0, value: 0.0, turn: 0.0 });
    let farther = CameraMap { beta: map.beta * HEADROOM, ..map };
    for (side, track) in tracks.iter() {
        let Some(size) = &track.size else { continue };
        let mut solver = SideSolver::new(robot, side, params.weights);
        let side_map = SideMap::new(farther, robot.chain(side), size, &params.wrist[side]);
        let poses: Vec<&HumanPose> = track.poses.iter().flatten().collect();
        let mut warm = solver.comfortable();
        for pose in poses.iter().step_by(poses.len().div_ceil(SAMPLES).max(1)) {
            let (miss, turn) = try_wrist(&mut solver, &side_map.wrist(pose), &mut warm);
            let reached = miss <= params.reach_tolerance;
            tried += 1.0;
            sum.share += f64::from(u8::from(reached));
            sum.value += if reached { 1.0 } else { 0.9 * (-miss / 0.1).exp() };
            sum.turn += turn;
        }
    }
    if tried == 0.0 {
        return Reach { share: 1.0, value: 1.0, turn: 0.0 };
    }
    Reach { share: sum.share / tried, value: sum.value / tried, turn: sum.turn / tried }
}

/// Distance (metres) and angle (radians) that the wrist stays short of `target`.
fn try_wrist(
    solver: &mut SideSolver<'_>,
    target: &SideTarget,
    warm: &mut SVector<f64, SIDE_DOF>,
) -> (f64, f64) {
    let bounds = solver.anywhere();
    let mut best = (f64::INFINITY, 0.0, 0.0);
    for start in [*warm, solver.comfortable()] {
        let solution = solver.solve(target, &start, &start, &bounds, 30);
        if solution.cost < best.0 {
            let posture = solver.pose(&solution.angles);
            let miss = (posture.wrist - target.wrist.position().xyz).norm();
            best = (solution.cost, miss, posture.wrist_rotation.angle_to(&target.wrist.rotation()));
            *warm = solution.angles;
        }
        if best.1 < 1e-3 && best.2 < 0.05 {
            break;
        }
    }
    (best.1, best.2)
}

/// Share of the valid frames whose wrist the robot reaches with `params` and scale `beta`; 1 without any.
///
/// # Errors
/// When a parameter is out of its range.
pub fn reachable_share_of(
    hands: &crate::hands::HandTrack,
    robot: &RobotModel,
    params: &RetargetParams,
    beta: f64,
) -> Result<f64, super::RetargetError> {
    let tracks = PerSide::from_fn(|side: Side| HumanTrack::new(&hands.hands[side], &params.cutoff));
    Ok(reach(&tracks, robot, params, params.map(beta / HEADROOM)?).share)
}
