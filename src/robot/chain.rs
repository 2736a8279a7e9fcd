//! Forward kinematics and Jacobians of one arm with its hand, from `torso_link` to the fingertips.
//!
//! The chain is read once from the compiled MuJoCo model and evaluated in reduced coordinates: 13 actuated
//! angles a side, the coupled finger joints following theirs. `tests/robot_kinematics.rs` holds it against
//! MuJoCo's own kinematics. Evaluating it costs about two microseconds and needs no simulation state, so any
//! number of threads share one model, each with a [`SidePosture`] of its own.

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use crate::geometry::{Pose, Position, Torso};

/// Actuated joints of one side: 7 of the arm, then 6 of the hand.
pub const SIDE_DOF: usize = 13;

/// A moving body.
#[derive(Clone, Debug)]
pub(super) struct ChainLink {
    /// The link it hangs on; `None` for `torso_link`.
    pub parent: Option<usize>,
    /// Its pose in the parent at zero angle.
    pub offset: Isometry3<f64>,
    /// The joint that moves it.
    pub joint: ChainJoint,
}

/// A hinge: angle = gain × actuated angle + bias.
#[derive(Clone, Debug)]
pub(super) struct ChainJoint {
    /// Which of the side's 13 actuated angles moves it.
    pub coordinate: usize,
    pub gain: f64,
    pub bias: f64,
    /// Unit axis in the link's frame.
    pub axis: Vector3<f64>,
    /// A point of the axis in the link's frame, metres.
    pub anchor: Vector3<f64>,
}

/// A point that moves with a link.
#[derive(Clone, Debug)]
pub(super) struct ChainPoint {
    pub link: usize,
    pub local: Vector3<f64>,
}

/// One arm with its hand.
#[derive(Clone, Debug)]
pub struct SideChain {
    pub(super) links: Vec<ChainLink>,
    /// Origin of `{side}_base_link` on the link of the wrist.
    pub(super) wrist: ChainPoint,
    /// `{side}_wrist_yaw_link` relative to the link of the wrist.
    pub(super) wrist_rotation: UnitQuaternion<f64>,
    /// Fingertips, thumb to pinky.
    pub(super) tips: [ChainPoint; 5],
    /// Origins of the finger bases (thumb metacarpal, then the proximal joints).
    pub(super) bases: [ChainPoint; 5],
}

/// One side at given angles, all in `torso_link`, metres.
#[derive(Clone, Debug, Default)]
pub struct SidePosture {
    links: Vec<Isometry3<f64>>,
    axes: Vec<Vector3<f64>>,
    anchors: Vec<Vector3<f64>>,
    /// Wrist position (origin of `{side}_base_link`).
    pub wrist: Vector3<f64>,
    /// Wrist rotation (axes of `{side}_wrist_yaw_link`).
    pub wrist_rotation: UnitQuaternion<f64>,
    /// Fingertips, thumb to pinky.
    pub tips: [Vector3<f64>; 5],
}

/// A 3×13 Jacobian: columns are metres (or radians) per radian of each actuated joint of the side.
pub type SideJacobian = nalgebra::SMatrix<f64, 3, SIDE_DOF>;

impl SidePosture {
    /// The wrist frame of the record: origin of `{side}_base_link`, axes of `{side}_wrist_yaw_link`.
    pub fn wrist_pose(&self) -> Pose<Torso> {
        Pose::from_parts(Position::new(self.wrist), self.wrist_rotation)
    }

    /// Fingertips as typed positions, thumb to pinky.
    pub fn fingertips(&self) -> [Position<Torso>; 5] {
        self.tips.map(Position::new)
    }
}

impl SideChain {
    /// Evaluates the chain at `angles` (radians, the side's arm then hand) into `posture`.
    pub fn pose(&self, angles: &[f64; SIDE_DOF], posture: &mut SidePosture) {
        posture.links.clear();
        posture.axes.clear();
        posture.anchors.clear();
        for link in &self.links {
            let rest = link.parent.map_or(link.offset, |parent| posture.links[parent] * link.offset);
            let joint = &link.joint;
            let angle = joint.gain * angles[joint.coordinate] + joint.bias;
            let turn = UnitQuaternion::new_unchecked(half_turn(&joint.axis, angle));
            let anchor = rest * nalgebra::Point3::from(joint.anchor);
            let rotation = rest.rotation * turn;
            let origin = anchor.coords - rotation * joint.anchor;
            posture.axes.push(rest.rotation * joint.axis);
            posture.anchors.push(anchor.coords);
            posture.links.push(Isometry3::from_parts(Translation3::from(origin), rotation));
        }
        posture.wrist = at(posture, &self.wrist);
        posture.wrist_rotation = posture.links[self.wrist.link].rotation * self.wrist_rotation;
        for finger in 0..5 {
            posture.tips[finger] = at(posture, &self.tips[finger]);
        }
    }

