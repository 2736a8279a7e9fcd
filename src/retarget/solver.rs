//! Inverse kinematics of both arms and hands: Levenberg–Marquardt with box constraints.
//!
//! Residuals (weights in [`Weights`]): wrist position, split along and across the line of sight; wrist
//! orientation as rotation vector; wrist → fingertip vectors; thumb → finger vectors of pinches; posture;
//! inertia. Position and velocity limits are one box per joint, kept exactly in every iteration by an active
//! set. The sides share no joint, so the 26×26 normal equations are two blocks of 13.

use nalgebra::{Cholesky, Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};

use crate::{
    geometry::Side,
    robot::{JointAngles, RobotModel, SIDE_DOF, SideChain, SideJacobian, SidePosture},
};

use super::{params::Weights, target::SideTarget};

/// The 13 angles of a side, arm then hand, radians.
pub(super) type SideAngles = SVector<f64, SIDE_DOF>;
type Angles = SideAngles;
type Normal = SMatrix<f64, SIDE_DOF, SIDE_DOF>;

/// The comfortable left arm, radians: elbow low, forearm forward; the right one mirrors it.
const COMFORTABLE_ARM: [f64; 7] = [-0.1, 0.2, 0.0, 0.3, 0.0, 0.0, 0.0];

/// Solves one side; holds the scratch memory of one thread.
#[derive(Debug)]
pub(super) struct SideSolver<'r> {
    chain: &'r SideChain,
    weights: Weights,
    /// Position limits and the velocity limit for one frame, radians.
    pub lower: Angles,
    pub upper: Angles,
    pub step: Angles,
    comfortable: Angles,
    posture: SidePosture,
}

/// The angles that [`SideSolver::solve`] may take.
#[derive(Clone, Copy, Debug)]
pub(super) struct AngleBox {
    pub lower: Angles,
    pub upper: Angles,
}

/// What was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solution {
    pub angles: Angles,
    /// Half the sum of squared residuals.
    pub cost: f64,
}

impl<'r> SideSolver<'r> {
    pub fn new(robot: &'r RobotModel, side: Side, weights: Weights) -> Self {
        let limits = robot.limits();
        let pick = |all: &[f64; 26]| Angles::from(JointAngles(*all).side(side));
        let steps: [f64; 26] = std::array::from_fn(|joint| limits.step(joint));
        let mut comfortable = Angles::zeros();
        for (joint, angle) in COMFORTABLE_ARM.into_iter().enumerate() {
            // Joints about x and z mirror: roll and yaw.
            let mirrors = matches!(joint, 1 | 2 | 4 | 6) && side == Side::Right;
            comfortable[joint] = if mirrors { -angle } else { angle };
        }
        Self {
            chain: robot.chain(side),
            weights,
            lower: pick(&limits.lower),
            upper: pick(&limits.upper),
            step: pick(&steps),
            comfortable,
            posture: SidePosture::default(),
        }
    }

    /// The comfortable posture with open hands.
    pub fn comfortable(&self) -> Angles {
        self.comfortable
    }

    /// All angles inside the position limits.
    pub fn anywhere(&self) -> AngleBox {
        AngleBox { lower: self.lower, upper: self.upper }
    }

    /// The angles that one frame may lead to from `before`.
    pub fn reachable_from(&self, before: &Angles) -> AngleBox {
        AngleBox {
            lower: self.lower.sup(&(before - self.step)),
            upper: self.upper.inf(&(before + self.step)),
        }
    }

    /// The side at `angles`.
    pub fn pose(&mut self, angles: &Angles) -> &SidePosture {
        self.chain.pose(&(*angles).into(), &mut self.posture);
        &self.posture
    }

    /// Minimises the residuals from `start` inside `bounds`, at most `iterations` steps; `before` is what
    /// inertia holds on to.
    pub fn solve(
        &mut self,
        target: &SideTarget,
        start: &Angles,
        before: &Angles,
        bounds: &AngleBox,
        iterations: usize,
    ) -> Solution {
        let mut angles = start.sup(&bounds.lower).inf(&bounds.upper);
        let mut system = self.linearise(target, &angles, before);
        let mut damping = 1e-8;
        for _ in 0..iterations {
            let move_by = box_step(&system, damping, &angles, bounds);
            let longest = move_by.amax();
            if longest < 1e-10 {
                break;
            }
            // Far from the solution the model is only good for so much.
            let candidate = angles + move_by * (0.6 / longest).min(1.0);
            let candidate = candidate.sup(&bounds.lower).inf(&bounds.upper);
            let next = self.linearise(target, &candidate, before);
            if next.cost < system.cost {
                let gained = system.cost - next.cost;
                angles = candidate;
                damping = (damping * 0.1).max(1e-8);
                let done = gained < 1e-9 * system.cost + 1e-18;
                system = next;
                if done {
                    break;
                }
            } else {
                damping = (damping * 30.0).max(1e-4);
                if damping > 1e6 {
                    break;
                }
            }
        }
        Solution { angles, cost: system.cost }
    }

