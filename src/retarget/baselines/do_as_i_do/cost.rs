//! What the method minimises on a frame.

use nalgebra::{UnitQuaternion, Vector3};

use crate::robot::{SideChain, SidePosture};

use crate::retarget::solver::{SideAngles, System, rotation_error};

/// Weights of residuals before squaring: per metre, per metre, per radian; and of ‖q − q₀‖².
const FINGERTIP: f64 = 10.0;
const PALM: f64 = 0.3;
const ROTATION: f64 = 3.0;
const POSTURE: f64 = 1e-4;
/// Levenberg–Marquardt damping of each task, times its squared weighted error.
const TASK_DAMPING: f64 = 1.0;
/// Damping of the quadratic program.
const PROGRAM_DAMPING: f64 = 1e-5;

/// Wrist and fingertips that one side is to reach, `torso_link`, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct HandGoal {
    pub palm: Vector3<f64>,
    /// Of the wrist frame.
    pub rotation: UnitQuaternion<f64>,
    /// Thumb to pinky.
    pub tips: [Vector3<f64>; 5],
}

/// Σ 10²‖x_f − x_f*‖² + 0.3²‖x_palm − x*‖² + 3²‖log(R R*ᵀ)‖² + 1e-4‖q − q₀‖² about `angles`, as damped normal
/// equations; without `fingers` the first sum is left out.
pub(super) fn linearise(
    chain: &SideChain,
    goal: &HandGoal,
    angles: &SideAngles,
    nominal: &SideAngles,
    fingers: bool,
    posture: &mut SidePosture,
) -> System {
    chain.pose(&(*angles).into(), posture);
    let posture = &*posture;
    let mut system = System::default();
    if fingers {
        for finger in 0..5 {
            let error = posture.tips[finger] - goal.tips[finger];
            system.add(&(chain.tip_jacobian(posture, finger) * FINGERTIP), &(error * FINGERTIP));
        }
    }
    let error = posture.wrist - goal.palm;
    system.add(&(chain.wrist_jacobian(posture) * PALM), &(error * PALM));
    let turn = rotation_error(&goal.rotation, &posture.wrist_rotation);
    system.add(&(chain.wrist_rotation_jacobian(posture) * ROTATION), &(turn * ROTATION));
    // So far the cost is half the tasks' squared weighted errors.
    let damping = TASK_DAMPING * 2.0 * system.cost + PROGRAM_DAMPING;
    system.pull(&SideAngles::repeat(POSTURE), &(angles - nominal));
    system.damp(damping);
    system
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::Side, robot::RobotModel};

    #[test]
    fn the_gradient_is_that_of_the_cost() {
        let robot = RobotModel::embedded().unwrap();
        let chain = robot.chain(Side::Left);
        let mut posture = SidePosture::default();
        let angles = SideAngles::from_fn(|joint, _| 0.2 + 0.03 * joint as f64);
        let nominal = SideAngles::repeat(0.1);
        chain.pose(&angles.map(|angle| angle + 0.05).into(), &mut posture);
        let goal = HandGoal { palm: posture.wrist, rotation: posture.wrist_rotation, tips: posture.tips };
        let cost = |angles: &SideAngles| {
            linearise(chain, &goal, angles, &nominal, true, &mut SidePosture::default()).cost
        };
        let exact = linearise(chain, &goal, &angles, &nominal, true, &mut posture).gradient;
        for joint in 0..SideAngles::zeros().len() {
            let mut step = SideAngles::zeros();
            step[joint] = 1e-5;
            let numeric = (cost(&(angles + step)) - cost(&(angles - step))) / 2e-5;
            // The rotation residual is linearised at its goal: exact up to half of its own size.
            assert!(
                (numeric - exact[joint]).abs() < 0.06 * exact.amax(),
                "{joint}: {numeric} {}",
                exact[joint]
            );
        }
    }
}
