//! One motion against one reference.

use std::ops::Range;

use nalgebra::Vector3;

use super::{Episode, Metric, Scores};
use crate::{
    clip::STANDARD_FPS,
    evaluate::metrics::{
        Alignment, SpectralParams, log_dimensionless_jerk, mean_distance, resampled, sal_fixed, sparc, speed,
    },
    geometry::Side,
    hands::HandFrame,
    landmarks::{
        KEYPOINT_COUNT,
        keypoint::{TIPS, WRIST},
    },
    retarget::{CameraMap, RobotMotion},
    robot::RobotModel,
};

/// Cut-off of the fixed spectral arc length, Hz.
pub(super) const SAL_CUTOFF_HZ: f64 = 10.0;
/// A side with fewer frames that count is left out: half a second.
const FEWEST: usize = 15;
/// Thumb and index tips nearer than this, on a hand of 0.18 m, are a pinch, metres.
const PINCH: f64 = 0.03;
const PINCH_HAND: f64 = 0.18;
/// Smoothness is that of hands that move: a hand whose human travels less than this share of the other's way is left
/// out of it, since of a hand at rest it is the smoothness of noise.
const MOVES: f64 = 0.5;
/// A joint counts as beyond a limit from here on, radians.
const TOLERANCE: f64 = 1e-9;

/// Scores `motion` on `episode`; `robot` is the one that moves.
///
/// A side is scored from the first to the last frame on which the track knows its hand, so that gaps inside count and
/// what nobody could know does not; the span is the same for every method. Smoothness is that of the whole span, over
/// the hands that move.
pub fn score(episode: &Episode, motion: &RobotMotion, robot: &RobotModel, alignment: Alignment) -> Scores {
    let mut scores = Scores::default();
    let sides: Vec<SideScore> = Side::BOTH
        .into_iter()
        .filter_map(|side| score_side(episode, motion, robot, alignment, side))
        .collect();
    let frames: f64 = sides.iter().map(|side| side.frames).sum();
    let by_frames = |of: &dyn Fn(&SideScore) -> f64| {
        (frames > 0.0).then(|| sides.iter().map(|side| of(side) * side.frames).sum::<f64>() / frames)
    };
    let over_sides = |of: &dyn Fn(&SideScore) -> Option<f64>| mean(sides.iter().filter_map(of));
    let farthest = sides.iter().map(|side| side.way).fold(0.0, f64::max);
    let moving = |of: &dyn Fn(&SideScore) -> Option<f64>| {
        mean(sides.iter().filter(|side| side.way >= MOVES * farthest).filter_map(of))
    };
    scores.set(Metric::PositionError, by_frames(&|side| side.error * 100.0));
    scores.set(Metric::Sparc, moving(&|side| side.smoothness.sparc));
    scores.set(Metric::Sal, moving(&|side| side.smoothness.sal));
    scores.set(Metric::Ldlj, moving(&|side| side.smoothness.ldlj));
    scores.set(Metric::FingertipError, by_frames(&|side| side.fingertips * 100.0));
    scores.set(
        Metric::SightError,
        by_frames(&|side| side.sight * side.sight).map(|square| 1e3 * square.sqrt()),
    );
    scores.set(
        Metric::PinchGap,
        mean(sides.iter().flat_map(|side| side.pinches.iter().map(|gap| gap * 100.0))),
    );
    scores.set(Metric::LimitMargin, over_sides(&|side| side.margin));
    scores.set(Metric::Reachable, over_sides(&|side| side.reachable));
    scores.set(Metric::Driven, by_frames(&|side| side.driven));
    let limits = robot.limits();
    let (mut peak, mut violations) = (0.0_f64, 0);
    for pair in motion.angles.windows(2) {
        violations += limits.velocity_violations(&pair[0], &pair[1], TOLERANCE);
        for (joint, (a, b)) in pair[0].0.iter().zip(&pair[1].0).enumerate() {
            peak = peak.max((b - a).abs() / limits.step(joint));
        }
    }
    violations += motion.angles.iter().map(|q| limits.position_violations(q, TOLERANCE)).sum::<usize>();
    scores.set(Metric::VelocityPeak, Some(peak));
    scores.set(Metric::LimitViolations, Some(violations as f64));
    scores
}

/// Smoothness of the human hands of `episode`, over the spans that methods are scored on.
pub(super) fn human_smoothness(episode: &Episode) -> Scores {
    let sides: Vec<(f64, Smoothness)> = Side::BOTH
        .into_iter()
        .filter_map(|side| {
            let (span, counts) = scored(episode, side)?;
            let joints = &episode.reference.joints[side][span];
            let path: Option<Vec<_>> = joints.iter().map(|joints| Some(joints.as_ref()?[WRIST])).collect();
            let path = path?;
            Some((way(&path, &counts), Smoothness::of(&path)))
        })
        .collect();
    let farthest = sides.iter().map(|(way, _)| *way).fold(0.0, f64::max);
    let moving = |of: &dyn Fn(&Smoothness) -> Option<f64>| {
        mean(sides.iter().filter(|(way, _)| *way >= MOVES * farthest).filter_map(|(_, side)| of(side)))
    };
    let mut scores = Scores::default();
    scores.set(Metric::Sparc, moving(&|side| side.sparc));
    scores.set(Metric::Sal, moving(&|side| side.sal));
    scores.set(Metric::Ldlj, moving(&|side| side.ldlj));
    scores
}

