//! Solving one side over a clip.

use std::ops::Range;

use nalgebra::SVector;

use crate::{
    geometry::Side,
    progress::{Cancelled, Watch},
    robot::{RobotModel, SIDE_DOF},
};

use super::{
    params::{RetargetParams, Smoothing, Weights},
    solver::{AngleBox, SideSolver},
    start::solve_afresh,
    target::SideTarget,
};

type Angles = SVector<f64, SIDE_DOF>;

/// Solver steps for a frame with a warm start.
const WARM_STEPS: usize = 8;
/// Different ways to start a run that are followed to its end.
const STARTS: usize = 2;

/// Solves one side run by run.
pub(super) struct ClipSolver<'a> {
    pub robot: &'a RobotModel,
    pub side: Side,
    pub params: &'a RetargetParams,
    pub watch: &'a dyn Watch,
}

/// One run as solved.
pub(super) struct SolvedRun {
    pub angles: Vec<Angles>,
    /// Targets drawn back along the line of sight where the arm is too short.
    pub within_reach: Vec<SideTarget>,
    cost: f64,
}

impl ClipSolver<'_> {
    /// Solves a run of consecutive targets: from its first and its middle frame, from the best few postures
    /// each, and keeps what costs least over the whole run.
    pub fn solve_run(&self, targets: &[SideTarget]) -> Result<SolvedRun, Cancelled> {
        let mut best: Option<SolvedRun> = None;
        let mut anchors = vec![0];
        if targets.len() > 8 {
            anchors.push(targets.len() / 2);
        }
        let mut solver = SideSolver::new(self.robot, self.side, self.params.weights);
        for anchor in anchors {
            for start in solve_afresh(&mut solver, self.side, &targets[anchor]).iter().take(STARTS) {
                self.watch.check()?;
                let run = self.follow(&mut solver, targets, anchor, &start.angles);
                if best.as_ref().is_none_or(|other| run.cost < other.cost * 0.999) {
                    best = Some(run);
                }
            }
        }
        Ok(best.unwrap_or(SolvedRun { angles: Vec::new(), within_reach: Vec::new(), cost: 0.0 }))
    }

    fn follow(
        &self,
        solver: &mut SideSolver<'_>,
        targets: &[SideTarget],
        anchor: usize,
        start: &Angles,
    ) -> SolvedRun {
        let mut run =
            SolvedRun { angles: vec![*start; targets.len()], within_reach: targets.to_vec(), cost: 0.0 };
        let later = anchor..targets.len();
        let earlier = (0..anchor).rev();
        for frames in [later.collect::<Vec<_>>(), earlier.collect()] {
            let mut before = *start;
            for frame in frames {
                let bounds = self.bounds(solver, &before, frame == anchor);
                let (angles, target, cost) = self.solve_frame(solver, &targets[frame], &before, &bounds);
                run.angles[frame] = angles;
                run.within_reach[frame] = target;
                run.cost += cost;
                before = angles;
            }
        }
        run
    }

    /// One frame; where the wrist is out of reach, its target is drawn back along the line of sight to where
    /// the wrist got, which keeps it on its pixel.
    fn solve_frame(
        &self,
        solver: &mut SideSolver<'_>,
        wanted: &SideTarget,
        before: &Angles,
        bounds: &AngleBox,
    ) -> (Angles, SideTarget, f64) {
        let mut target = *wanted;
        let mut solution = solver.solve(&target, before, before, bounds, WARM_STEPS);
        let cost = solution.cost;
        for _ in 0..4 {
            let wrist = solver.pose(&solution.angles).wrist;
            let miss = wrist - target.wrist.position().xyz;
            if miss.norm() <= 0.2 * self.params.reach_tolerance {
                break;
            }
            let along = target.sight * target.sight.dot(&miss);
            target.wrist.isometry.translation.vector += along;
            solution = solver.solve(&target, &solution.angles, before, bounds, WARM_STEPS);
        }
        (solution.angles, target, cost)
    }

    /// Position limits and the velocity limits from the frame before. With zero-phase smoothing the fingers'
    /// velocity is limited afterwards, in both directions of time, so that they do not come late.
    fn bounds(&self, solver: &SideSolver<'_>, before: &Angles, first: bool) -> AngleBox {
        let anywhere = solver.anywhere();
        if first {
            return anywhere;
        }
        let mut bounds = solver.reachable_from(before);
        if self.params.smoothing == Smoothing::ZeroPhase {
            bounds.lower.rows_mut(7, 6).copy_from(&anywhere.lower.rows(7, 6));
            bounds.upper.rows_mut(7, 6).copy_from(&anywhere.upper.rows(7, 6));
        }
        bounds
    }

    /// Puts the wrists of smoothed `angles` back on their targets and fingers where they belong, near the smoothed
    /// posture and inside the velocity limits. `angles` is the whole clip, `span` the run that belongs
    /// to `targets`.
    pub fn settle(&self, targets: &[SideTarget], angles: &mut [Angles], span: &Range<usize>) {
        let given = self.params.weights;
        let weights = Weights { posture: 0.0, inertia: 0.6, ..given };
        let mut solver = SideSolver::new(self.robot, self.side, weights);
        let mut before: Option<Angles> = None;
        for (frame, target) in span.clone().zip(targets) {
            let smoothed = angles[frame];
            let bounds = before.map_or(solver.anywhere(), |before| solver.reachable_from(&before));
            angles[frame] = solver.solve(target, &smoothed, &smoothed, &bounds, WARM_STEPS).angles;
            before = Some(angles[frame]);
        }
    }
}
