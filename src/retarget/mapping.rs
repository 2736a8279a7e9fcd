//! From the human hand in camera space to targets for the robot.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};

use crate::robot::SideChain;

use super::{
    CameraMap, WristTurn,
    human::{HumanPose, HumanSize},
    params::Pinch,
    target::{HandTarget, PinchTarget, SideTarget},
};

/// What the map needs to know about one side of the robot and its human.
#[derive(Debug)]
pub(super) struct SideMap {
    map: CameraMap,
    rotation: UnitQuaternion<f64>,
    /// Wrist frame in the palm frame: the robot's own, so that palms and not mounts are made parallel.
    wrist_in_palm: UnitQuaternion<f64>,
    /// A person's correction, as a turn of the palm in its own frame.
    correction: UnitQuaternion<f64>,
    /// Bases of the robot's fingers in its palm frame, metres.
    bases: [Vector3<f64>; 5],
    /// Robot's finger length over the human's.
    scales: [f64; 5],
}

impl SideMap {
    pub fn new(map: CameraMap, chain: &SideChain, size: &HumanSize, correction: &WristTurn) -> Self {
        let lengths = chain.finger_lengths();
        let wrist_in_palm = chain.palm_in_wrist().inverse();
        Self {
            map,
            rotation: UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(map.rotation)),
            wrist_in_palm,
            correction: wrist_in_palm * correction.rotation() * wrist_in_palm.inverse(),
            bases: chain.bases_in_palm(),
            scales: std::array::from_fn(|finger| lengths[finger] / size.fingers[finger]),
        }
    }

    /// The wrist alone: `β R_cam P + T_offset`, the human palm's rotation carried over to the robot's palm.
    pub fn wrist(&self, pose: &HumanPose) -> SideTarget {
        let position = self.map.beta * (self.map.rotation * pose.wrist) + self.map.offset;
        SideTarget::wrist_only(position, self.palm(pose) * self.wrist_in_palm, &self.map.offset)
    }

    /// The palm's rotation in the torso frame, corrected.
    fn palm(&self, pose: &HumanPose) -> UnitQuaternion<f64> {
        self.rotation * pose.palm * self.correction
    }

    /// Wrist and fingers. Each finger keeps its human direction and its share of its own length, from the
    /// robot's finger base.
    pub fn hand(&self, pose: &HumanPose, strengths: &[f64; 4], params: &Pinch) -> SideTarget {
        let palm = self.palm(pose);
        let tip = |finger: usize| palm * (self.bases[finger] + pose.fingers[finger] * self.scales[finger]);
        let pinches = std::array::from_fn(|finger| {
            let direction = pose.gaps[finger].try_normalize(1e-6).unwrap_or_else(Vector3::x);
            PinchTarget { gap: palm * direction * params.gap, strength: strengths[finger] }
        });
        SideTarget { hand: Some(HandTarget { tips: std::array::from_fn(tip), pinches }), ..self.wrist(pose) }
    }
}
