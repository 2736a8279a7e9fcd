//! Percentile bootstrap of a mean (Efron 1979).

use serde::{Deserialize, Serialize};

use super::SplitMix64;

/// How an interval is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bootstrap {
    /// Resamples.
    pub resamples: usize,
    /// Seed of the resampling.
    pub seed: u64,
}

impl Default for Bootstrap {
    /// 10,000 resamples.
    fn default() -> Self {
        Self { resamples: 10_000, seed: 20_260_101 }
    }
}

/// A mean and its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Lower and upper end of the 95 % interval.
    pub ci95: [f64; 2],
}

impl Estimate {
    /// Whether the interval lies on one side of zero.
    pub fn is_clear_of_zero(&self) -> bool {
        self.ci95[0] > 0.0 || self.ci95[1] < 0.0
    }
}

impl Bootstrap {
    /// What a report says about the method.
    pub fn describe(&self) -> String {
        format!(
            "percentile bootstrap of the mean over episodes, B = {}, 2.5 and 97.5 % with linear interpolation (type 7), \
             SplitMix64 seed {}",
            self.resamples, self.seed
        )
    }

    /// The mean of `values`, one an episode, with its interval; `None` of none.
    pub fn mean(&self, values: &[f64]) -> Option<Estimate> {
        let mut random = SplitMix64::new(self.seed);
        let resampled = (0..self.resamples).map(|_| {
            let sum: f64 = (0..values.len()).map(|_| values[random.next_below(values.len())]).sum();
            sum / values.len() as f64
        });
        (!values.is_empty()).then(|| estimate(values, resampled.collect()))
    }

    /// The mean of `a − b` over the episodes that have both, with its interval: what is common to an episode, its
    /// length and its number of movements, drops out.
    pub fn paired(&self, a: &[Option<f64>], b: &[Option<f64>]) -> Option<Estimate> {
        let differences: Vec<f64> = a.iter().zip(b).filter_map(|(a, b)| Some((*a)? - (*b)?)).collect();
        self.mean(&differences)
    }
}

/// The same interval over all nⁿ equally likely resamples, instead of a random choice of them, for up to 6 values;
/// `None` for more, or none.
pub fn exact_bootstrap(values: &[f64]) -> Option<Estimate> {
    let n = values.len();
    if !(1..=6).contains(&n) {
        return None;
    }
    let resampled = (0..n.pow(n as u32)).map(|mut code| {
        let mut sum = 0.0;
        for _ in 0..n {
            sum += values[code % n];
            code /= n;
        }
        sum / n as f64
    });
    Some(estimate(values, resampled.collect()))
}

fn estimate(values: &[f64], mut resampled: Vec<f64>) -> Estimate {
    resampled.sort_by(f64::total_cmp);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    Estimate { mean, ci95: [0.025, 0.975].map(|share| quantile(&resampled, share)) }
}

/// Linear interpolation between order statistics (type 7 of Hyndman and Fan 1996).
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() as f64 - 1.0).max(0.0);
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    match (sorted.get(below), sorted.get(above)) {
        (Some(low), Some(high)) => low + (high - low) * (place - below as f64),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_samples_have_their_exact_intervals() {
        let exact = exact_bootstrap(&[1.0, 2.0, 3.0, 4.0]).unwrap();
        assert_eq!(exact, Estimate { mean: 2.5, ci95: [1.5, 3.5] });
        let exact = exact_bootstrap(&[-5.0, -5.2, -5.6, -4.9, -5.3]).unwrap();
        assert!((exact.ci95[0] + 5.42).abs() < 1e-12 && (exact.ci95[1] + 5.0).abs() < 1e-12, "{exact:?}");
        assert!(exact_bootstrap(&[]).is_none() && exact_bootstrap(&[0.0; 7]).is_none());
    }

    #[test]
    fn seventy_five_episodes_have_the_published_interval() {
        let values: Vec<f64> =
            (0..75).map(f64::from).map(|i| -(5.0 + 0.5 * (1.7 * i).sin() + 0.3 * (0.9 * i).cos())).collect();
        let found = Bootstrap::default().mean(&values).unwrap();
        assert!((found.mean + 4.998_432_255_124_708).abs() < 1e-12, "{found:?}");
        assert!((found.ci95[0] + 5.093_323_662_319_214).abs() < 1e-12, "{found:?}");
        assert!((found.ci95[1] + 4.902_779_137_287_301).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_paired_difference_is_sharper_than_the_two_means() {
        let a: Vec<Option<f64>> = (0..40).map(|i| Some(f64::from(i % 10))).collect();
        let b: Vec<Option<f64>> = a.iter().map(|value| value.map(|value| value + 0.1)).collect();
        let found = Bootstrap::default().paired(&a, &b).unwrap();
        assert!((found.mean + 0.1).abs() < 1e-12 && found.is_clear_of_zero());
        assert!(Bootstrap::default().paired(&[None], &[Some(1.0)]).is_none());
        assert!(Bootstrap::default().mean(&[]).is_none());
    }
}
