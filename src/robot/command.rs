//! The 26 actuated joints, in the record's order.

use serde::{Deserialize, Serialize};

use crate::geometry::Side;

/// Arm joints of both sides.
pub const ARM_DOF: usize = 14;
/// Hand actuators of both sides.
pub const HAND_DOF: usize = 12;
/// All actuated joints.
pub const ACTUATED_DOF: usize = ARM_DOF + HAND_DOF;

/// Arm joints of one side, in the record's order: names are `{side}_{name}_joint`.
pub const ARM_JOINTS: [&str; 7] =
    ["shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow", "wrist_roll", "wrist_pitch", "wrist_yaw"];

/// Hand actuators of one side, in the record's order (the hardware's): thumb flexion, thumb swing, fingers.
pub const HAND_ACTUATORS: [&str; 6] = ["thumb", "thumb_aux", "index", "middle", "ring", "pinky"];

/// One angle in radians for each actuated joint: 7 left arm, 7 right arm, 6 left hand, 6 right hand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointAngles(#[serde(with = "array26")] pub [f64; ACTUATED_DOF]);

impl Default for JointAngles {
    fn default() -> Self {
        Self([0.0; ACTUATED_DOF])
    }
}

impl JointAngles {
    /// The 14 arm angles, left first.
    pub fn arms(&self) -> &[f64] {
        &self.0[..ARM_DOF]
    }

    /// The 12 hand angles, left first.
    pub fn hands(&self) -> &[f64] {
        &self.0[ARM_DOF..]
    }

    /// Where a side's arm starts.
    pub const fn arm_start(side: Side) -> usize {
        side.index() * 7
    }

    /// Where a side's hand starts.
    pub const fn hand_start(side: Side) -> usize {
        ARM_DOF + side.index() * 6
    }
}

mod array26 {
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    pub(super) fn serialize<S: Serializer>(value: &[f64; 26], serializer: S) -> Result<S::Ok, S::Error> {
        value.as_slice().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 26], D::Error> {
        let values = Vec::<f64>::deserialize(deserializer)?;
        let found = values.len();
        values.try_into().map_err(|_| serde::de::Error::invalid_length(found, &"26 joint angles"))
    }
}
