//! From the human hand in camera space to targets for the robot.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};

use crate::robot::SideChain;

use super::{
    CameraMap, WristTurn,
    human::{HumanPose, HumanSize},
    params::Pinch,
    target::{HandTarget, PinchTarget, SideTarget},
};

/// Between a finger that keeps its human direction and bend from its own base (0), and a fingertip that lies from
/// the wrist as the human's does, scaled by the length of the hand (1).
const TIP_SHARE: f64 = 0.5;

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
    size: HumanSize,
    /// Robot's hand length over the human's.
    hand_scale: f64,
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
            size: *size,
            hand_scale: chain.open_tips_in_palm()[2].norm() / size.hand,
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

    /// Wrist and fingers. Each fingertip lies between where its finger keeps the human's direction and its share of
    /// its own length, from the robot's finger base, and where the human's lies from the wrist, scaled.
    pub fn hand(&self, pose: &HumanPose, strengths: &[f64; 4], params: &Pinch) -> SideTarget {
        let palm = self.palm(pose);
        let tip = |finger: usize| {
            let own = self.bases[finger] + pose.fingers[finger] * self.scales[finger];
            palm * own.lerp(&(pose.tips[finger] * self.hand_scale), TIP_SHARE)
        };
        let pinches = std::array::from_fn(|finger| {
            let gap = pose.gaps[finger];
            let direction = gap.try_normalize(1e-6).unwrap_or_else(Vector3::x);
            // Closed as long as the human's is; between `close` and `release` it opens as the human's does.
            let opened =
                (self.size.normalised(gap.norm()) - params.close) / (params.release - params.close).max(1e-6);
            let share = opened.clamp(0.0, 1.0);
            let length = params.gap + share * (gap.norm() * self.scales[finger + 1] - params.gap).max(0.0);
            PinchTarget { gap: palm * direction * length, strength: strengths[finger] }
        });
        SideTarget { hand: Some(HandTarget { tips: std::array::from_fn(tip), pinches }), ..self.wrist(pose) }
    }
}
