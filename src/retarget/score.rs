//! How well the solver does on targets that are known to be reachable.

use std::time::Instant;

use nalgebra::{SVector, Vector3};
use serde::{Deserialize, Serialize};

use crate::{
    geometry::{PerSide, Side},
    robot::{JointAngles, RobotModel, SIDE_DOF, SidePosture},
    smoothing::median,
};

use super::{
    params::Weights,
    solver::{SideSolver, Solution},
    start::solve_afresh,
    target::{HandTarget, PinchTarget, SideTarget},
};

/// Frames that [`score_ik`] solves.
const FRAMES: usize = 150;

/// What [`score_ik`] measures over 150 frames of both arms and hands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct IkScore {
    /// Mean distance of the wrists to their targets, millimetres.
    pub position_error_mm: f64,
    /// Largest distance, millimetres.
    pub position_error_max_mm: f64,
    /// Mean angle of the wrists to their targets, degrees.
    pub rotation_error_deg: f64,
    /// Mean distance of the fingertips to where they should be, millimetres.
    pub fingertip_error_mm: f64,
    /// Joints beyond a position or velocity limit, over all frames.
    pub limit_violations: usize,
    /// Time of one frame, both arms and hands, one core, milliseconds: the median, which other processes on
    /// the machine do not move.
    pub time_ms: f64,
}

/// 150 frames (30 FPS) of both arms and hands that wander smoothly inside their limits: what [`score_ik`] takes its
/// targets from.
pub fn reachable_motion(robot: &RobotModel, seed: u64) -> Vec<JointAngles> {
    (0..FRAMES).map(|frame| smooth_motion(robot, seed, frame)).collect()
}

/// Solves 150 frames (30 FPS) of smooth reachable wrist poses and finger motions, made by moving the robot's
/// own joints inside their limits. The solver sees the targets alone, frame by frame, warm-started.
pub fn score_ik(robot: &RobotModel, seed: u64) -> IkScore {
    score_ik_with(robot, seed, Weights::default())
}

/// As [`score_ik`] with other weights: without posture and inertia nothing pulls away from the targets.
pub fn score_ik_with(robot: &RobotModel, seed: u64, weights: Weights) -> IkScore {
    let motion = reachable_motion(robot, seed);
    let targets: PerSide<Vec<SideTarget>> =
        PerSide::from_fn(|side| motion.iter().map(|angles| target_of(robot, side, angles)).collect());
    let mut solvers = PerSide::from_fn(|side| SideSolver::new(robot, side, weights));
    let mut now: PerSide<SVector<f64, SIDE_DOF>> = PerSide::from_fn(|side| {
        let found = solve_afresh(&mut solvers[side], side, &targets[side][0]);
        found.first().map_or_else(|| solvers[side].comfortable(), |best: &Solution| best.angles)
    });
    let mut solved = Vec::with_capacity(FRAMES);
    let mut times = Vec::with_capacity(FRAMES);
    for frame in 0..FRAMES {
        let began = Instant::now();
        let mut angles = JointAngles::default();
        for side in Side::BOTH {
            let bounds = solvers[side].reachable_from(&now[side]);
            let target = &targets[side][frame];
            now[side] = solvers[side].solve(target, &now[side], &now[side], &bounds, 8).angles;
            angles.set_side(side, &now[side].into());
        }
        solved.push(angles);
        times.push(began.elapsed().as_secs_f64() * 1e3);
    }
    measure(robot, &targets, &solved, median(&times))
}

