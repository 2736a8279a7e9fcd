//! Statistics of a feature, as LeRobot stores them.

use serde::{Deserialize, Serialize};

/// The quantiles LeRobot knows.
const QUANTILES: [f64; 5] = [0.01, 0.10, 0.50, 0.90, 0.99];

/// One number a dimension. The standard deviation is the population's; quantiles are interpolated linearly.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FeatureStats {
    /// Least.
    pub min: Vec<f64>,
    /// Greatest.
    pub max: Vec<f64>,
    /// Mean.
    pub mean: Vec<f64>,
    /// Standard deviation.
    pub std: Vec<f64>,
    /// Quantiles at 1, 10, 50, 90 and 99 %.
    pub quantiles: [Vec<f64>; 5],
    /// How many values each dimension has.
    pub count: u64,
}

impl FeatureStats {
    /// The names of the quantiles, in order.
    pub const QUANTILE_NAMES: [&'static str; 5] = ["q01", "q10", "q50", "q90", "q99"];

    /// Of columns, all equally long. Empty columns have no statistics: zeros, counted 0 times.
    pub fn of_columns(columns: Vec<Vec<f32>>) -> Self {
        let count = columns.first().map_or(0, Vec::len);
        let mut stats = Self { count: count as u64, ..Self::default() };
        for mut column in columns {
            column.sort_unstable_by(f32::total_cmp);
            let n = column.len().max(1) as f64;
            // Sorted, so that the sums do not depend on the order of episodes either.
            let mean = column.iter().map(|value| f64::from(*value)).sum::<f64>() / n;
            let square = column.iter().map(|value| (f64::from(*value) - mean).powi(2)).sum::<f64>() / n;
            stats.push(mean, square.sqrt(), |share| quantile(&column, share));
        }
        stats
    }

    /// The statistics of the three channels of pictures, 0 to 1, counted in pictures.
    pub fn of_pictures(channels: &[Histogram; 3], pictures: u64) -> Self {
        let mut stats = Self { count: pictures, ..Self::default() };
        for channel in channels {
            let (mean, deviation) = channel.mean_and_deviation();
            stats.push(mean, deviation, |share| channel.quantile(share));
        }
        stats
    }

    fn push(&mut self, mean: f64, deviation: f64, quantile: impl Fn(f64) -> f64) {
        self.min.push(quantile(0.0));
        self.max.push(quantile(1.0));
        self.mean.push(mean);
        self.std.push(deviation);
        for (values, share) in self.quantiles.iter_mut().zip(QUANTILES) {
            values.push(quantile(share));
        }
    }

    /// Every statistic but the count with its name.
    pub fn named(&self) -> Vec<(&'static str, &[f64])> {
        let mut all: Vec<(&'static str, &[f64])> =
            vec![("min", &self.min), ("max", &self.max), ("mean", &self.mean), ("std", &self.std)];
        all.extend(Self::QUANTILE_NAMES.into_iter().zip(self.quantiles.iter().map(Vec::as_slice)));
        all
    }
}

/// Linear interpolation between the values around the place `share` of the way (NumPy's default).
fn quantile(sorted: &[f32], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    between(share * last as f64, |at| f64::from(sorted[at.min(last)]))
}

fn between(place: f64, value: impl Fn(usize) -> f64) -> f64 {
    let below = place.floor();
    let (a, b) = (value(below as usize), value(below as usize + 1));
    a + (b - a) * (place - below)
}

/// How often each of 256 levels occurs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Histogram {
    counts: Vec<u64>,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: vec![0; 256] }
    }
}

impl Histogram {
    /// Counts one level.
    pub fn add(&mut self, level: u8) {
        self.counts[usize::from(level)] += 1;
    }

    /// Adds the counts of `other`.
    pub fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.counts.iter_mut().zip(&other.counts) {
            *mine += theirs;
        }
    }

    /// Whether it has 256 levels, as one that was read must have.
    pub fn is_sound(&self) -> bool {
        self.counts.len() == 256
    }

    fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    fn mean_and_deviation(&self) -> (f64, f64) {
        let n = self.total().max(1) as f64;
        let sum = |of: &dyn Fn(f64) -> f64| -> f64 {
            let levels = self.counts.iter().enumerate();
            levels.map(|(level, count)| of(level as f64 / 255.0) * *count as f64).sum::<f64>() / n
        };
        let mean = sum(&|value| value);
        (mean, sum(&|value| (value - mean).powi(2)).sqrt())
    }

    fn quantile(&self, share: f64) -> f64 {
        let Some(last) = self.total().checked_sub(1) else { return 0.0 };
        between(share * last as f64, |at| self.level_at((at as u64).min(last)))
    }

    /// The level of the value at place `at` in order, 0 to 1.
    fn level_at(&self, at: u64) -> f64 {
        let mut passed = 0;
        let level = self.counts.iter().position(|count| {
            passed += count;
            passed > at
        });
        level.unwrap_or(255) as f64 / 255.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_interpolated_as_numpy_does_it() {
        let stats = FeatureStats::of_columns(vec![vec![3.0, 1.0, 2.0, 4.0], vec![5.0; 4]]);
        // numpy.quantile([1, 2, 3, 4], [.01, .1, .5, .9, .99])
        let expected = [1.03, 1.3, 2.5, 3.7, 3.97];
        for (values, expected) in stats.quantiles.iter().zip(expected) {
            assert!((values[0] - expected).abs() < 1e-12 && values[1] == 5.0);
        }
        assert_eq!((stats.min[0], stats.max[0], stats.mean[0], stats.std[1]), (1.0, 4.0, 2.5, 0.0));
        assert!((stats.std[0] - 1.25_f64.sqrt()).abs() < 1e-12 && stats.count == 4);
    }

    #[test]
    fn a_histogram_says_the_same_as_the_levels_themselves() {
        let levels = [0_u8, 17, 17, 200, 255, 3, 90];
        let mut histogram = Histogram::default();
        levels.iter().for_each(|level| histogram.add(*level));
        let pictures = FeatureStats::of_pictures(&[histogram.clone(), histogram.clone(), histogram], 1);
        let column = levels.iter().map(|level| f32::from(*level)).collect();
        let direct = FeatureStats::of_columns(vec![column]);
        for ((_, a), (_, b)) in pictures.named().into_iter().zip(direct.named()) {
            assert!((a[0] - b[0] / 255.0).abs() < 1e-9);
        }
    }
}
