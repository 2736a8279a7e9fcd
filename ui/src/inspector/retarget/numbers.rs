//! Four numbers a side: how well the robot follows.

use agenticfocus::{
    clip::STANDARD_FPS,
    geometry::PerSide,
    retarget::{RobotMotion, SideReport},
};

use super::sparc::sparc;

/// How well one side follows its hand, over the frames on which a hand drives it; `None` without any.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SideNumbers {
    /// Mean distance of the wrist to its target, metres.
    pub mean_error: Option<f64>,
    /// Share of frames whose target lies within reach, 0 to 1.
    pub reachable: Option<f64>,
    /// The least distance of an arm joint to a limit as a share of its range, 0 to 0.5.
    pub limit_margin: Option<f64>,
    /// Smoothness of the wrist's speed over the longest stretch: nearer to 0 is smoother.
    pub sparc: Option<f64>,
}

/// The numbers of both sides.
pub fn numbers_of(motion: &RobotMotion) -> PerSide<SideNumbers> {
    PerSide::from_fn(|side| SideNumbers {
        sparc: sparc(&longest_drive(&motion.sides[side]), STANDARD_FPS),
        ..followed(&motion.sides[side])
    })
}

/// The numbers without smoothness, which takes the longest.
pub(in crate::inspector) fn followed(reports: &[SideReport]) -> SideNumbers {
    let driven = || reports.iter().filter(|report| report.driven);
    let count = driven().count();
    if count == 0 {
        return SideNumbers::default();
    }
    let share = 1.0 / count as f64;
    SideNumbers {
        mean_error: Some(driven().map(|report| report.error_position).sum::<f64>() * share),
        reachable: Some(driven().filter(|report| report.reachable).count() as f64 * share),
        limit_margin: Some(driven().map(|report| report.limit_margin).fold(0.5, f64::min)),
        sparc: None,
    }
}

/// Wrist speed in m/s from the frame before to this one; `None` where either is not driven.
pub(super) fn wrist_speed(reports: &[SideReport]) -> Vec<Option<f64>> {
    let speed = |pair: &[SideReport]| match pair {
        [before, now] if before.driven && now.driven => {
            Some(now.reached.position().distance(&before.reached.position()) * STANDARD_FPS)
        }
        _ => None,
    };
    std::iter::once(None).chain(reports.windows(2).map(speed)).take(reports.len()).collect()
}

/// Speeds of the longest stretch without a gap: a gap would count as a jerk.
fn longest_drive(reports: &[SideReport]) -> Vec<f64> {
    let speeds = wrist_speed(reports);
    let longest = speeds.split(Option::is_none).max_by_key(|stretch| stretch.len());
    longest.unwrap_or_default().iter().flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use agenticfocus::geometry::{Pose, Position};

    use super::*;

    fn report(driven: bool, x: f64) -> SideReport {
        let at = Position::new([x, 0.0, 0.0].into());
        let reached = Pose::from_parts(at, nalgebra::UnitQuaternion::identity());
        SideReport {
            driven,
            target: reached,
            reached,
            fingertips: [Position::default(); 5],
            error_position: x,
            error_rotation: 0.0,
            limit_margin: 0.3 - x,
            reachable: x < 0.025,
            contact: 0.0,
        }
    }

    #[test]
    fn frames_without_a_hand_do_not_count() {
        let numbers = followed(&[report(true, 0.01), report(false, 9.0), report(true, 0.03)]);
        assert!((numbers.mean_error.unwrap() - 0.02).abs() < 1e-12);
        assert_eq!(numbers.reachable, Some(0.5));
        assert!((numbers.limit_margin.unwrap() - 0.27).abs() < 1e-12);
        assert_eq!(followed(&[report(false, 0.0)]), SideNumbers::default());
    }

    #[test]
    fn speed_has_gaps_where_the_hand_is_away() {
        let speeds =
            wrist_speed(&[report(true, 0.0), report(true, 0.01), report(false, 0.0), report(true, 0.0)]);
        assert_eq!(speeds.iter().map(Option::is_some).collect::<Vec<_>>(), [false, true, false, false]);
        assert!((speeds[1].unwrap() - 0.3).abs() < 1e-12);
    }
}
