//! Names of joints, bodies and sites in the Unitree description.

use crate::geometry::Side;

use super::{ACTUATED_DOF, ARM_JOINTS};

/// Fingers in keypoint order.
pub const FINGERS: [&str; 5] = ["thumb", "index", "middle", "ring", "pinky"];

/// Description joints behind the six hand actuators, in the record's order.
const HAND_JOINTS: [&str; 6] = [
    "thumb_proximal",
    "thumb_metacarpal",
    "index_proximal",
    "middle_proximal",
    "ring_proximal",
    "pinky_proximal",
];

/// Velocity limits in rad/s for descriptions that carry none (MJCF has no such attribute): arm, then hand, in
/// the record's order of one side; numbers of the public Unitree and BrainCo descriptions.
#[cfg(feature = "engine")]
pub(super) const DEFAULT_VELOCITY: [f64; 13] =
    [37.0, 37.0, 37.0, 37.0, 37.0, 22.0, 22.0, 2.5303, 2.6175, 2.2685, 2.2685, 2.2685, 2.2685];

/// Names of the 26 actuated joints, in the record's order.
pub fn actuated_joint_names() -> [String; ACTUATED_DOF] {
    let arms = Side::BOTH.into_iter().flat_map(|side| ARM_JOINTS.map(|joint| (side, joint)));
    let hands = Side::BOTH.into_iter().flat_map(|side| HAND_JOINTS.map(|joint| (side, joint)));
    let mut names = arms.chain(hands).map(|(side, joint)| format!("{}_{joint}_joint", side.name()));
    std::array::from_fn(|_| names.next().unwrap_or_default())
}

/// The joint at a finger's base: the thumb's swing, another finger's proximal joint.
#[cfg(feature = "engine")]
pub(super) fn base_joint(side: Side, finger: usize) -> String {
    let part = if finger == 0 { "metacarpal" } else { "proximal" };
    format!("{}_{}_{part}_joint", side.name(), FINGERS[finger])
}

/// The site at a fingertip.
pub fn tip_site(side: Side, finger: usize) -> String {
    format!("{}_{}_tip_site", side.name(), FINGERS[finger])
}