/// How far a wrist travels over the frames that count, metres.
fn way(path: &[Vector3<f64>], counts: &[bool]) -> f64 {
    let steps = path.windows(2).zip(counts.windows(2));
    steps.filter(|(_, counts)| counts[0] && counts[1]).map(|(pair, _)| (pair[1] - pair[0]).norm()).sum()
}

struct Smoothness {
    sparc: Option<f64>,
    sal: Option<f64>,
    ldlj: Option<f64>,
}

impl Smoothness {
    fn of(path: &[Vector3<f64>]) -> Self {
        let speed = speed(path, STANDARD_FPS);
        Self {
            sparc: sparc(&speed, STANDARD_FPS, &SpectralParams::default()),
            sal: sal_fixed(&speed, STANDARD_FPS, SAL_CUTOFF_HZ),
            ldlj: log_dimensionless_jerk(&speed, STANDARD_FPS),
        }
    }
}

struct SideScore {
    frames: f64,
    /// How far the human's wrist travels, metres.
    way: f64,
    error: f64,
    smoothness: Smoothness,
    fingertips: f64,
    /// Root mean square angle to the line of sight of the track, radians.
    sight: f64,
    pinches: Vec<f64>,
    margin: Option<f64>,
    reachable: Option<f64>,
    driven: f64,
}

/// The span of a side and which of its frames count; `None` where too few do.
fn scored(episode: &Episode, side: Side) -> Option<(Range<usize>, Vec<bool>)> {
    let known = &episode.track.hands[side];
    let first = known.iter().position(|hand| hand.is_valid())?;
    let last = known.iter().rposition(|hand| hand.is_valid())?;
    let reference = &episode.reference;
    let counts: Vec<bool> = (first..=last)
        .map(|frame| reference.counts[side][frame] && reference.joints[side][frame].is_some())
        .collect();
    (counts.iter().filter(|counts| **counts).count() >= FEWEST).then_some((first..last + 1, counts))
}

fn score_side(
    episode: &Episode,
    motion: &RobotMotion,
    robot: &RobotModel,
    alignment: Alignment,
    side: Side,
) -> Option<SideScore> {
    let (span, counts) = scored(episode, side)?;
    let reports = motion.sides[side].get(span.clone())?;
    let map = &motion.map;
    let path: Vec<Vector3<f64>> =
        reports.iter().map(|report| to_scene(map, &report.reached.position().xyz)).collect();
    let joints = &episode.reference.joints[side][span.clone()];
    let human: Vec<Vector3<f64>> =
        joints.iter().map(|joints| joints.map_or_else(Vector3::zeros, |joints| joints[WRIST])).collect();
    // One normalised timeline: a method that dropped frames is stretched over the human's.
    let on_timeline = resampled(&path, human.len());
    let aligned = alignment.apply(&on_timeline, &human, &counts);
    let robot_hand = robot.chain(side).open_tips_in_palm()[2].norm();
    let human_hand = episode.reference.hand_length[side];
    let scale = human_hand.map_or(1.0, |length| robot_hand / length);
    let (mut fingertips, mut pinches, mut driven) = (0.0, Vec::new(), 0);
    for ((report, joints), _) in reports.iter().zip(joints).zip(&counts).filter(|(_, counts)| **counts) {
        let Some(joints) = joints else { continue };
        fingertips += fingertip_error(map, report, joints, scale);
        let gap = (joints[TIPS[1]] - joints[TIPS[0]]).norm();
        if gap * PINCH_HAND / human_hand.unwrap_or(PINCH_HAND) < PINCH {
            pinches.push(report.fingertips[0].distance(&report.fingertips[1]));
        }
        driven += usize::from(report.driven);
    }
    let frames = counts.iter().filter(|counts| **counts).count() as f64;
    let of_driven = |of: &dyn Fn(&crate::retarget::SideReport) -> f64| {
        mean(reports.iter().filter(|report| report.driven).map(of))
    };
    Some(SideScore {
        frames,
        way: way(&human, &counts),
        error: mean_distance(&aligned, &human, &counts)?,
        smoothness: Smoothness::of(&path),
        fingertips: fingertips / frames,
        sight: sight_error(&path, &episode.track.hands[side][span], &counts),
        pinches,
        margin: of_driven(&|report| report.limit_margin),
        reachable: of_driven(&|report| f64::from(u8::from(report.reachable))),
        driven: driven as f64 / frames,
    })
}

