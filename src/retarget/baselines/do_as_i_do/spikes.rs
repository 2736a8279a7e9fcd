//! Which frames of a signal are spikes.

use std::ops::Range;

use crate::smoothing::median;

/// Frames of the running median and median absolute deviation.
const WINDOW: usize = 31;
/// Deviations above the median at which an edge counts as a spike.
const DEVIATIONS: f64 = 8.0;
/// Runs of flagged frames longer than this are believed after all.
const LONGEST: usize = 10;

/// Flags spikes: the speed of every edge between frames against the median and eight median absolute deviations
/// around it, at most `cap`; an edge above flags both of its frames. Done twice, the second time on the signal
/// with flagged frames interpolated; a single good frame between flagged ones is flagged too, and runs of more
/// than ten are believed.
///
/// `missing` frames have no value: they stay flagged. `speeds` gives the edges' speeds once the flagged frames
/// are interpolated.
pub(super) fn spikes(missing: &[bool], cap: f64, speeds: impl Fn(&[bool]) -> Vec<f64>) -> Vec<bool> {
    let mut flagged = missing.to_vec();
    for _ in 0..2 {
        for edge in fast_edges(&speeds(&flagged), cap) {
            (flagged[edge], flagged[edge + 1]) = (true, true);
        }
    }
    for frame in 1..flagged.len().saturating_sub(1) {
        flagged[frame] |= flagged[frame - 1] && flagged[frame + 1];
    }
    for run in runs(&flagged) {
        if run.len() > LONGEST {
            flagged[run.clone()].copy_from_slice(&missing[run]);
        }
    }
    flagged
}

fn fast_edges(speeds: &[f64], cap: f64) -> Vec<usize> {
    let fast = |edge: &usize| {
        let half = WINDOW / 2;
        let around = &speeds[edge.saturating_sub(half)..(edge + half + 1).min(speeds.len())];
        let middle = median(around);
        let deviations: Vec<f64> = around.iter().map(|speed| (speed - middle).abs()).collect();
        speeds[*edge] > (middle + DEVIATIONS * median(&deviations)).min(cap)
    };
    (0..speeds.len()).filter(fast).collect()
}

/// Runs of flagged frames.
fn runs(flagged: &[bool]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for frame in (0..flagged.len()).filter(|&frame| flagged[frame]) {
        match runs.last_mut() {
            Some(run) if run.end == frame => run.end += 1,
            _ => runs.push(frame..frame + 1),
        }
    }
    runs
}

/// The unflagged frames before and after each frame, and how far between them it lies; a frame beyond the
/// first or last takes that one, and with none at all everyone takes itself.
pub(super) fn neighbours(flagged: &[bool]) -> Vec<(usize, usize, f64)> {
    let count = flagged.len();
    let mut before = vec![None; count];
    let mut after = vec![None; count];
    for frame in 0..count {
        before[frame] =
            if flagged[frame] { frame.checked_sub(1).and_then(|last| before[last]) } else { Some(frame) };
        let back = count - 1 - frame;
        after[back] = if flagged[back] { after.get(back + 1).copied().flatten() } else { Some(back) };
    }
    (0..count)
        .map(|frame| {
            let from = before[frame].or(after[frame]).unwrap_or(frame);
            let to = after[frame].unwrap_or(from);
            let share = if to > from { (frame - from) as f64 / (to - from) as f64 } else { 0.0 };
            (from, to, share)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spikes_of(signal: &[f64], cap: f64) -> Vec<bool> {
        spikes(&vec![false; signal.len()], cap, |flagged| {
            let filled: Vec<f64> = neighbours(flagged)
                .iter()
                .map(|&(from, to, share)| signal[from] + share * (signal[to] - signal[from]))
                .collect();
            filled.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect()
        })
    }

    fn wandering(count: usize) -> Vec<f64> {
        (0..count).map(|t| 0.01 * t as f64 + 0.004 * (t as f64 * 1.7).sin()).collect()
    }

    #[test]
    fn a_spike_is_flagged_and_a_steady_motion_is_not() {
        let mut signal = wandering(60);
        assert!(spikes_of(&signal, 0.2).iter().all(|flag| !flag));
        signal[30] += 0.5;
        let flagged = spikes_of(&signal, 0.2);
        assert!(flagged[30] && !flagged[27] && !flagged[33]);
    }

    #[test]
    fn one_good_frame_between_spikes_is_flagged_and_a_long_run_is_believed() {
        let mut signal = wandering(60);
        signal[30] += 0.5;
        signal[33] += 0.5;
        let flagged = spikes_of(&signal, 0.2);
        assert!(flagged[29..=34].iter().all(|flag| *flag), "{flagged:?}");
        // Another place for good is a motion: only its edge is flagged, and later frames stay.
        for value in &mut signal[40..] {
            *value += 1.0;
        }
        assert!(spikes_of(&signal, 0.2)[43..].iter().all(|flag| !flag));
        assert!(runs(&[true; 12]).iter().all(|run| run.len() > LONGEST));
    }

    #[test]
    fn gaps_are_bridged_from_their_ends() {
        let flagged = [true, false, true, true, false, true];
        let shares: Vec<f64> = neighbours(&flagged)
            .iter()
            .map(|&(from, to, share)| from as f64 + share * (to - from) as f64)
            .collect();
        assert_eq!(shares, [1.0, 1.0, 2.0, 3.0, 4.0, 4.0]);
    }
}