    fn linearise(&mut self, target: &SideTarget, angles: &Angles, before: &Angles) -> System {
        self.chain.pose(&(*angles).into(), &mut self.posture);
        let (chain, posture, weights) = (self.chain, &self.posture, &self.weights);
        let mut system = System::default();

        let along = target.sight * target.sight.transpose();
        let across = Matrix3::identity() - along;
        let metric = weights.position * (across + along * weights.along_sight);
        let wrist_jacobian = chain.wrist_jacobian(posture);
        let error = posture.wrist - target.wrist.position().xyz;
        system.add(&(metric * wrist_jacobian), &(metric * error));

        let turn = rotation_error(&target.wrist.rotation(), &posture.wrist_rotation);
        let jacobian = chain.wrist_rotation_jacobian(posture) * weights.rotation;
        system.add(&jacobian, &(turn * weights.rotation));

        if let Some(hand) = &target.hand {
            let tips: [SideJacobian; 5] = std::array::from_fn(|finger| chain.tip_jacobian(posture, finger));
            for (finger, tip) in tips.iter().enumerate() {
                let error = posture.tips[finger] - posture.wrist - hand.tips[finger];
                let jacobian = (tip - wrist_jacobian) * weights.fingertip;
                system.add(&jacobian, &(error * weights.fingertip));
            }
            for (finger, pinch) in hand.pinches.iter().enumerate() {
                if pinch.strength > 1e-3 {
                    let weight = weights.pinch * pinch.strength;
                    let error = posture.tips[finger + 1] - posture.tips[0] - pinch.gap;
                    system.add(&((tips[finger + 1] - tips[0]) * weight), &(error * weight));
                }
            }
        }

        let mut posture_weight = Angles::zeros();
        for joint in 0..7 {
            posture_weight[joint] = weights.posture.powi(2);
        }
        system.pull(&posture_weight, &(angles - self.comfortable));
        system.pull(&Angles::repeat(weights.inertia.powi(2)), &(angles - before));
        system
    }
}

/// The rotation vector in torso axes that takes `wanted` to `found`.
pub(super) fn rotation_error(wanted: &UnitQuaternion<f64>, found: &UnitQuaternion<f64>) -> Vector3<f64> {
    (found * wanted.inverse()).scaled_axis()
}

/// Gauss–Newton normal equations.
#[derive(Clone, Copy, Debug)]
pub(super) struct System {
    normal: Normal,
    pub gradient: Angles,
    /// Half the sum of squared residuals.
    pub cost: f64,
}

impl Default for System {
    fn default() -> Self {
        Self { normal: Normal::zeros(), gradient: Angles::zeros(), cost: 0.0 }
    }
}

impl System {
    /// A residual with its Jacobian, both weighted.
    pub fn add(&mut self, jacobian: &SideJacobian, residual: &Vector3<f64>) {
        self.normal += jacobian.transpose() * jacobian;
        self.gradient += jacobian.transpose() * residual;
        self.cost += 0.5 * residual.norm_squared();
    }

    /// Adds `damping` to the diagonal: a penalty on the length of the step, radians.
    pub fn damp(&mut self, damping: f64) {
        for joint in 0..SIDE_DOF {
            self.normal[(joint, joint)] += damping;
        }
    }

    /// ½ Σ `weight` · `offset`², where the offset's Jacobian is the identity.
    pub fn pull(&mut self, weight: &Angles, offset: &Angles) {
        for joint in 0..SIDE_DOF {
            self.normal[(joint, joint)] += weight[joint];
            self.gradient[joint] += weight[joint] * offset[joint];
            self.cost += 0.5 * weight[joint] * offset[joint].powi(2);
        }
    }
}

/// The damped step inside `bounds`: joints that would leave are held at their bound and the others solved
/// again, until none leaves.
pub(super) fn box_step(system: &System, damping: f64, angles: &Angles, bounds: &AngleBox) -> Angles {
    let mut held: [Option<f64>; SIDE_DOF] = [None; SIDE_DOF];
    for joint in 0..SIDE_DOF {
        // At a bound and pushed outwards: holding it from the start saves a round.
        let out = system.gradient[joint] > 0.0 && angles[joint] <= bounds.lower[joint]
            || system.gradient[joint] < 0.0 && angles[joint] >= bounds.upper[joint];
        if out || bounds.upper[joint] <= bounds.lower[joint] {
            held[joint] = Some(0.0);
        }
    }
    let mut step = Angles::zeros();
    for _ in 0..SIDE_DOF {
        step = match masked_solve(system, damping, &held) {
            Some(step) => step,
            None => return Angles::zeros(),
        };
        let mut leaves = false;
        for joint in 0..SIDE_DOF {
            if held[joint].is_some() {
                continue;
            }
            let (low, high) = (bounds.lower[joint] - angles[joint], bounds.upper[joint] - angles[joint]);
            if step[joint] < low - 1e-12 || step[joint] > high + 1e-12 {
                held[joint] = Some(step[joint].clamp(low.min(0.0), high.max(0.0)));
                leaves = true;
            }
        }
        if !leaves {
            break;
        }
    }
    step
}

fn masked_solve(system: &System, damping: f64, held: &[Option<f64>; SIDE_DOF]) -> Option<Angles> {
    let mut matrix = system.normal;
    let mut right = -system.gradient;
    for joint in 0..SIDE_DOF {
        matrix[(joint, joint)] += damping * (1.0 + matrix[(joint, joint)]);
    }
    for (joint, value) in held.iter().enumerate() {
        let Some(value) = value else { continue };
        if *value != 0.0 {
            right -= system.normal.column(joint) * *value;
        }
    }
    for (joint, value) in held.iter().enumerate() {
        let Some(value) = value else { continue };
        matrix.row_mut(joint).fill(0.0);
        matrix.column_mut(joint).fill(0.0);
        matrix[(joint, joint)] = 1.0;
        right[joint] = *value;
    }
    Some(Cholesky::new(matrix)?.solve(&right))
}