/// Mean distance between the robot's wrist → fingertip vectors, in camera axes, and the human's scaled.
fn fingertip_error(
    map: &CameraMap,
    report: &crate::retarget::SideReport,
    joints: &[Vector3<f64>; KEYPOINT_COUNT],
    scale: f64,
) -> f64 {
    let wrist = report.reached.position().xyz;
    let off = |finger: usize| {
        let robot = map.rotation.transpose() * (report.fingertips[finger].xyz - wrist);
        (robot - scale * (joints[TIPS[finger]] - joints[WRIST])).norm()
    };
    (0..5).map(off).sum::<f64>() / 5.0
}

/// Root mean square angle, radians, between the directions to `path` and to the wrists of the track, over the frames
/// that count and on which the track knows the hand.
fn sight_error(path: &[Vector3<f64>], track: &[HandFrame], counts: &[bool]) -> f64 {
    let seen = path.iter().zip(track).zip(counts).filter(|((_, hand), counts)| **counts && hand.is_valid());
    let squares = seen.map(|((robot, hand), _)| robot.angle(&hand.wrist().xyz).powi(2));
    mean(squares).unwrap_or(0.0).sqrt()
}

/// A torso point back in the source camera's frame, metres of the human scene.
fn to_scene(map: &CameraMap, torso: &Vector3<f64>) -> Vector3<f64> {
    map.rotation.transpose() * (torso - map.offset) / map.beta
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f64)
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::{
        geometry::{PerSide, Pose, Position},
        retarget::{CameraRotation, SideReport},
        robot::JointAngles,
        synth::{EpisodeSpec, error_model::ErrorModel, error_model::estimated_track, motion_truth},
    };

    fn episode(seed: u64, model: &ErrorModel) -> Episode {
        let truth = motion_truth(&EpisodeSpec { seed, ..EpisodeSpec::default() }).unwrap();
        Episode::with_truth("test".to_owned(), estimated_track(&truth, model), &truth)
    }

    /// A robot whose wrists are where the map takes the true ones, moved by `off` (robot metres).
    fn mapped(episode: &Episode, map: CameraMap, off: Vector3<f64>) -> RobotMotion {
        let report = |joints: &Option<[Vector3<f64>; KEYPOINT_COUNT]>| {
            let to_torso = |p: Vector3<f64>| Position::new(map.beta * (map.rotation * p) + map.offset + off);
            let joints = joints.unwrap_or([Vector3::z(); KEYPOINT_COUNT]);
            let wrist = Pose::from_parts(to_torso(joints[WRIST]), UnitQuaternion::identity());
            SideReport {
                driven: true,
                target: wrist,
                reached: wrist,
                fingertips: TIPS.map(|tip| to_torso(joints[tip])),
                error_position: 0.0,
                error_rotation: 0.0,
                limit_margin: 0.2,
                reachable: true,
                contact: 0.0,
            }
        };
        let sides = PerSide::from_fn(|side| episode.reference.joints[side].iter().map(report).collect());
        let count = episode.track.frame_count();
        RobotMotion {
            map,
            alpha: 1.0,
            angles: vec![JointAngles::default(); count],
            raw_angles: Vec::new(),
            sides,
            method: crate::retarget::Method::Ours,
        }
    }

    #[test]
    fn a_robot_that_follows_its_own_map_has_no_error_and_the_humans_smoothness_whatever_the_map() {
        let robot = RobotModel::embedded().unwrap();
        for (seed, beta) in [(1, 0.7), (4, 1.0), (5, 1.1)] {
            let episode = episode(seed, &ErrorModel::default());
            let rotation = CameraRotation::default().matrix().unwrap();
            let map = CameraMap { beta, rotation, offset: Vector3::new(0.1, -0.2, 0.3) };
            let human = human_smoothness(&episode);
            let scores = score(&episode, &mapped(&episode, map, Vector3::zeros()), &robot, Alignment::None);
            assert!(scores.get(Metric::PositionError).unwrap() < 1e-9, "seed {seed}");
            for metric in [Metric::Sparc, Metric::Sal, Metric::Ldlj] {
                let (a, b) = (scores.get(metric).unwrap(), human.get(metric).unwrap());
                assert!((a - b).abs() < 1e-6, "seed {seed} {metric:?}: {a} {b}");
            }
            assert_eq!(scores.get(Metric::Driven), Some(1.0));
            let off = mapped(&episode, map, Vector3::x() * 0.02 * beta);
            let error =
                |alignment| score(&episode, &off, &robot, alignment).get(Metric::PositionError).unwrap();
            assert!((error(Alignment::None) - 2.0).abs() < 1e-9, "metres of the human scene");
            assert!(error(Alignment::Rigid) < 0.5);
        }
    }
}
