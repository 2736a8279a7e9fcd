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
        let share = reachable_share(tracks, robot, params, CameraMap { beta, ..map });
        if share >= params.beta_reach {
            return beta;
        }
        if share > best.1 + 1e-9 {
            best = (beta, share);
        }
    }
    best.0
}

/// Robot hand length over human hand length, over both sides.
fn natural_beta(tracks: &PerSide<HumanTrack>, robot: &RobotModel) -> f64 {
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

fn reachable_share(
    tracks: &PerSide<HumanTrack>,
    robot: &RobotModel,
    params: &RetargetParams,
    map: CameraMap,
) -> f64 {
    let (mut reached, mut tried) = (0, 0);
    let farther = CameraMap { beta: map.beta * HEADROOM, ..map };
    for (side, track) in tracks.iter() {
        let Some(size) = &track.size else { continue };
        let mut solver = SideSolver::new(robot, side, params.weights);
        let side_map = SideMap::new(farther, robot.chain(side), size);
        let poses: Vec<&HumanPose> = track.poses.iter().flatten().collect();
        let mut warm = solver.comfortable();
        for pose in poses.iter().step_by(poses.len().div_ceil(SAMPLES).max(1)) {
            tried += 1;
            let target = side_map.wrist(pose);
            reached += usize::from(reaches(&mut solver, &target, &mut warm, params.reach_tolerance));
        }
    }
    if tried == 0 { 1.0 } else { f64::from(reached as u32) / f64::from(tried as u32) }
}

fn reaches(
    solver: &mut SideSolver<'_>,
    target: &SideTarget,
    warm: &mut SVector<f64, SIDE_DOF>,
    tolerance: f64,
) -> bool {
    let bounds = solver.anywhere();
    for start in [*warm, solver.comfortable()] {
        let solution = solver.solve(target, &start, &start, &bounds, 30);
        let error = (solver.pose(&solution.angles).wrist - target.wrist.position().xyz).norm();
        if error <= tolerance {
            *warm = solution.angles;
            return true;
        }
    }
    false
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
    Ok(reachable_share(&tracks, robot, params, params.map(beta / HEADROOM)?))
}
