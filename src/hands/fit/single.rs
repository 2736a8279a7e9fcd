//! One frame on its own: Levenberg–Marquardt over the 27 pose parameters.

use super::{
    kinematics::HandPose,
    shape::HandShape,
    terms::{Sight, cost, normal},
};

/// Improves `pose` for at most `iterations` steps; the pose and its cost.
pub(super) fn refine(
    shape: &HandShape,
    start: HandPose,
    sight: &Sight,
    iterations: usize,
) -> (HandPose, f64) {
    let mut pose = start;
    let mut now = cost(shape, &pose, Some(sight));
    let mut damping = 1e-2;
    for _ in 0..iterations {
        let terms = normal(shape, &pose, Some(sight), false);
        let before = now;
        let mut improved = false;
        for _ in 0..4 {
            let mut system = terms.hessian;
            for k in 0..system.nrows() {
                system[(k, k)] += damping * system[(k, k)] + 1e-9;
            }
            let Some(factor) = system.cholesky() else {
                damping *= 10.0;
                continue;
            };
            let candidate = pose.stepped(&-factor.solve(&terms.gradient));
            let value = cost(shape, &candidate, Some(sight));
            if value < now && candidate.wrist.z > 0.0 {
                (pose, now, improved) = (candidate, value, true);
                damping = (damping * 0.2).max(1e-9);
                break;
            }
            damping *= 8.0;
        }
        if !improved || before - now < 1e-4 * now {
            break;
        }
    }
    (pose, now)
}
