//! The stage: hands in, robot motion out.

use nalgebra::SVector;

use crate::{
    clip::STANDARD_FPS,
    geometry::{PerSide, Side},
    hands::HandTrack,
    progress::Watch,
    robot::{JointAngles, RobotModel, SIDE_DOF},
};

use super::{
    CameraMap, Method, RetargetError, RobotMotion,
    baselines::{BaselineClip, do_as_i_do, masquerade},
    beta::fit_beta,
    filter::{limit_rate, moving_average, moving_average_zero_phase},
    fingers::FingerRun,
    grip::pinch_strengths,
    human::HumanPose,
    mapping::SideMap,
    params::{Beta, RetargetParams, Smoothing},
    report::side_reports,
    rest::{fill_gaps, rest_angles},
    solve::ClipSolver,
    solver::SideSolver,
    target::SideTarget,
    track::HumanTrack,
    view::choose_view,
};

type Angles = SVector<f64, SIDE_DOF>;

/// Carries the hands of a clip over to the robot.
///
/// `hands` is in the camera frame (metres). The result has one row a frame: 26 angles inside position and
/// velocity limits at 30 FPS, and for each side what was wanted and what was reached in `torso_link`. Where a
/// hand is not valid its arm rests or is on its way, and the side's report says `driven = false`. The map in
/// the result is the one to render with: an untouched default view is replaced where it leaves the hands out of
/// reach (a camera opposite the person, say).
///
/// `params.method` chooses between our own method and the published baselines; all of the above holds for each,
/// save that arms of a baseline do what it says where no hand is valid.
///
/// # Errors
/// When a parameter is out of range, the track's sides differ in length, or the work was cancelled.
pub fn retarget(
    hands: &HandTrack,
    robot: &RobotModel,
    params: &RetargetParams,
    watch: &dyn Watch,
) -> Result<RobotMotion, RetargetError> {
    params.validate()?;
    let (left, right) = (hands.hands.left.len(), hands.hands.right.len());
    if left != right {
        return Err(RetargetError::TrackLengths { left, right });
    }
    let tracks = PerSide::from_fn(|side| HumanTrack::new(&hands.hands[side], &params.cutoff));
    let mut map = choose_view(&tracks, robot, params)?;
    map.beta = match params.beta {
        Beta::Fixed(beta) => beta,
        Beta::Fit => fit_beta(&tracks, robot, params, map),
    };
    let clip = BaselineClip { hands, robot, params, tracks: &tracks, shared_map: map, watch };
    Ok(match params.method {
        Method::Ours => ours(&clip)?,
        Method::Masquerade => masquerade(&clip)?,
        Method::DoAsIDo => do_as_i_do(&clip)?,
    })
}

/// AgenticFocus itself.
fn ours(clip: &BaselineClip<'_>) -> Result<RobotMotion, RetargetError> {
    let BaselineClip { robot, params, tracks, shared_map: map, watch, .. } = *clip;
    let count = clip.hands.frame_count();
    let mut motion = RobotMotion {
        method: Method::Ours,
        map,
        alpha: params.alpha,
        angles: vec![JointAngles::default(); count],
        raw_angles: vec![JointAngles::default(); count],
        sides: PerSide { left: Vec::new(), right: Vec::new() },
    };
    for side in Side::BOTH {
        let work = SideWork { robot, side, params, map, track: &tracks[side] };
        let solved = work.solve(watch)?;
        for frame in 0..count {
            motion.angles[frame].set_side(side, &solved.angles[frame].into());
            motion.raw_angles[frame].set_side(side, &solved.raw[frame].into());
        }
        let tolerance = params.reach_tolerance;
        motion.sides[side] =
            side_reports(robot, (side, &tracks[side]), &solved.targets, &motion.angles, |_, error| {
                error <= tolerance
            });
        watch.advance(count * (side.index() + 1), 2 * count);
    }
    Ok(motion)
}

/// One side of a clip.
struct SideWork<'a> {
    robot: &'a RobotModel,
    side: Side,
    params: &'a RetargetParams,
    map: CameraMap,
    track: &'a HumanTrack,
}

struct SolvedSide {
    raw: Vec<Angles>,
    angles: Vec<Angles>,
    /// The wanted targets, before any was drawn back into reach.
    targets: Vec<Option<SideTarget>>,
}

