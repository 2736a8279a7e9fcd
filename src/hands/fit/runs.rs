//! Which frames are fitted together: runs of seen frames with short gaps between.

use std::ops::Range;

/// Splits a clip into runs that begin and end with a seen frame, hold no gap longer than
/// `longest_gap` frames and at least `shortest` seen frames.
pub(super) fn runs(seen: &[bool], longest_gap: usize, shortest: usize) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (frame, _) in seen.iter().enumerate().filter(|(_, seen)| **seen) {
        match runs.last_mut() {
            Some(run) if frame - run.end <= longest_gap => run.end = frame + 1,
            _ => runs.push(frame..frame + 1),
        }
    }
    runs.retain(|run| seen[run.clone()].iter().filter(|s| **s).count() >= shortest);
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_bridged_up_to_the_stated_length_and_no_further() {
        let mut seen = vec![true; 30];
        seen[5..9].fill(false);
        seen[15..20].fill(false);
        assert_eq!(runs(&seen, 4, 1), [0..15, 20..30]);
        assert_eq!(runs(&seen, 5, 1), std::slice::from_ref(&(0..30)));
    }

    #[test]
    fn short_runs_and_the_clips_ends_are_left_out() {
        let seen = [false, true, true, false, false, false, true, false];
        assert_eq!(runs(&seen, 1, 2), std::slice::from_ref(&(1..3)));
    }
}
