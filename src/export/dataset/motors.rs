//! The columns of state and action as Unitree's own datasets name them.

use serde::{Deserialize, Serialize};

use crate::robot::{ACTUATED_DOF, ARM_DOF, HAND_DOF};

/// LeRobot's `robot_type` of this robot in Unitree's datasets.
pub const ROBOT_TYPE: &str = "Unitree_G1_Brainco";

/// Names of the columns of `state` and `action` (unitree_IL_lerobot's order): arms in radians, hands 0 open to 1 closed.
pub const MOTOR_NAMES: [&str; ACTUATED_DOF] = [
    "kLeftShoulderPitch",
    "kLeftShoulderRoll",
    "kLeftShoulderYaw",
    "kLeftElbow",
    "kLeftWristRoll",
    "kLeftWristPitch",
    "kLeftWristYaw",
    "kRightShoulderPitch",
    "kRightShoulderRoll",
    "kRightShoulderYaw",
    "kRightElbow",
    "kRightWristRoll",
    "kRightWristPitch",
    "kRightWristYaw",
    "kLeftHandThumb",
    "kLeftHandThumbAux",
    "kLeftHandIndex",
    "kLeftHandMiddle",
    "kLeftHandRing",
    "kLeftHandPinky",
    "kRightHandThumb",
    "kRightHandThumbAux",
    "kRightHandIndex",
    "kRightHandMiddle",
    "kRightHandRing",
    "kRightHandPinky",
];

/// Which of the thumb's two motors stands in the column `Thumb`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ThumbOrder {
    /// The hardware's: `Thumb` bends it, `ThumbAux` swings it across the palm (default).
    #[default]
    Hardware,
    /// As Unitree's xr_teleoperate feeds them: exchanged.
    UnitreeXr,
}

impl ThumbOrder {
    /// `row` of the record, which has the hardware's order, in this order, as trainers take it.
    pub fn arrange(self, mut row: [f64; ACTUATED_DOF]) -> [f32; ACTUATED_DOF] {
        if self == Self::UnitreeXr {
            for hand in [ARM_DOF, ARM_DOF + HAND_DOF / 2] {
                row.swap(hand, hand + 1);
            }
        }
        row.map(|value| value as f32)
    }

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hardware => "hardware",
            Self::UnitreeXr => "unitree_xr",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thumbs_motors_change_places_in_unitrees_order_and_nothing_else_does() {
        let row: [f64; ACTUATED_DOF] = std::array::from_fn(|column| column as f64);
        let hardware = ThumbOrder::Hardware.arrange(row);
        let swapped = ThumbOrder::UnitreeXr.arrange(row);
        let moved: Vec<usize> = (0..ACTUATED_DOF).filter(|at| hardware[*at] != swapped[*at]).collect();
        assert_eq!(moved, [14, 15, 20, 21]);
        assert_eq!((swapped[14], swapped[15], swapped[20], swapped[21]), (15.0, 14.0, 21.0, 20.0));
    }
}