impl SideWork<'_> {
    fn solve(&self, watch: &dyn Watch) -> Result<SolvedSide, RetargetError> {
        let solver = SideSolver::new(self.robot, self.side, self.params.weights);
        let clip = ClipSolver { robot: self.robot, side: self.side, params: self.params, watch };
        let targets = self.targets();
        let rest = rest_angles(&solver, self.side);
        let mut angles = vec![rest; targets.len()];
        let mut within_reach = Vec::with_capacity(self.track.spans.len());
        for span in &self.track.spans {
            let wanted: Vec<SideTarget> = targets[span.clone()].iter().copied().flatten().collect();
            let run = clip.solve_run(&wanted)?;
            angles[span.clone()].copy_from_slice(&run.angles);
            within_reach.push(run.within_reach);
        }
        let frames_to_rest = (self.params.rest_time * STANDARD_FPS).ceil().max(1.0) as usize;
        fill_gaps(&mut angles, &self.track.spans, &rest, frames_to_rest);
        let raw = angles.clone();
        self.smooth(&mut angles, &solver);
        if self.params.smoothing == Smoothing::ZeroPhase {
            let smoothed = angles.clone();
            for (span, targets) in self.track.spans.iter().zip(&within_reach) {
                clip.settle(targets, &mut angles, span);
                let chain = self.robot.chain(self.side);
                FingerRun::new(chain, &solver, self.params.weights, self.params.alpha)
                    .refine(targets, &mut angles[span.clone()]);
            }
            self.fade_settling(&mut angles, &smoothed);
            for_each_joint(&mut angles, |joint, values| limit_rate(values, solver.step[joint]));
        }
        for frame in &mut angles {
            *frame = frame.sup(&solver.lower).inf(&solver.upper);
        }
        Ok(SolvedSide { raw, angles, targets })
    }

    fn targets(&self) -> Vec<Option<SideTarget>> {
        let mut targets = vec![None; self.track.poses.len()];
        let Some(size) = &self.track.size else { return targets };
        let map = SideMap::new(self.map, self.robot.chain(self.side), size, &self.params.wrist[self.side]);
        for span in &self.track.spans {
            let run: Vec<HumanPose> = self.track.poses[span.clone()].iter().copied().flatten().collect();
            let strengths = pinch_strengths(&run, size, &self.params.pinch);
            for ((frame, pose), strengths) in span.clone().zip(&run).zip(&strengths) {
                targets[frame] = Some(map.hand(pose, strengths, &self.params.pinch));
            }
        }
        targets
    }

    /// Velocity limits, then the method's average; an average of kept limits keeps them.
    fn smooth(&self, angles: &mut [Angles], solver: &SideSolver<'_>) {
        for_each_joint(angles, |joint, values| {
            limit_rate(values, solver.step[joint]);
            match self.params.smoothing {
                Smoothing::None => {}
                Smoothing::Ema => moving_average(values, self.params.alpha),
                Smoothing::ZeroPhase => moving_average_zero_phase(values, self.params.alpha),
            }
        });
    }

    /// Lets what settling changed at the ends of a run die away over the frames next to it.
    fn fade_settling(&self, angles: &mut [Angles], smoothed: &[Angles]) {
        const FADE: usize = 12;
        let count = angles.len();
        for span in &self.track.spans {
            let (first, last) = (span.start, span.end - 1);
            let (at_first, at_last) = (angles[first] - smoothed[first], angles[last] - smoothed[last]);
            for distance in 1..FADE {
                let share = 0.5 + 0.5 * (std::f64::consts::PI * distance as f64 / FADE as f64).cos();
                if distance <= first && self.track.poses[first - distance].is_none() {
                    angles[first - distance] += at_first * share;
                }
                if last + distance < count && self.track.poses[last + distance].is_none() {
                    angles[last + distance] += at_last * share;
                }
            }
        }
    }
}

fn for_each_joint(angles: &mut [Angles], mut work: impl FnMut(usize, &mut [f64])) {
    for joint in 0..SIDE_DOF {
        let mut values: Vec<f64> = angles.iter().map(|frame| frame[joint]).collect();
        work(joint, &mut values);
        for (frame, value) in angles.iter_mut().zip(values) {
            frame[joint] = value;
        }
    }
}
