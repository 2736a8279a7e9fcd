//! Masquerade (Lepert, Fang and Bohg 2025, "Masquerade: Learning from In-the-wild Human Videos using
//! Data-Editing"): the hand as a parallel gripper, ported to a robot with hands.
//!
//! From the keypoints come a grasp point, an orientation and a width ([`grasp`]); on a 15 Hz timeline without
//! the frames where no hand is seen ([`timeline`]) the point's axes and the width are smoothed by Gaussian
//! processes, the orientation by a running slerp, and the gripper closes once a clip ([`gripper`]).
//!
//! What the port adds: the gripper's frame on the robot's hand, its origin midway between thumb and middle tip,
//! its axes rigid on the palm as the human's sit on theirs on average over the clip (read off the robot's own
//! fingertips they would turn over as its thumb swings across); all six hand joints close together; inverse kinematics, limits and the resampling to 30 FPS.
//! What it leaves out: nothing of the retargeting; the published video stage (robot always in front of the
//! object, frames with more than 5 cm of tracking error black) is not part of retargeting.

mod gaussian_process;
mod grasp;
mod gripper;
mod orientation;
mod simplex;
mod timeline;
mod toeplitz;

use nalgebra::{Isometry3, Rotation3, SVector, UnitQuaternion, Vector3};

use crate::{
    geometry::{PerSide, Side},
    progress::Cancelled,
    retarget::{
        CameraMap, Method, RobotMotion,
        params::{RetargetParams, Weights},
        solver::SideSolver,
        start::solve_afresh,
        target::SideTarget,
        view::middle_of_wrists,
    },
    robot::SIDE_DOF,
};

use super::{
    BaselineClip,
    judge::{BaselineSide, judged},
};
use grasp::GraspPoints;
use timeline::{GripperState, filled, kept_frames, resampled};

type Angles = SVector<f64, SIDE_DOF>;

/// Where a hand that is never seen waits: the left one, the right one mirrored, `torso_link`, metres.
const NEUTRAL: [f64; 3] = [0.4, 0.5, 0.3];

/// Retargets `clip` as Masquerade does.
pub(in crate::retarget) fn masquerade(clip: &BaselineClip<'_>) -> Result<RobotMotion, Cancelled> {
    let map = camera_map(clip);
    let count = clip.hands.frame_count();
    let seen = PerSide::from_fn(|side| seen_grippers(clip, side, &map));
    let kept = kept_frames(count, |frame| Side::BOTH.iter().any(|&side| seen[side][frame].is_some()));
    let mut solved = PerSide { left: None, right: None };
    for side in Side::BOTH {
        clip.watch.check()?;
        let timeline: Vec<_> = kept.iter().map(|&frame| seen[side][frame]).collect();
        let smoothed = smoothed(&filled(&timeline, neutral(side)));
        let mut grippers = resampled(&kept, &smoothed, count);
        // No hand on any frame: both wait.
        grippers.resize(count, neutral(side));
        solved[side] = Some(solve_side(clip, side, &grippers)?);
        clip.watch.advance(count * (side.index() + 1), 2 * count);
    }
    let none = || BaselineSide { raw: Vec::new(), angles: Vec::new() };
    let PerSide { left, right } = solved;
    let solved = PerSide { left: left.unwrap_or_else(none), right: right.unwrap_or_else(none) };
    Ok(judged(clip, Method::Masquerade, map, solved))
}

/// The method's own fixed transform P_i = R p_i + t, β = 1; or our map, where the parameters say so.
///
/// R is ours. So is t where a person set it; the untouched default stands for a base that is put where the
/// hands are within reach, so it is moved until the middle of the wrists lies where our map puts it.
fn camera_map(clip: &BaselineClip<'_>) -> CameraMap {
    let (shared, params, default) = (clip.shared_map, clip.params, RetargetParams::default());
    if params.shared_map {
        return shared;
    }
    let mut map = CameraMap { beta: 1.0, ..shared };
    let untouched = params.camera == default.camera && params.offset == default.offset;
    if let Some(middle) = middle_of_wrists(clip.tracks).filter(|_| untouched) {
        map.offset += (shared.beta - 1.0) * (shared.rotation * middle);
    }
    map
}