fn measure(
    robot: &RobotModel,
    targets: &PerSide<Vec<SideTarget>>,
    solved: &[JointAngles],
    time_ms: f64,
) -> IkScore {
    let limits = robot.limits();
    let (mut position, mut largest, mut rotation, mut tips): (f64, f64, f64, f64) = (0.0, 0.0, 0.0, 0.0);
    for side in Side::BOTH {
        for (angles, target) in solved.iter().zip(&targets[side]) {
            let posture = robot.posture(side, angles);
            let distance = (posture.wrist - target.wrist.position().xyz).norm();
            position += distance;
            largest = largest.max(distance);
            rotation += posture.wrist_rotation.angle_to(&target.wrist.rotation());
            if let Some(hand) = &target.hand {
                let miss = |f: usize| (posture.tips[f] - posture.wrist - hand.tips[f]).norm();
                tips += (0..5).map(miss).sum::<f64>() / 5.0;
            }
        }
    }
    let violations: usize = solved
        .iter()
        .map(|angles| limits.position_violations(angles, 1e-9))
        .sum::<usize>()
        + solved.windows(2).map(|pair| limits.velocity_violations(&pair[0], &pair[1], 1e-9)).sum::<usize>();
    let count = (2 * solved.len()) as f64;
    IkScore {
        position_error_mm: position / count * 1e3,
        position_error_max_mm: largest * 1e3,
        rotation_error_deg: (rotation / count).to_degrees(),
        fingertip_error_mm: tips / count * 1e3,
        limit_violations: violations,
        time_ms,
    }
}

fn target_of(robot: &RobotModel, side: Side, angles: &JointAngles) -> SideTarget {
    let mut posture = SidePosture::default();
    robot.chain(side).pose(&angles.side(side), &mut posture);
    let camera = Vector3::new(0.0576, 0.0, 0.4299);
    let mut target = SideTarget::wrist_only(posture.wrist, posture.wrist_rotation, &camera);
    let tips = posture.tips.map(|tip| tip - posture.wrist);
    target.hand = Some(HandTarget { tips, pinches: [PinchTarget::default(); 4] });
    target
}

/// Joint angles that wander smoothly: two sines a joint about the middle of a comfortable range.
fn smooth_motion(robot: &RobotModel, seed: u64, frame: usize) -> JointAngles {
    // Left arm: centre and reach of the wandering, radians; the right mirrors.
    const CENTRE: [f64; 7] = [-0.3, 0.25, 0.0, 0.2, 0.0, 0.0, 0.0];
    const REACH: [f64; 7] = [0.45, 0.3, 0.4, 0.5, 0.7, 0.5, 0.5];
    let time = frame as f64 / crate::clip::STANDARD_FPS;
    let wave = |joint: usize, fastest_hz: f64| {
        let draw = |what: u64| unit_draw(seed, joint as u64 * 4 + what);
        let tau = std::f64::consts::TAU;
        let slow = (tau * (draw(0) + 0.5 * fastest_hz * (0.4 + 0.6 * draw(1)) * time)).sin();
        let fast = (tau * (draw(2) + fastest_hz * (0.6 + 0.4 * draw(3)) * time)).sin();
        0.75 * slow + 0.25 * fast
    };
    let limits = robot.limits();
    let mut angles = JointAngles::default();
    for side in Side::BOTH {
        for joint in 0..7 {
            let mirror = if side == Side::Right && matches!(joint, 1 | 2 | 4 | 6) { -1.0 } else { 1.0 };
            let index = JointAngles::arm_start(side) + joint;
            angles.0[index] = mirror * (CENTRE[joint] + REACH[joint] * wave(index, 0.5));
        }
        for joint in 0..6 {
            let index = JointAngles::hand_start(side) + joint;
            // Slow enough for the fingers' velocity limits.
            angles.0[index] = limits.upper[index] * (0.5 + 0.4 * wave(index, 0.3));
        }
    }
    limits.clamp(&angles)
}

/// A number in 0..1 that depends on `seed` and `index` alone (SplitMix64).
fn unit_draw(seed: u64, index: u64) -> f64 {
    let mut z = seed.wrapping_add(index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reachable_targets_are_met_within_a_tenth_of_a_millimetre_and_all_limits() {
        let robot = RobotModel::embedded().unwrap();
        for seed in 0..4 {
            let score = score_ik(&robot, seed);
            println!("{score:?}");
            assert!(score.position_error_mm < 0.1, "{score:?}");
            assert_eq!(score.limit_violations, 0, "{score:?}");
        }
    }
}
