//! Putting the time stamps of a source in order.

use super::{ClipFlag, SourceTime};

/// Turns raw time stamps into strictly increasing ticks from 0, and learns the frame interval.
#[derive(Debug)]
pub(super) struct Timing {
    /// Ticks of a nominal frame.
    nominal: i64,
    /// Added to raw stamps; set by the first one and by jumps backwards.
    offset: Option<i64>,
    last: Option<i64>,
    count: u32,
    /// Shortest and longest interval, and their sum.
    shortest: i64,
    longest: i64,
    intervals: Vec<i64>,
    pub(super) backwards: bool,
    pub(super) missing: bool,
}

impl Timing {
    /// `rate` is the nominal frame rate, `time_base` seconds a tick.
    pub(super) fn new(time_base: (u32, u32), rate: Option<(u32, u32)>) -> Self {
        let (frames, seconds) = rate.filter(|(n, d)| *n / d <= 1000).unwrap_or((30, 1));
        let ticks = f64::from(time_base.1) / f64::from(time_base.0) * f64::from(seconds) / f64::from(frames);
        Self {
            nominal: (ticks.round() as i64).max(1),
            offset: None,
            last: None,
            count: 0,
            shortest: i64::MAX,
            longest: 0,
            intervals: Vec::new(),
            backwards: false,
            missing: false,
        }
    }

    /// The place in time of the next frame with raw stamp `pts`.
    pub(super) fn push(&mut self, pts: Option<i64>) -> SourceTime {
        let ticks = self.ticks(pts);
        if let Some(last) = self.last {
            let interval = ticks - last;
            self.shortest = self.shortest.min(interval);
            self.longest = self.longest.max(interval);
            // A bounded sample is enough for the median.
            if self.intervals.len() < 4096 {
                self.intervals.push(interval);
            }
        }
        self.last = Some(ticks);
        self.count += 1;
        SourceTime { source_frame: self.count - 1, ticks }
    }

    fn ticks(&mut self, pts: Option<i64>) -> i64 {
        let Some(last) = self.last else {
            self.missing |= pts.is_none();
            self.offset = pts.map(i64::saturating_neg);
            return 0;
        };
        let Some(pts) = pts else {
            self.missing = true;
            return last.saturating_add(self.nominal);
        };
        let offset = *self.offset.get_or_insert_with(|| last.saturating_add(self.nominal) - pts);
        let ticks = pts.saturating_add(offset);
        if ticks > last {
            return ticks;
        }
        self.backwards = true;
        // A small step back is jitter: the next stamps are right again. A large one is a new
        // start of the clock: what follows is shifted along.
        if last - ticks <= 10 * self.nominal {
            return last + 1;
        }
        self.offset = Some(last.saturating_add(self.nominal).saturating_sub(pts));
        last.saturating_add(self.nominal)
    }

    /// Frames so far.
    pub(super) fn count(&self) -> u32 {
        self.count
    }

    /// Ticks of the last frame.
    pub(super) fn last(&self) -> i64 {
        self.last.unwrap_or(0)
    }

    /// How long the last frame is taken to last: the median interval, or the nominal one.
    pub(super) fn last_duration(&self) -> i64 {
        let mut sorted = self.intervals.clone();
        sorted.sort_unstable();
        sorted.get(sorted.len() / 2).copied().unwrap_or(self.nominal)
    }

    /// What the time stamps are to be flagged with.
    pub(super) fn flags(&self) -> Vec<ClipFlag> {
        let typical = self.last_duration();
        // One tick of rounding is no variation.
        let slack = typical / 10 + 1;
        let varies = self.count > 1 && (self.longest > typical + slack || self.shortest < typical - slack);
        let mut flags = Vec::new();
        if varies {
            flags.push(ClipFlag::VariableFrameRate);
        }
        if self.backwards {
            flags.push(ClipFlag::NonMonotonicPts);
        }
        if self.missing {
            flags.push(ClipFlag::MissingPts);
        }
        flags
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(stamps: &[Option<i64>]) -> (Vec<i64>, Vec<ClipFlag>) {
        let mut timing = Timing::new((1, 300), Some((30, 1)));
        let ticks = stamps.iter().map(|stamp| timing.push(*stamp).ticks).collect();
        (ticks, timing.flags())
    }

    #[test]
    fn steady_stamps_start_at_zero_without_flags() {
        assert_eq!(ticks(&[Some(70), Some(80), Some(90)]), (vec![0, 10, 20], vec![]));
    }

    #[test]
    fn missing_stamps_are_filled_at_the_nominal_rate() {
        assert_eq!(ticks(&[None, None, None]), (vec![0, 10, 20], vec![ClipFlag::MissingPts]));
    }

    #[test]
    fn a_doubled_stamp_moves_one_tick_and_a_restarted_clock_goes_on() {
        let (times, flags) = ticks(&[Some(1000), Some(1010), Some(1010), Some(1030), Some(5), Some(15)]);
        assert_eq!(times, [0, 10, 11, 30, 40, 50]);
        assert!(flags.contains(&ClipFlag::NonMonotonicPts));
    }
}
