//! Puts a baseline's joint angles into the form of every motion, with the same reports.

use nalgebra::SVector;

use crate::{
    geometry::{PerSide, Side},
    retarget::{
        CameraMap, Method, RobotMotion, WristTurn, filter::limit_rate, mapping::SideMap, params::Weights,
        report::side_reports, solver::SideSolver, target::SideTarget,
    },
    robot::{JointAngles, SIDE_DOF},
};

use super::BaselineClip;

type Angles = SVector<f64, SIDE_DOF>;

/// Joint angles of one side, one a frame.
pub(super) struct BaselineSide {
    /// As solved.
    pub raw: Vec<Angles>,
    /// After the method's own smoothing.
    pub angles: Vec<Angles>,
}

/// The motion of `solved` under `map`, inside position and velocity limits: the published methods know no
/// velocity limits, the record demands them.
pub(super) fn judged(
    clip: &BaselineClip<'_>,
    method: Method,
    map: CameraMap,
    mut solved: PerSide<BaselineSide>,
) -> RobotMotion {
    let frames = clip.hands.frame_count();
    let mut motion = RobotMotion {
        method,
        map,
        // No moving average of ours is in it.
        alpha: 1.0,
        angles: vec![JointAngles::default(); frames],
        raw_angles: vec![JointAngles::default(); frames],
        sides: PerSide { left: Vec::new(), right: Vec::new() },
    };
    for side in Side::BOTH {
        let solver = SideSolver::new(clip.robot, side, Weights::default());
        keep_limits(&mut solved[side].angles, &solver);
        for frame in 0..frames {
            motion.angles[frame].set_side(side, &solved[side].angles[frame].into());
            motion.raw_angles[frame].set_side(side, &solved[side].raw[frame].into());
        }
        let track = &clip.tracks[side];
        let targets = human_wrists(clip, side, map);
        let within = within_reach(clip, side, &targets);
        motion.sides[side] =
            side_reports(clip.robot, (side, track), &targets, &motion.angles, |frame, _| within[frame]);
    }
    motion
}

fn keep_limits(angles: &mut [Angles], solver: &SideSolver<'_>) {
    for joint in 0..SIDE_DOF {
        let inside = |frame: &Angles| frame[joint].clamp(solver.lower[joint], solver.upper[joint]);
        let mut values: Vec<f64> = angles.iter().map(inside).collect();
        limit_rate(&mut values, solver.step[joint]);
        for (frame, value) in angles.iter_mut().zip(values) {
            frame[joint] = value;
        }
    }
}

/// The human's wrists under `map`, uncorrected: corrections belong to our own method.
fn human_wrists(clip: &BaselineClip<'_>, side: Side, map: CameraMap) -> Vec<Option<SideTarget>> {
    let track = &clip.tracks[side];
    let Some(size) = &track.size else { return vec![None; track.poses.len()] };
    let map = SideMap::new(map, clip.robot.chain(side), size, &WristTurn::default());
    track.poses.iter().map(|pose| pose.as_ref().map(|pose| map.wrist(pose))).collect()
}

/// Whether the arm reaches each target at all, when nothing else is asked of it.
fn within_reach(clip: &BaselineClip<'_>, side: Side, targets: &[Option<SideTarget>]) -> Vec<bool> {
    let mut solver = SideSolver::new(clip.robot, side, clip.params.weights);
    let bounds = solver.anywhere();
    let mut warm = solver.comfortable();
    targets
        .iter()
        .map(|target| {
            let Some(target) = target else { return false };
            warm = solver.solve(target, &warm, &warm, &bounds, 12).angles;
            let miss = solver.pose(&warm).wrist - target.wrist.position().xyz;
            miss.norm() <= clip.params.reach_tolerance
        })
        .collect()
}
