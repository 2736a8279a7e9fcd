//! The standard timeline: which source frame stands at each 1/30 s.

use serde::{Deserialize, Serialize};

use super::FrameIndex;

/// Standard frames a second, as an integer for exact arithmetic.
const FPS: i128 = 30;

/// One frame of the standard timeline.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameRow {
    /// Its identity.
    pub index: FrameIndex,
    /// Its time, seconds: `index / 30`.
    pub pts: f64,
    /// The frame of the source shown then, counted from 0 at the start of the file.
    pub source_frame: u32,
    /// That frame's own time, seconds after the first frame of the file.
    pub source_pts: f64,
    /// Its place in the frame store.
    pub stored: u32,
}

/// A source frame's time in exact ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SourceTime {
    /// Number in the source.
    pub source_frame: u32,
    /// Ticks after the first frame of the file.
    pub ticks: i64,
}

/// Assigns source frames to the standard timeline while they stream by.
///
/// At time `t = k/30` stands the source frame nearest to `t` among those less than half a standard
/// frame away, else the last one before `t`: what a viewer sees at `t`, without the stutter that
/// 29.97 Hz or jittering stamps would bring. All arithmetic is on integer ticks.
#[derive(Debug)]
pub struct Resampler {
    /// Seconds a tick, as a fraction.
    time_base: (u32, u32),
    /// Ticks of the file's time where the standard timeline has its zero.
    origin: i64,
    previous: Option<(SourceTime, Option<u32>)>,
    stored: u32,
    rows: Vec<FrameRow>,
}

/// What to do with the frame before the one just announced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// It stands on the timeline and must be stored, now.
    pub store_previous: bool,
}

impl Resampler {
    /// An empty timeline whose zero lies `origin` ticks after the first frame of the file.
    pub fn new(time_base: (u32, u32), origin: i64) -> Self {
        Self { time_base, origin, previous: None, stored: 0, rows: Vec::new() }
    }

    /// Announces the next source frame, `ticks` strictly after the one before.
    pub fn push(&mut self, time: SourceTime) -> Decision {
        let mut store_previous = false;
        if let Some((previous, mut place)) = self.previous {
            while self.target() <= self.units(time.ticks) && !self.prefers(time, previous) {
                store_previous |= place.is_none();
                self.add_row(previous, &mut place);
            }
        }
        self.previous = Some((time, None));
        Decision { store_previous }
    }

    /// Ends the timeline: the last frame lasts `duration` ticks.
    pub fn finish(mut self, duration: i64) -> (Decision, Vec<FrameRow>) {
        let mut store_previous = false;
        if let Some((previous, mut place)) = self.previous {
            let end = self.units(previous.ticks + duration);
            // A frame stands as long as at least half of it lies before the end; one always does.
            while self.target() + self.half() <= end || self.rows.is_empty() {
                store_previous |= place.is_none();
                self.add_row(previous, &mut place);
            }
        }
        (Decision { store_previous }, self.rows)
    }

    /// Rows so far.
    pub fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// Rows there will be once the timeline has reached `ticks` of the file's time.
    pub fn rows_until(&self, ticks: i64) -> u64 {
        let rows = self.units(ticks) / (2 * i128::from(self.time_base.1));
        u64::try_from(rows.max(0)).unwrap_or(u64::MAX)
    }

    fn add_row(&mut self, source: SourceTime, place: &mut Option<u32>) {
        let stored = *place.get_or_insert_with(|| {
            self.stored += 1;
            self.stored - 1
        });
        let index = self.rows.len() as u32;
        let tick = f64::from(self.time_base.0) / f64::from(self.time_base.1);
        self.rows.push(FrameRow {
            index: FrameIndex(index),
            pts: f64::from(index) / FPS as f64,
            source_frame: source.source_frame,
            source_pts: source.ticks as f64 * tick,
            stored,
        });
    }

    fn prefers(&self, next: SourceTime, previous: SourceTime) -> bool {
        let ahead = self.units(next.ticks) - self.target();
        let behind = (self.target() - self.units(previous.ticks)).abs();
        ahead < self.half() && ahead < behind
    }

