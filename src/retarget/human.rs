//! The human hand in the terms of the robot's: a wrist frame, fingers in the palm, gaps.

use nalgebra::{UnitQuaternion, Vector3};

use crate::{
    hands::HandFrame,
    landmarks::keypoint::{BASES, PARENT, TIPS, WRIST},
    robot::palm_rotation,
};

use crate::smoothing::median;

/// Wrist to middle fingertip of the hand that distances in the parameters refer to, metres.
const REFERENCE_HAND: f64 = 0.18;

/// One human hand on one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct HumanPose {
    /// Wrist in camera axes, metres.
    pub wrist: Vector3<f64>,
    /// Palm frame in camera axes: x wrist → middle base, z pinky base → index base, y = z × x.
    pub palm: UnitQuaternion<f64>,
    /// Finger base → tip in the palm frame, metres, thumb to pinky.
    pub fingers: [Vector3<f64>; 5],
    /// Wrist → fingertip in the palm frame, metres, thumb to pinky.
    pub tips: [Vector3<f64>; 5],
    /// Thumb tip → fingertip in the palm frame, metres, index to pinky.
    pub gaps: [Vector3<f64>; 4],
    /// Trust for smoothing, 0 to 1.
    pub weight: f64,
}

impl HumanPose {
    /// The hand of `frame`, where it is valid, finite, in front of the camera and has a palm.
    pub fn new(frame: &HandFrame) -> Option<Self> {
        if !frame.is_valid() || !frame.joints.iter().all(|joint| joint.is_finite()) {
            return None;
        }
        let at = |index: usize| frame.joints[index].xyz;
        let wrist = at(WRIST);
        if wrist.z <= 0.02 {
            return None;
        }
        let palm = palm_rotation(wrist, at(BASES[1]), at(BASES[2]), at(BASES[4]))?;
        let local = |vector: Vector3<f64>| palm.inverse() * vector;
        let bridged = frame.state == crate::hands::HandState::Bridged;
        let confidence = if frame.confidence.is_finite() { frame.confidence.clamp(0.0, 1.0) } else { 0.0 };
        Some(Self {
            wrist,
            palm,
            fingers: std::array::from_fn(|finger| local(at(TIPS[finger]) - at(BASES[finger]))),
            tips: TIPS.map(|tip| local(at(tip) - wrist)),
            gaps: std::array::from_fn(|finger| local(at(TIPS[finger + 1]) - at(TIPS[0]))),
            weight: if bridged { 0.2 } else { 0.2 + 0.8 * confidence },
        })
    }
}

/// Sizes of one person's hand.
#[derive(Clone, Copy, Debug)]
pub(super) struct HumanSize {
    /// Base to tip along the bones, metres, thumb to pinky.
    pub fingers: [f64; 5],
    /// Wrist to middle tip along the bones, metres.
    pub hand: f64,
}

impl HumanSize {
    /// Medians over the valid frames; `None` without any.
    pub fn measure(frames: &[HandFrame]) -> Option<Self> {
        let valid = || frames.iter().filter(|frame| HumanPose::new(frame).is_some());
        valid().next()?;
        let bone = |child: usize| {
            let lengths: Vec<f64> =
                valid().map(|frame| frame.joints[child].distance(&frame.joints[PARENT[child]])).collect();
            median(&lengths)
        };
        let fingers = TIPS.map(|tip| (bone(tip) + bone(tip - 1) + bone(tip - 2)).max(0.01));
        Some(Self { fingers, hand: (fingers[2] + bone(BASES[2])).max(0.05) })
    }

    /// What a distance between fingertips of this hand would be on the reference hand, metres.
    pub fn normalised(&self, distance: f64) -> f64 {
        distance * REFERENCE_HAND / self.hand
    }
}
