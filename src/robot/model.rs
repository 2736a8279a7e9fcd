//! The robot: a compiled MuJoCo model spoken to in 26 actuated angles.

use std::sync::Arc;

use mujoco_rs::{prelude::*, wrappers::mj_auxiliary::MjVfs};

use crate::{
    geometry::{PerSide, Pose, Position, Side, Torso},
    mujoco::compile_alone,
};

use super::{
    ACTUATED_DOF, JointAngles, JointLimits, RobotError, SideChain, SidePosture,
    chain::SIDE_DOF,
    embedded::embedded_mjcf,
    names,
    reading::{Coupling, Reading},
};

/// A file that a description refers to, handed over in memory.
#[derive(Clone, Debug)]
pub struct RobotAsset {
    /// File name as the description spells it.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// A Unitree G1 with BrainCo hands, from the embedded model or from a user's own copy.
///
/// Reduced coordinates: all model joints follow the 26 actuated angles (`q = A · q_act`); waist and legs stay
/// at zero. Cheap to clone and shared between threads; state lives in [`SidePosture`] or in a `MjData` of the
/// caller's own.
#[derive(Clone)]
pub struct RobotModel {
    mjcf: Arc<str>,
    model: Arc<MjModel>,
    limits: JointLimits,
    couplings: Vec<(usize, Coupling)>,
    chains: PerSide<Arc<SideChain>>,
}

impl std::fmt::Debug for RobotModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RobotModel").field("limits", &self.limits).finish_non_exhaustive()
    }
}

impl RobotModel {
    /// The model the tool ships.
    ///
    /// # Errors
    /// Only when the embedded files are broken, which the tests exclude.
    pub fn embedded() -> Result<Self, RobotError> {
        Self::from_mjcf(embedded_mjcf()?, &[])
    }

    /// A model from an MJCF or URDF document and the files it names.
    ///
    /// Velocity limits are the first `user` number of each joint; where a description has none, the real
    /// robot's are taken.
    ///
    /// # Errors
    /// When MuJoCo refuses the description, or joints, bodies or fingertip sites of the G1 with BrainCo hands
    /// are missing, or a limit is no interval.
    pub fn from_mjcf(mjcf: impl Into<Arc<str>>, assets: &[RobotAsset]) -> Result<Self, RobotError> {
        let mjcf = mjcf.into();
        let model = compile(&mjcf, assets)?;
        let reading = Reading::new(&model)?;
        let limits = reading.limits()?;
        let couplings = reading.couplings().map(|c| (model.jnt_qposadr()[c.joint] as usize, c)).collect();
        let chains = PerSide {
            left: Arc::new(reading.chain(Side::Left)?),
            right: Arc::new(reading.chain(Side::Right)?),
        };
        Ok(Self { mjcf, model: Arc::new(model), limits, couplings, chains })
    }

    /// The description the model was made from: one MJCF document, for scenes that put more around the robot.
    pub fn mjcf(&self) -> &str {
        &self.mjcf
    }

    /// The compiled model; share it with `MjData::new(robot.mujoco().clone())`.
    pub fn mujoco(&self) -> &Arc<MjModel> {
        &self.model
    }

    /// Limits of the 26 actuated joints.
    pub fn limits(&self) -> &JointLimits {
        &self.limits
    }

    /// Names of the 26 actuated joints, in the record's order.
    pub fn joint_names(&self) -> [String; ACTUATED_DOF] {
        names::actuated_joint_names()
    }

    /// Kinematics of one side.
    pub fn chain(&self, side: Side) -> &SideChain {
        &self.chains[side]
    }

    /// Writes the model's `qpos` (radians, length `nq`) for `angles`: `q = A · q_act`. Joints that nothing
    /// drives are left as they are.
    ///
    /// # Panics
    /// When `qpos` is shorter than the model's `nq`.
    pub fn write_qpos(&self, angles: &JointAngles, qpos: &mut [f64]) {
        for (address, coupling) in &self.couplings {
            qpos[*address] = coupling.gain * angles.0[coupling.actuated] + coupling.bias;
        }
    }

    /// The model's `qpos` for `angles`, everything undriven at zero.
    pub fn qpos(&self, angles: &JointAngles) -> Vec<f64> {
        let mut qpos = self.model.qpos0().to_vec();
        self.write_qpos(angles, &mut qpos);
        qpos
    }

    /// One side at `angles`.
    pub fn posture(&self, side: Side, angles: &JointAngles) -> SidePosture {
        let mut posture = SidePosture::default();
        self.chain(side).pose(&angles.side(side), &mut posture);
        posture
    }

    /// The wrist frame (origin of `{side}_base_link`, axes of `{side}_wrist_yaw_link`) in `torso_link`.
    pub fn wrist(&self, side: Side, angles: &JointAngles) -> Pose<Torso> {
        self.posture(side, angles).wrist_pose()
    }

    /// Fingertips in `torso_link`, thumb to pinky.
    pub fn fingertips(&self, side: Side, angles: &JointAngles) -> [Position<Torso>; 5] {
        self.posture(side, angles).fingertips()
    }
}

impl JointAngles {
    /// The 13 angles of one side, arm then hand.
    pub fn side(&self, side: Side) -> [f64; SIDE_DOF] {
        let (arm, hand) = (Self::arm_start(side), Self::hand_start(side));
        std::array::from_fn(|i| if i < 7 { self.0[arm + i] } else { self.0[hand + i - 7] })
    }

    /// Sets the 13 angles of one side, arm then hand.
    pub fn set_side(&mut self, side: Side, angles: &[f64; SIDE_DOF]) {
        let (arm, hand) = (Self::arm_start(side), Self::hand_start(side));
        self.0[arm..arm + 7].copy_from_slice(&angles[..7]);
        self.0[hand..hand + 6].copy_from_slice(&angles[7..]);
    }
}

fn compile(mjcf: &str, assets: &[RobotAsset]) -> Result<MjModel, RobotError> {
    const DOCUMENT: &str = "robot.xml";
    let mut files = MjVfs::new();
    let mut add = |name: &str, bytes: &[u8]| {
        files
            .add_from_buffer(name, bytes)
            .map_err(|error| RobotError::Asset { name: name.to_owned(), reason: error.to_string() })
    };
    add(DOCUMENT, mjcf.as_bytes())?;
    for asset in assets {
        // The bindings panic on an interior NUL.
        if asset.name.contains('\0') {
            return Err(RobotError::Asset { name: asset.name.clone(), reason: "NUL in the name".to_owned() });
        }
        add(&asset.name, &asset.bytes)?;
    }
    compile_alone(|| MjModel::from_xml_vfs(DOCUMENT, &files))
        .map_err(|error| RobotError::Compile(error.to_string()))
}
