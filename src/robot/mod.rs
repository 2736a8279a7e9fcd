//! Robot description: loading, checks, the MuJoCo model, reduced coordinates.

mod command;
mod names;

#[cfg(feature = "engine")]
mod chain;
#[cfg(feature = "engine")]
mod embedded;
#[cfg(feature = "engine")]
mod error;
#[cfg(feature = "engine")]
mod import;
#[cfg(feature = "engine")]
mod limits;
#[cfg(feature = "engine")]
mod loft;
#[cfg(feature = "engine")]
mod model;
#[cfg(feature = "engine")]
mod reading;

#[cfg(feature = "engine")]
pub use chain::{SIDE_DOF, SideChain, SideJacobian, SidePosture, palm_rotation};
pub use command::{ACTUATED_DOF, ARM_DOF, ARM_JOINTS, HAND_ACTUATORS, HAND_DOF, JointAngles};
#[cfg(feature = "engine")]
pub use embedded::embedded_mjcf;
#[cfg(feature = "engine")]
pub use error::RobotError;
#[cfg(feature = "engine")]
pub use import::{ImportError, ImportedRobot, RobotReport, check, default_robot, import};
#[cfg(feature = "engine")]
pub use limits::JointLimits;
#[cfg(feature = "engine")]
pub use model::{RobotAsset, RobotModel};
pub use names::{FINGERS, actuated_joint_names, tip_site};
