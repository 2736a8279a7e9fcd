//! What an arm does while no hand drives it.

use std::ops::Range;

use nalgebra::SVector;

use crate::{geometry::Side, robot::SIDE_DOF};

use super::solver::SideSolver;

type Angles = SVector<f64, SIDE_DOF>;

/// The left arm at rest, radians: hanging, slightly behind the body, below the camera's view.
const REST_ARM: [f64; 7] = [0.3, 0.15, 0.0, 1.1, 0.0, 0.0, 0.0];
/// Share of each finger's range at rest.
const REST_FINGERS: f64 = 0.15;

/// The resting posture of a side.
pub(super) fn rest_angles(solver: &SideSolver<'_>, side: Side) -> Angles {
    let mut rest = Angles::zeros();
    for (joint, angle) in REST_ARM.into_iter().enumerate() {
        let mirrors = matches!(joint, 1 | 2 | 4 | 6) && side == Side::Right;
        rest[joint] = if mirrors { -angle } else { angle };
    }
    for joint in 7..SIDE_DOF {
        rest[joint] = REST_FINGERS * solver.upper[joint];
    }
    rest.sup(&solver.lower).inf(&solver.upper)
}

/// Fills the frames outside `spans`: the arm goes to rest in `frames_to_rest` frames and comes back as long
/// before it is needed; a gap too short for both is crossed directly.
pub(super) fn fill_gaps(angles: &mut [Angles], spans: &[Range<usize>], rest: &Angles, frames_to_rest: usize) {
    let (Some(first), Some(last)) = (spans.first(), spans.last()) else {
        angles.fill(*rest);
        return;
    };
    let arrive = angles[first.start];
    for (frame, angle) in angles[..first.start].iter_mut().enumerate() {
        *angle = blend(&arrive, rest, (first.start - frame) as f64 / frames_to_rest as f64);
    }
    let leave = angles[last.end - 1];
    for (since, angle) in angles[last.end..].iter_mut().enumerate() {
        *angle = blend(&leave, rest, (since + 1) as f64 / frames_to_rest as f64);
    }
    for pair in spans.windows(2) {
        let (from, to) = (pair[0].end - 1, pair[1].start);
        let (leave, arrive) = (angles[from], angles[to]);
        for (offset, angle) in angles[from + 1..to].iter_mut().enumerate() {
            let since = (offset + 1) as f64;
            let until = (to - from) as f64 - since;
            *angle = if to - from <= 2 * frames_to_rest {
                blend(&leave, &arrive, since / (since + until))
            } else if since <= until {
                blend(&leave, rest, since / frames_to_rest as f64)
            } else {
                blend(&arrive, rest, until / frames_to_rest as f64)
            };
        }
    }
}

/// From `from` at share 0 to `to` at share 1 and beyond, without jerk at either end (Flash and Hogan 1985).
fn blend(from: &Angles, to: &Angles, share: f64) -> Angles {
    let s = share.clamp(0.0, 1.0);
    from + (to - from) * (s * s * s * (10.0 - 15.0 * s + 6.0 * s * s))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_gap_passes_through_rest_and_a_short_one_does_not() {
        let rest = Angles::repeat(1.0);
        let mut angles = vec![Angles::zeros(); 100];
        fill_gaps(&mut angles, &[0..10, 20..30, 90..100], &rest, 10);
        assert!(angles[10..20].iter().all(|a| a.amax() < 1e-12));
        assert_eq!(angles[60], rest);
        assert!(angles[31].amax() < 0.1 && angles[89].amax() < 0.1);
    }
}
