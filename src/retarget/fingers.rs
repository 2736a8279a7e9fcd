//! The fingers over a whole run at once.
//!
//! A finger of the robot needs 0.65 s to close. Frame by frame it comes late for every quick pinch, and smoothing
//! afterwards opens it again; over the run it sets out in time. Minimised are the solver's own residuals of
//! fingertips and pinches, and the joints' second differences, with arms as they are.

use nalgebra::SVector;

use crate::robot::{SIDE_DOF, SideChain, SideJacobian, SidePosture};

use super::{banded::Banded, params::Weights, solver::SideSolver, target::SideTarget};

type Angles = SVector<f64, SIDE_DOF>;

/// Joints of a hand, and where they start among a side's.
const JOINTS: usize = 6;
const FIRST: usize = 7;
/// Weight of a second difference of a joint at α = 0.5, per radian.
const SMOOTHNESS: f64 = 3.0;
/// Weight of what a joint moves beyond its velocity limit in a frame, per radian; the limit is kept exactly
/// afterwards.
const LIMIT: f64 = 20.0;
/// Share of the velocity limit that is planned with.
const PLANNED: f64 = 0.97;
/// Gauss–Newton steps at most; half a dozen are usual.
const STEPS: usize = 40;

/// Refines the fingers of one side.
#[derive(Debug)]
pub(super) struct FingerRun<'a> {
    chain: &'a SideChain,
    weights: Weights,
    lower: Angles,
    upper: Angles,
    step: Angles,
    smoothness: f64,
}

/// Normal equations over all frames and joints.
struct Linear {
    normal: Banded,
    gradient: Vec<f64>,
    cost: f64,
}

impl<'a> FingerRun<'a> {
    /// With the limits of `solver`; a smaller `alpha` smooths more.
    pub fn new(chain: &'a SideChain, solver: &SideSolver<'_>, weights: Weights, alpha: f64) -> Self {
        Self {
            chain,
            weights,
            lower: solver.lower,
            upper: solver.upper,
            step: solver.step,
            smoothness: SMOOTHNESS * (1.0 - alpha) / alpha,
        }
    }

    /// Moves the hand joints of `angles`, one a frame and target, to where the whole run costs least.
    pub fn refine(&self, targets: &[SideTarget], angles: &mut [Angles]) {
        let mut system = self.linearise(targets, angles);
        let mut damping = 1e-6;
        for _ in 0..STEPS {
            let Some(candidate) = self.stepped(&system, angles, damping) else { return };
            let next = self.linearise(targets, &candidate);
            if next.cost < system.cost {
                let done = system.cost - next.cost < 1e-4 * system.cost;
                angles.copy_from_slice(&candidate);
                system = next;
                damping = (damping * 0.2).max(1e-6);
                if done {
                    return;
                }
            } else {
                damping = (damping * 20.0).max(1e-3);
                if damping > 1e6 {
                    return;
                }
            }
        }
    }

    fn stepped(&self, system: &Linear, angles: &[Angles], damping: f64) -> Option<Vec<Angles>> {
        let size = system.gradient.len();
        let mut normal = system.normal.clone();
        let mut step: Vec<f64> = system.gradient.iter().map(|slope| -slope).collect();
        for (index, slope) in system.gradient.iter().enumerate() {
            let (frame, joint) = (index / JOINTS, FIRST + index % JOINTS);
            let angle = angles[frame][joint];
            let out =
                *slope > 0.0 && angle <= self.lower[joint] || *slope < 0.0 && angle >= self.upper[joint];
            if out {
                normal.hold(index, size);
                step[index] = 0.0;
            }
        }
        if !normal.solve(damping, &mut step) {
            return None;
        }
        let mut candidate = angles.to_vec();
        for (index, by) in step.into_iter().enumerate() {
            let (frame, joint) = (index / JOINTS, FIRST + index % JOINTS);
            let moved = candidate[frame][joint] + by.clamp(-0.4, 0.4);
            candidate[frame][joint] = moved.clamp(self.lower[joint], self.upper[joint]);
        }
        Some(candidate)
    }

    fn linearise(&self, targets: &[SideTarget], angles: &[Angles]) -> Linear {
        let size = angles.len() * JOINTS;
        let mut system =
            Linear { normal: Banded::zeros(size, 3 * JOINTS - 1), gradient: vec![0.0; size], cost: 0.0 };
        let mut posture = SidePosture::default();
        for (frame, (target, angles)) in targets.iter().zip(angles).enumerate() {
            self.chain.pose(&(*angles).into(), &mut posture);
            self.add_hand(&mut system, frame, target, &posture);
        }
        for joint in 0..JOINTS {
            let at = |frame: usize| frame * JOINTS + joint;
            let angle = |frame: usize| angles[frame][FIRST + joint];
            for frame in 1..angles.len().saturating_sub(1) {
                let bend = angle(frame + 1) - 2.0 * angle(frame) + angle(frame - 1);
                let terms = [(at(frame - 1), 1.0), (at(frame), -2.0), (at(frame + 1), 1.0)];
                system.add(&terms, bend, self.smoothness.powi(2));
            }
            for frame in 1..angles.len() {
                let moved = angle(frame) - angle(frame - 1);
                let beyond = moved.abs() - PLANNED * self.step[FIRST + joint];
                if beyond > 0.0 {
                    let terms = [(at(frame - 1), -1.0), (at(frame), 1.0)];
                    system.add(&terms, beyond * moved.signum(), LIMIT.powi(2));
                }
            }
        }
        system
    }

