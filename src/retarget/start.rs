//! Where to start: several seeds, since an arm reaches most places in more than one way.

use nalgebra::SVector;

use crate::{geometry::Side, robot::SIDE_DOF};

use super::{
    solver::{SideSolver, Solution},
    target::SideTarget,
};

/// Shoulder pitch, roll, yaw, elbow, wrist roll of the left arm, radians.
const SEEDS: [[f64; 5]; 8] = [
    [-0.1, 0.2, 0.0, 0.3, 0.0],
    [-0.6, 0.3, 0.0, 0.2, 0.0],
    [-0.3, 0.5, 0.6, -0.2, -0.6],
    [-0.3, 0.1, -0.5, 0.3, 0.8],
    [0.4, 0.2, 0.0, -0.5, 0.0],
    [-1.0, 0.2, 0.4, 0.8, -1.2],
    [-0.4, 0.9, 0.3, 0.0, -1.4],
    [-0.2, 0.2, -0.3, 0.0, 1.4],
];

/// The best solutions for `target` without a frame before it, best first and different from each other.
pub(super) fn solve_afresh(solver: &mut SideSolver<'_>, side: Side, target: &SideTarget) -> Vec<Solution> {
    let bounds = solver.anywhere();
    let mut found: Vec<Solution> = Vec::new();
    for seed in SEEDS {
        let mut start = SVector::<f64, SIDE_DOF>::zeros();
        for (joint, angle) in seed.into_iter().enumerate() {
            let mirrors = matches!(joint, 1 | 2 | 4) && side == Side::Right;
            start[joint] = if mirrors { -angle } else { angle };
        }
        for joint in 7..SIDE_DOF {
            start[joint] = 0.3 * solver.upper[joint];
        }
        let near = solver.solve(target, &start, &start, &bounds, 60);
        // Once more without inertia towards the seed, so that costs compare.
        let best = solver.solve(target, &near.angles, &near.angles, &bounds, 20);
        if found.iter().all(|other| (other.angles - best.angles).amax() > 0.05) {
            found.push(best);
        }
    }
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    found
}
