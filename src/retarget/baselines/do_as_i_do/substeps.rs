//! Following a run of goals, a few steps of a quadratic program a frame.

use crate::{
    progress::{Cancelled, Watch},
    retarget::{
        solver::{SideAngles, SideSolver, box_step},
        start::solve_afresh,
        target::SideTarget,
    },
    robot::{SideChain, SidePosture},
};

use super::cost::{HandGoal, linearise};
use crate::geometry::Side;

/// Steps a frame (of 5 ms each in the published program, which has no velocity limits).
const SUBSTEPS: usize = 4;
/// Steps on the first frame, first for the wrist alone, then for everything.
const FIRST: [usize; 2] = [200, 300];

/// Solves `goals` one after the other, warm-started, inside the position limits.
///
/// The published robot is a hand that floats; on an arm the wrist-only steps begin at the best of several
/// postures that reach the wrist, since an arm may not get there from anywhere.
pub(super) fn follow(
    chain: &SideChain,
    side: Side,
    solver: &mut SideSolver<'_>,
    goals: &[HandGoal],
    watch: &dyn Watch,
) -> Result<Vec<SideAngles>, Cancelled> {
    let bounds = solver.anywhere();
    let nominal = solver.comfortable();
    let mut posture = SidePosture::default();
    let mut advance = |angles: &mut SideAngles, goal: &HandGoal, fingers: bool, steps: usize| {
        for _ in 0..steps {
            let system = linearise(chain, goal, angles, &nominal, fingers, &mut posture);
            let moved = *angles + box_step(&system, 0.0, angles, &bounds);
            *angles = moved.sup(&bounds.lower).inf(&bounds.upper);
        }
    };
    let Some(first) = goals.first() else { return Ok(Vec::new()) };
    let wrist = SideTarget::wrist_only(first.palm, first.rotation, &nalgebra::Vector3::zeros());
    let mut angles = solve_afresh(solver, side, &wrist).first().map_or(nominal, |best| best.angles);
    angles.rows_mut(7, 6).copy_from(&nominal.rows(7, 6));
    advance(&mut angles, first, false, FIRST[0]);
    advance(&mut angles, first, true, FIRST[1]);
    let mut solved = vec![angles];
    for (frame, goal) in goals.iter().enumerate().skip(1) {
        if frame % 64 == 0 {
            watch.check()?;
        }
        advance(&mut angles, goal, true, SUBSTEPS);
        solved.push(angles);
    }
    Ok(solved)
}