    fn add_hand(&self, system: &mut Linear, frame: usize, target: &SideTarget, posture: &SidePosture) {
        let Some(hand) = &target.hand else { return };
        let tips: [SideJacobian; 5] = std::array::from_fn(|finger| self.chain.tip_jacobian(posture, finger));
        let mut add = |jacobian: &SideJacobian, residual: &nalgebra::Vector3<f64>, weight: f64| {
            for axis in 0..3 {
                let terms: [(usize, f64); JOINTS] =
                    std::array::from_fn(|joint| (frame * JOINTS + joint, jacobian[(axis, FIRST + joint)]));
                system.add(&terms, residual[axis], weight * weight);
            }
        };
        for (finger, tip) in tips.iter().enumerate() {
            let error = posture.tips[finger] - posture.wrist - hand.tips[finger];
            add(tip, &error, self.weights.fingertip);
        }
        for (finger, pinch) in hand.pinches.iter().enumerate().filter(|(_, pinch)| pinch.strength > 1e-3) {
            let error = posture.tips[finger + 1] - posture.tips[0] - pinch.gap;
            add(&(tips[finger + 1] - tips[0]), &error, self.weights.pinch * pinch.strength);
        }
    }
}

impl Linear {
    /// ½ · `weight` · `residual`² whose derivatives are `terms` (variable, slope), variables ascending.
    fn add(&mut self, terms: &[(usize, f64)], residual: f64, weight: f64) {
        self.cost += 0.5 * weight * residual * residual;
        for (at, (row, slope)) in terms.iter().enumerate() {
            self.gradient[*row] += weight * residual * slope;
            for (column, other) in &terms[..=at] {
                self.normal.add(*row, *column, weight * slope * other);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::{geometry::Side, robot::RobotModel};

    fn targets(robot: &RobotModel, motion: &[Angles]) -> Vec<SideTarget> {
        use crate::retarget::target::{HandTarget, PinchTarget};
        let target = |angles: &Angles| {
            let mut posture = SidePosture::default();
            robot.chain(Side::Right).pose(&(*angles).into(), &mut posture);
            let tips = posture.tips.map(|tip| tip - posture.wrist);
            let hand = HandTarget { tips, pinches: [PinchTarget::default(); 4] };
            let wrist = SideTarget::wrist_only(posture.wrist, posture.wrist_rotation, &Vector3::zeros());
            SideTarget { hand: Some(hand), ..wrist }
        };
        motion.iter().map(target).collect()
    }

    #[test]
    fn the_gradient_is_that_of_the_cost() {
        let robot = RobotModel::embedded().unwrap();
        let solver = SideSolver::new(&robot, Side::Right, Weights::default());
        let run = FingerRun::new(robot.chain(Side::Right), &solver, Weights::default(), 0.5);
        let angles: Vec<Angles> =
            (0..4).map(|t| Angles::from_fn(|joint, _| 0.3 + 0.02 * (t * t + joint) as f64)).collect();
        let goals = targets(&robot, &vec![Angles::repeat(0.4); 4]);
        let exact = run.linearise(&goals, &angles).gradient;
        for (index, slope) in exact.iter().enumerate() {
            let cost = |by: f64| {
                let mut moved = angles.clone();
                moved[index / JOINTS][FIRST + index % JOINTS] += by;
                run.linearise(&goals, &moved).cost
            };
            let numeric = (cost(1e-6) - cost(-1e-6)) / 2e-6;
            assert!((numeric - slope).abs() < 1e-5, "{index}: {numeric} {slope}");
        }
    }

    #[test]
    fn a_jump_is_prepared_and_kept_within_the_limits_of_speed() {
        let robot = RobotModel::embedded().unwrap();
        let solver = SideSolver::new(&robot, Side::Right, Weights::default());
        let run = FingerRun::new(robot.chain(Side::Right), &solver, Weights::default(), 0.5);
        let mut open = solver.comfortable();
        open.rows_mut(FIRST, JOINTS).fill(0.1);
        let mut closed = open;
        closed.rows_mut(FIRST + 2, 4).fill(1.2);
        let wanted: Vec<Angles> = (0..60).map(|t| if t < 30 { open } else { closed }).collect();
        let mut found = vec![open; 60];
        run.refine(&targets(&robot, &wanted), &mut found);
        let index = FIRST + 2;
        let fastest = found.windows(2).map(|w| (w[1][index] - w[0][index]).abs()).fold(0.0, f64::max);
        assert!(fastest < 1.1 * solver.step[index], "{fastest}");
        // It sets out before the jump and arrives after it.
        assert!(found[26][index] > 0.15 && found[34][index] < 1.15 && found[50][index] > 1.15);
    }
}
