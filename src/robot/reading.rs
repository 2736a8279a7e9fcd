//! Reads chains, couplings and limits out of a compiled MuJoCo model.

use mujoco_rs::prelude::*;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::geometry::Side;

use super::{
    ACTUATED_DOF, JointAngles, JointLimits, RobotError, SideChain,
    chain::{ChainJoint, ChainLink, ChainPoint, SIDE_DOF},
    names,
};

/// A model joint that follows an actuated one: angle = gain × actuated + bias.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coupling {
    pub joint: usize,
    pub actuated: usize,
    pub gain: f64,
    pub bias: f64,
}

/// A compiled model with what of it is moved by the 26 actuated joints.
pub(super) struct Reading<'m> {
    model: &'m MjModel,
    /// By model joint; `None` where a joint stays at its zero (waist, legs).
    couplings: Vec<Option<Coupling>>,
    torso: usize,
}

impl<'m> Reading<'m> {
    pub fn new(model: &'m MjModel) -> Result<Self, RobotError> {
        let mut couplings = vec![None; model.jnt_type().len()];
        for (actuated, name) in names::actuated_joint_names().iter().enumerate() {
            let joint = find(model, MjtObjBase::mjOBJ_JOINT, "joint", name)?;
            couplings[joint] = Some(Coupling { joint, actuated, gain: 1.0, bias: 0.0 });
        }
        let actuated = couplings.clone();
        for (index, kind) in model.eq_type().iter().enumerate() {
            let (follower, leader) = (model.eq_obj1id()[index], model.eq_obj2id()[index]);
            if *kind != MjtEq::mjEQ_JOINT || follower < 0 || leader < 0 {
                continue;
            }
            let data = model.eq_data()[index];
            let follower = follower as usize;
            if let (None, Some(lead)) = (actuated[follower], actuated[leader as usize]) {
                couplings[follower] =
                    Some(Coupling { joint: follower, actuated: lead.actuated, gain: data[1], bias: data[0] });
            }
        }
        let torso = find(model, MjtObjBase::mjOBJ_BODY, "body", "torso_link")?;
        Ok(Self { model, couplings, torso })
    }

    /// Every moved joint.
    pub fn couplings(&self) -> impl Iterator<Item = Coupling> + '_ {
        self.couplings.iter().copied().flatten()
    }

    pub fn limits(&self) -> Result<JointLimits, RobotError> {
        let mut limits = JointLimits {
            lower: [f64::NEG_INFINITY; ACTUATED_DOF],
            upper: [f64::INFINITY; ACTUATED_DOF],
            velocity: [0.0; ACTUATED_DOF],
        };
        for coupling in self.couplings() {
            let [low, high] = self.model.jnt_range()[coupling.joint];
            let bounds = [low, high].map(|bound| (bound - coupling.bias) / coupling.gain);
            let actuated = coupling.actuated;
            limits.lower[actuated] = limits.lower[actuated].max(bounds[0].min(bounds[1]));
            limits.upper[actuated] = limits.upper[actuated].min(bounds[0].max(bounds[1]));
        }
        for (index, joint) in names::actuated_joint_names().into_iter().enumerate() {
            let (lower, upper) = (limits.lower[index], limits.upper[index]);
            if !(lower.is_finite() && upper.is_finite() && lower < upper) {
                return Err(RobotError::Limits { joint, lower, upper });
            }
            limits.velocity[index] = self.velocity(index, &joint);
        }
        Ok(limits)
    }

    /// The first user number of a joint, where the description has one; the table of the real robot otherwise.
    fn velocity(&self, actuated: usize, joint: &str) -> f64 {
        let user = self.model.ffi().nuser_jnt as usize;
        let id = self.model.name_to_id(MjtObjBase::mjOBJ_JOINT, joint);
        let written = id.filter(|_| user > 0).and_then(|id| self.model.jnt_user().get(id * user)).copied();
        let slot = if actuated < 14 { actuated % 7 } else { 7 + (actuated - 14) % 6 };
        written.filter(|v| v.is_finite() && *v > 0.0).unwrap_or(names::DEFAULT_VELOCITY[slot])
    }

    pub fn chain(&self, side: Side) -> Result<SideChain, RobotError> {
        let mut builder =
            Builder { reading: self, side, links: Vec::new(), link_of_body: Default::default() };
        let base = self.body(&format!("{}_base_link", side.name()))?;
        let yaw = self.body(&format!("{}_wrist_yaw_link", side.name()))?;
        let (wrist_link, base_pose) = builder.resolve_moving(base)?;
        let (yaw_link, yaw_pose) = builder.resolve_moving(yaw)?;
        if wrist_link != yaw_link {
            return Err(RobotError::Detached(format!("{}_base_link", side.name())));
        }
        let mut tips = Vec::with_capacity(5);
        let mut bases = Vec::with_capacity(5);
        for finger in 0..5 {
            let site = find(self.model, MjtObjBase::mjOBJ_SITE, "site", &names::tip_site(side, finger))?;
            let (link, pose) = builder.resolve_moving(self.model.site_bodyid()[site] as usize)?;
            let local = pose * nalgebra::Point3::from(Vector3::from(self.model.site_pos()[site]));
            tips.push(ChainPoint { link, local: local.coords });
            let joint = find(self.model, MjtObjBase::mjOBJ_JOINT, "joint", &names::base_joint(side, finger))?;
            let (link, _) = builder.resolve_moving(self.model.jnt_bodyid()[joint] as usize)?;
            bases.push(ChainPoint { link, local: Vector3::from(self.model.jnt_pos()[joint]) });
        }
        let five = |points: Vec<ChainPoint>| {
            <[ChainPoint; 5]>::try_from(points).map_err(|_| RobotError::Embedded("five fingers".to_owned()))
        };
        Ok(SideChain {
            wrist: ChainPoint { link: wrist_link, local: base_pose.translation.vector },
            wrist_rotation: yaw_pose.rotation,
            tips: five(tips)?,
            bases: five(bases)?,
            links: builder.links,
        })
    }

    fn body(&self, name: &str) -> Result<usize, RobotError> {
        find(self.model, MjtObjBase::mjOBJ_BODY, "body", name)
    }

    fn body_name(&self, body: usize) -> String {
        self.model.id_to_name(MjtObjBase::mjOBJ_BODY, body).unwrap_or("(unnamed)").to_owned()
    }

    fn joint_name(&self, joint: usize) -> String {
        self.model.id_to_name(MjtObjBase::mjOBJ_JOINT, joint).unwrap_or("(unnamed)").to_owned()
    }
}