fn seen_grippers(clip: &BaselineClip<'_>, side: Side, map: &CameraMap) -> Vec<Option<GripperState>> {
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(map.rotation));
    let frames = clip.hands.hands[side].iter();
    frames
        .map(|frame| {
            let mut state = GripperState::from(GraspPoints::of_human(frame)?.grasp()?);
            let point = map.beta * (turn * state.pose.translation.vector) + map.offset;
            state.pose = Isometry3::from_parts(point.into(), turn * state.pose.rotation);
            Some(state)
        })
        .collect()
}

fn neutral(side: Side) -> GripperState {
    let [x, y, z] = NEUTRAL;
    let out = if side == Side::Left { 1.0 } else { -1.0 };
    GripperState { pose: Isometry3::translation(x, out * y, z), width: 0.085 }
}

/// Positions axis by axis and the width by Gaussian processes, orientations by a running slerp, one grasp.
fn smoothed(states: &[GripperState]) -> Vec<GripperState> {
    let axis = |axis: usize| {
        let values: Vec<f64> = states.iter().map(|state| state.pose.translation.vector[axis]).collect();
        gaussian_process::smooth(&values)
    };
    let (x, y, z) = (axis(0), axis(1), axis(2));
    let mut widths = gaussian_process::smooth(&states.iter().map(|state| state.width).collect::<Vec<f64>>());
    gripper::hold_one_grasp(&mut widths);
    let rotations = orientation::smooth(&states.iter().map(|state| state.pose.rotation).collect::<Vec<_>>());
    (0..states.len())
        .map(|t| GripperState {
            pose: Isometry3::from_parts(Vector3::new(x[t], y[t], z[t]).into(), rotations[t]),
            width: widths[t],
        })
        .collect()
}

/// The arm that brings the gripper's frame on the robot's hand to each of `grippers`, and the closing hand.
fn solve_side(
    clip: &BaselineClip<'_>,
    side: Side,
    grippers: &[GripperState],
) -> Result<BaselineSide, Cancelled> {
    // Out of reach nothing is preferred: our own preference for the line of sight is not the method's.
    let weights = Weights { along_sight: 1.0, ..clip.params.weights };
    let mut solver = SideSolver::new(clip.robot, side, weights);
    let axes = axes_on_palm(clip, side);
    let mut raw: Vec<Angles> = Vec::with_capacity(grippers.len());
    for (frame, gripper) in grippers.iter().enumerate() {
        if frame % 64 == 0 {
            clip.watch.check()?;
        }
        let closing = gripper::closing(gripper.width);
        let hand: [f64; 6] = std::array::from_fn(|joint| {
            let (low, high) = (solver.lower[7 + joint], solver.upper[7 + joint]);
            low + closing * (high - low)
        });
        let points = GraspPoints::of_robot(clip.robot.chain(side), &hand);
        let on_hand = Isometry3::from_parts(points.point().into(), axes);
        let wrist = gripper.pose * on_hand.inverse();
        let target =
            SideTarget::wrist_only(wrist.translation.vector, wrist.rotation, &clip.shared_map.offset);
        let mut angles = match raw.last() {
            Some(before) => {
                let bounds = solver.reachable_from(before);
                solver.solve(&target, before, before, &bounds, 12).angles
            }
            None => solve_afresh(&mut solver, side, &target)
                .first()
                .map_or_else(|| solver.comfortable(), |best| best.angles),
        };
        for (joint, angle) in hand.into_iter().enumerate() {
            angles[7 + joint] = angle;
        }
        raw.push(angles);
    }
    Ok(BaselineSide { angles: raw.clone(), raw })
}

/// Axes of the gripper in the robot's wrist frame: as the human's lie in the palm, the mean over the clip.
fn axes_on_palm(clip: &BaselineClip<'_>, side: Side) -> UnitQuaternion<f64> {
    let seen = clip.hands.hands[side].iter().zip(&clip.tracks[side].poses);
    let on_palms = seen.filter_map(|(frame, pose)| {
        let grasp = GraspPoints::of_human(frame)?.grasp()?;
        Some(pose.as_ref()?.palm.inverse() * grasp.pose.rotation)
    });
    let mean = on_palms.enumerate().fold(UnitQuaternion::identity(), |mean, (count, here)| {
        orientation::slerp(&mean, &here, 1.0 / (count + 1) as f64)
    });
    clip.robot.chain(side).palm_in_wrist() * mean
}
