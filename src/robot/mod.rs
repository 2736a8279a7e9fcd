//! Robot description: loading, checks, the MuJoCo model, reduced coordinates.

mod command;

pub use command::{ACTUATED_DOF, ARM_DOF, ARM_JOINTS, HAND_ACTUATORS, HAND_DOF, JointAngles};