    /// Jacobian of the wrist position.
    pub fn wrist_jacobian(&self, posture: &SidePosture) -> SideJacobian {
        self.point_jacobian(posture, self.wrist.link, &posture.wrist)
    }

    /// Jacobian of the wrist rotation: angular velocity in the torso frame.
    pub fn wrist_rotation_jacobian(&self, posture: &SidePosture) -> SideJacobian {
        let mut jacobian = SideJacobian::zeros();
        self.for_ancestors(self.wrist.link, |link, joint| {
            let mut column = jacobian.column_mut(joint.coordinate);
            column += joint.gain * posture.axes[link];
        });
        jacobian
    }

    /// Jacobian of fingertip `finger` (0 thumb to 4 pinky).
    pub fn tip_jacobian(&self, posture: &SidePosture, finger: usize) -> SideJacobian {
        self.point_jacobian(posture, self.tips[finger].link, &posture.tips[finger])
    }

    /// The palm frame relative to the wrist frame: x from the wrist to the base of the middle finger, z across
    /// the palm from the pinky's base to the index's, y = z × x. Constant, since the palm does not bend.
    pub fn palm_in_wrist(&self) -> UnitQuaternion<f64> {
        let mut posture = SidePosture::default();
        self.pose(&[0.0; SIDE_DOF], &mut posture);
        let base = |finger: usize| at(&posture, &self.bases[finger]);
        palm_rotation(posture.wrist, base(1), base(2), base(4))
            .map_or_else(UnitQuaternion::identity, |palm| posture.wrist_rotation.inverse() * palm)
    }

    /// Bases of the fingers in the palm frame (origin at the wrist), thumb to pinky, metres.
    pub fn bases_in_palm(&self) -> [Vector3<f64>; 5] {
        self.in_palm(&self.bases)
    }

    /// Tips of the open hand (all hand angles at zero) in the palm frame, thumb to pinky, metres.
    pub fn open_tips_in_palm(&self) -> [Vector3<f64>; 5] {
        self.in_palm(&self.tips)
    }

    /// Length of each finger along its links from base to tip, thumb to pinky, metres.
    pub fn finger_lengths(&self) -> [f64; 5] {
        std::array::from_fn(|finger| {
            let mut length = self.tips[finger].local.norm();
            let mut link = self.tips[finger].link;
            while link != self.bases[finger].link {
                length += self.links[link].offset.translation.vector.norm();
                match self.links[link].parent {
                    Some(parent) => link = parent,
                    None => break,
                }
            }
            length
        })
    }

    fn in_palm(&self, points: &[ChainPoint; 5]) -> [Vector3<f64>; 5] {
        let mut posture = SidePosture::default();
        self.pose(&[0.0; SIDE_DOF], &mut posture);
        let to_palm = (posture.wrist_rotation * self.palm_in_wrist()).inverse();
        std::array::from_fn(|finger| to_palm * (at(&posture, &points[finger]) - posture.wrist))
    }

    fn point_jacobian(&self, posture: &SidePosture, link: usize, point: &Vector3<f64>) -> SideJacobian {
        let mut jacobian = SideJacobian::zeros();
        self.for_ancestors(link, |link, joint| {
            let lever = point - posture.anchors[link];
            let mut column = jacobian.column_mut(joint.coordinate);
            column += joint.gain * posture.axes[link].cross(&lever);
        });
        jacobian
    }

    fn for_ancestors(&self, link: usize, mut visit: impl FnMut(usize, &ChainJoint)) {
        let mut current = Some(link);
        while let Some(index) = current {
            visit(index, &self.links[index].joint);
            current = self.links[index].parent;
        }
    }
}

/// The palm frame of four points: x = wrist → middle base, z = pinky base → index base made orthogonal to x,
/// y = z × x. `None` when the points do not span a plane.
pub fn palm_rotation(
    wrist: Vector3<f64>,
    index: Vector3<f64>,
    middle: Vector3<f64>,
    pinky: Vector3<f64>,
) -> Option<UnitQuaternion<f64>> {
    let x = (middle - wrist).try_normalize(1e-6)?;
    let across = index - pinky;
    let z = (across - x * x.dot(&across)).try_normalize(1e-6)?;
    let matrix = Matrix3::from_columns(&[x, z.cross(&x), z]);
    Some(UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(matrix)))
}

fn half_turn(axis: &Vector3<f64>, angle: f64) -> nalgebra::Quaternion<f64> {
    let (sin, cos) = (0.5 * angle).sin_cos();
    nalgebra::Quaternion::from_parts(cos, axis * sin)
}

fn at(posture: &SidePosture, point: &ChainPoint) -> Vector3<f64> {
    (posture.links[point.link] * nalgebra::Point3::from(point.local)).coords
}
