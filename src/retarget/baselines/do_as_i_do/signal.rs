//! The hand as the method sees it: a wrist, and fingertips in it, cleaned of spikes.

use std::ops::Range;

use nalgebra::{UnitQuaternion, Vector3};

use crate::{
    geometry::Side,
    hands::HandFrame,
    landmarks::keypoint::{BASES, TIPS, WRIST},
};

use super::{
    spikes::{neighbours, spikes},
    wrist_frame::wrist_rotation,
};

/// Most a wrist moves or turns in a frame, metres and radians.
const CAPS: [f64; 2] = [0.20, 0.40];
/// Missing hands up to so many frames are filled like spikes.
const SHORT_GAP: usize = 10;

/// One hand on one frame, camera axes, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct WristSignal {
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    /// Fingertips in the wrist frame, thumb to pinky.
    pub tips: [Vector3<f64>; 5],
}

impl WristSignal {
    /// `None` where the hand is not valid, not finite or flat.
    pub fn new(side: Side, frame: &HandFrame) -> Option<Self> {
        if !frame.is_valid() || !frame.joints.iter().all(|joint| joint.is_finite()) {
            return None;
        }
        let at = |index: usize| frame.joints[index].xyz;
        let position = at(WRIST);
        let rotation = wrist_rotation(side, &position, &at(BASES[1]), &at(BASES[2]), &at(BASES[3]))?;
        Some(Self { position, rotation, tips: TIPS.map(|tip| rotation.inverse() * (at(tip) - position)) })
    }
}

/// Runs of frames to solve as one, each cleaned: spikes of wrist position and of wrist rotation are found and
/// filled on their own (straight and by slerp), and so is a hand that is missing for up to ten frames. Fingers
/// are taken as they are; nothing is low-passed.
pub(super) fn cleaned(signals: &[Option<WristSignal>]) -> Vec<(Range<usize>, Vec<WristSignal>)> {
    let clean = |span: Range<usize>| {
        let cleaned = cleaned_run(&signals[span.clone()]);
        (span, cleaned)
    };
    spans(signals).into_iter().map(clean).collect()
}

fn spans(signals: &[Option<WristSignal>]) -> Vec<Range<usize>> {
    let mut spans: Vec<Range<usize>> = Vec::new();
    for frame in (0..signals.len()).filter(|&frame| signals[frame].is_some()) {
        match spans.last_mut() {
            Some(span) if frame - span.end <= SHORT_GAP => span.end = frame + 1,
            _ => spans.push(frame..frame + 1),
        }
    }
    spans
}

fn cleaned_run(run: &[Option<WristSignal>]) -> Vec<WristSignal> {
    let missing: Vec<bool> = run.iter().map(Option::is_none).collect();
    // A run begins and ends with a hand, so every gap has both ends.
    let at = |frame: usize| run[frame].as_ref();
    let positions = |flagged: &[bool]| {
        filled(flagged, |from, to, share| Some(at(from)?.position.lerp(&at(to)?.position, share)))
    };
    let rotations = |flagged: &[bool]| {
        let between = |from: usize, to: usize, share: f64| {
            let (from, to) = (at(from)?.rotation, at(to)?.rotation);
            Some(from.try_slerp(&to, share, 1e-9).unwrap_or(from))
        };
        filled(flagged, between)
    };
    let jumps = spikes(&missing, CAPS[0], |flagged| {
        positions(flagged).windows(2).map(|pair| (pair[1] - pair[0]).norm()).collect()
    });
    let twists = spikes(&missing, CAPS[1], |flagged| {
        rotations(flagged).windows(2).map(|pair| pair[0].angle_to(&pair[1])).collect()
    });
    let tips = filled(&missing, |from, to, share| {
        let (from, to) = (at(from)?.tips, at(to)?.tips);
        Some(std::array::from_fn(|finger| from[finger].lerp(&to[finger], share)))
    });
    let wrists = positions(&jumps).into_iter().zip(rotations(&twists));
    wrists.zip(tips).map(|((position, rotation), tips)| WristSignal { position, rotation, tips }).collect()
}

fn filled<T>(flagged: &[bool], between: impl Fn(usize, usize, f64) -> Option<T>) -> Vec<T> {
    neighbours(flagged).into_iter().filter_map(|(from, to, share)| between(from, to, share)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(x: f64) -> WristSignal {
        WristSignal {
            position: Vector3::new(x, 0.0, 0.4),
            rotation: UnitQuaternion::identity(),
            tips: [Vector3::zeros(); 5],
        }
    }

    #[test]
    fn short_gaps_and_spikes_are_filled_and_long_gaps_part_runs() {
        let wandering = |t: usize| 0.01 * t as f64 + 0.004 * (t as f64 * 1.7).sin();
        let mut track: Vec<Option<WristSignal>> = (0..80).map(|t| Some(signal(wandering(t)))).collect();
        track[20..24].fill(None);
        track[30..50].fill(None);
        track[65] = Some(signal(2.0));
        let runs = cleaned(&track);
        let spans: Vec<_> = runs.iter().map(|(span, _)| span.clone()).collect();
        assert_eq!(spans, [0..30, 50..80]);
        for (span, run) in runs {
            assert_eq!(span.len(), run.len());
            for (frame, wrist) in span.zip(run) {
                assert!((wrist.position.x - wandering(frame)).abs() < 0.02, "{frame}");
            }
        }
    }
}