    /// Ticks in units of `1 / (60 × denominator)` seconds, from the timeline's zero.
    fn units(&self, ticks: i64) -> i128 {
        i128::from(ticks - self.origin) * i128::from(self.time_base.0) * 2 * FPS
    }

    /// The time of the next row, in the same units.
    fn target(&self) -> i128 {
        self.rows.len() as i128 * 2 * i128::from(self.time_base.1)
    }

    /// Half a standard frame, in the same units.
    fn half(&self) -> i128 {
        i128::from(self.time_base.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Feeds frames at `ticks`; returns the rows, having checked that what is stored is in step.
    fn resample(time_base: (u32, u32), ticks: &[i64], last: i64) -> Vec<FrameRow> {
        let mut resampler = Resampler::new(time_base, 0);
        let mut stored = Vec::new();
        for (number, ticks) in ticks.iter().enumerate() {
            let time = SourceTime { source_frame: number as u32, ticks: *ticks };
            if resampler.push(time).store_previous {
                stored.push(number as u32 - 1);
            }
        }
        let (decision, rows) = resampler.finish(last);
        if decision.store_previous {
            stored.push(ticks.len() as u32 - 1);
        }
        for row in &rows {
            assert_eq!(stored[row.stored as usize], row.source_frame);
        }
        rows
    }

    fn constant(rate: (u32, u32), count: i64) -> Vec<u32> {
        let ticks: Vec<i64> = (0..count).map(|n| n * i64::from(rate.1)).collect();
        resample((1, rate.0), &ticks, i64::from(rate.1)).iter().map(|row| row.source_frame).collect()
    }

    #[test]
    fn fifteen_hertz_shows_every_frame_twice() {
        assert_eq!(constant((15, 1), 4), [0, 0, 1, 1, 2, 2, 3, 3]);
    }

    #[test]
    fn thirty_hertz_is_the_identity() {
        assert_eq!(constant((30, 1), 5), [0, 1, 2, 3, 4]);
    }

    #[test]
    fn sixty_and_120_hertz_show_every_second_and_fourth_frame() {
        assert_eq!(constant((60, 1), 6), [0, 2, 4]);
        assert_eq!(constant((120, 1), 12), [0, 4, 8]);
    }

    #[test]
    fn ntsc_is_one_to_one_and_repeats_one_frame_in_a_thousand() {
        let frames = constant((30_000, 1001), 1000);
        assert_eq!(frames.len(), 1001);
        let repeats = frames.windows(2).filter(|pair| pair[0] == pair[1]).count();
        assert_eq!(repeats, 1);
        assert!(frames.windows(2).all(|pair| pair[1] - pair[0] <= 1));
    }

    #[test]
    fn film_rate_shows_every_frame() {
        let frames = constant((24, 1), 8);
        assert_eq!(frames.len(), 10);
        assert!((0..8).all(|n| frames.contains(&n)));
    }

    #[test]
    fn a_long_gap_holds_the_frame_before_it() {
        let frames: Vec<u32> =
            resample((1, 1000), &[0, 33, 533, 566], 33).iter().map(|row| row.source_frame).collect();
        assert_eq!(frames.len(), 18);
        assert_eq!(frames[..16], [0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]);
        assert_eq!(frames[16..], [2, 3]);
    }

    #[test]
    fn one_frame_however_short_gives_one_row() {
        assert_eq!(resample((1, 1000), &[0], 1).len(), 1);
    }

    proptest! {
        #[test]
        fn rows_are_monotone_and_show_what_covers_their_time(
            steps in prop::collection::vec(1_i64..400, 1..80)
        ) {
            let ticks: Vec<i64> = std::iter::once(0)
                .chain(steps.iter().scan(0, |sum, step| { *sum += step; Some(*sum) }))
                .collect();
            let rows = resample((1, 1000), &ticks, 33);
            for pair in rows.windows(2) {
                prop_assert!(pair[1].source_frame >= pair[0].source_frame);
            }
            for row in &rows {
                prop_assert!(row.source_pts < row.pts + 1.0 / 60.0);
                let next = ticks.get(row.source_frame as usize + 1);
                prop_assert!(next.is_none_or(|next| *next as f64 / 1000.0 + 1e-9 >= row.pts));
            }
        }
    }
}
