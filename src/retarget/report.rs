//! What a method made of the human's wrist, frame by frame.

use crate::{
    geometry::Side,
    robot::{JointAngles, RobotModel, SidePosture},
};

use super::{SideReport, grip::contact, target::SideTarget, track::HumanTrack};

/// One side as any method is judged: the human's wrist under the clip's camera map against the robot's.
///
/// `targets` holds that wrist where a hand is valid, whatever the method itself steered by, so that errors of
/// different methods mean the same. `reachable` is asked for a frame and its distance to the target, metres.
pub(super) fn side_reports(
    robot: &RobotModel,
    (side, track): (Side, &HumanTrack),
    targets: &[Option<SideTarget>],
    angles: &[JointAngles],
    reachable: impl Fn(usize, f64) -> bool,
) -> Vec<SideReport> {
    let mut posture = SidePosture::default();
    let limits = robot.limits();
    let arm = JointAngles::arm_start(side);
    let mut reports = Vec::with_capacity(angles.len());
    for (frame, angles) in angles.iter().enumerate() {
        robot.chain(side).pose(&angles.side(side), &mut posture);
        let reached = posture.wrist_pose();
        let target = targets[frame].map_or(reached, |target| target.wrist);
        let error_position = reached.position().distance(&target.position());
        let driven = targets[frame].is_some();
        let human = track.poses[frame].as_ref().zip(track.size.as_ref());
        reports.push(SideReport {
            driven,
            target,
            reached,
            fingertips: posture.fingertips(),
            error_position,
            error_rotation: reached.rotation().angle_to(&target.rotation()),
            limit_margin: limits.margin(angles, arm..arm + 7),
            reachable: driven && reachable(frame, error_position),
            contact: human.map_or(0.0, |(pose, size)| contact(pose, size)),
        });
    }
    reports
}