/// Collects the links of one side, parents before children.
struct Builder<'r, 'm> {
    reading: &'r Reading<'m>,
    side: Side,
    links: Vec<ChainLink>,
    link_of_body: std::collections::BTreeMap<usize, Option<usize>>,
}

impl Builder<'_, '_> {
    fn resolve_moving(&mut self, body: usize) -> Result<(usize, Isometry3<f64>), RobotError> {
        let (link, pose) = self.resolve(body)?;
        Ok((link.ok_or_else(|| RobotError::Detached(self.reading.body_name(body)))?, pose))
    }

    /// The link a body moves with and the body's pose in it; the torso is no link.
    fn resolve(&mut self, body: usize) -> Result<(Option<usize>, Isometry3<f64>), RobotError> {
        let model = self.reading.model;
        if body == self.reading.torso {
            return Ok((None, Isometry3::identity()));
        }
        if let Some(&link) = self.link_of_body.get(&body) {
            return Ok((link, Isometry3::identity()));
        }
        if body == 0 {
            return Err(RobotError::Detached("world".to_owned()));
        }
        let (mut link, parent_pose) = self.resolve(model.body_parentid()[body] as usize)?;
        let mut pose = parent_pose * body_pose(model, body);
        for joint in (0..model.jnt_type().len()).filter(|&joint| model.jnt_bodyid()[joint] as usize == body) {
            let Some(coupling) = self.reading.couplings[joint] else { continue };
            if model.jnt_type()[joint] != MjtJoint::mjJNT_HINGE {
                return Err(RobotError::NotHinge(self.reading.joint_name(joint)));
            }
            let Some(coordinate) = side_coordinate(coupling.actuated, self.side) else { continue };
            self.links.push(ChainLink {
                parent: link,
                offset: pose,
                joint: ChainJoint {
                    coordinate,
                    gain: coupling.gain,
                    bias: coupling.bias,
                    axis: Vector3::from(model.jnt_axis()[joint]).normalize(),
                    anchor: Vector3::from(model.jnt_pos()[joint]),
                },
            });
            link = Some(self.links.len() - 1);
            pose = Isometry3::identity();
            self.link_of_body.insert(body, link);
        }
        Ok((link, pose))
    }
}

/// Where actuated joint `actuated` sits among the 13 angles of `side`.
fn side_coordinate(actuated: usize, side: Side) -> Option<usize> {
    let (arm, hand) = (JointAngles::arm_start(side), JointAngles::hand_start(side));
    if (arm..arm + 7).contains(&actuated) {
        Some(actuated - arm)
    } else if (hand..hand + (SIDE_DOF - 7)).contains(&actuated) {
        Some(7 + actuated - hand)
    } else {
        None
    }
}

fn body_pose(model: &MjModel, body: usize) -> Isometry3<f64> {
    let [w, x, y, z] = model.body_quat()[body];
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(Vector3::from(model.body_pos()[body])), rotation)
}

fn find(model: &MjModel, object: MjtObjBase, kind: &'static str, name: &str) -> Result<usize, RobotError> {
    model.name_to_id(object, name).ok_or_else(|| RobotError::Missing { kind, name: name.to_owned() })
}
