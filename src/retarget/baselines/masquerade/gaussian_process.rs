//! Gaussian-process smoothing of one signal over the frame index.

use super::{simplex, toeplitz};

/// Bounds of both hyperparameters.
const BOUNDS: [f64; 2] = [1e-5, 1e5];
/// Longer signals are fitted on so many samples from their middle; smoothing them is exact all the same.
const FITTED_AT_MOST: usize = 1200;

/// ℓ and σ² of the kernel exp(−(i−j)²/2ℓ²) + σ² δᵢⱼ over frame indices, signal of unit variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hyperparameters {
    pub length: f64,
    pub noise: f64,
}

impl Hyperparameters {
    /// Where the search begins.
    const START: Self = Self { length: 1.0, noise: 1.0 };

    fn from_logarithms([length, noise]: [f64; 2]) -> Self {
        let bounded = |log: f64| log.exp().clamp(BOUNDS[0], BOUNDS[1]);
        Self { length: bounded(length), noise: bounded(noise) }
    }

    /// First column of K.
    fn kernel(&self, count: usize) -> Vec<f64> {
        let rbf = |lag: usize| (-0.5 * (lag as f64 / self.length).powi(2)).exp();
        (0..count).map(|lag| rbf(lag) + if lag == 0 { self.noise } else { 0.0 }).collect()
    }

    /// The most likely ones for `values`, downhill from (1, 1) within the bounds.
    pub fn fit(values: &[f64]) -> Self {
        let spare = values.len().saturating_sub(FITTED_AT_MOST) / 2;
        let fitted = &values[spare..values.len() - spare];
        let start = [Self::START.length.ln(), Self::START.noise.ln()];
        let cost = |logarithms: &[f64; 2]| {
            let kernel = Self::from_logarithms(*logarithms).kernel(fitted.len());
            toeplitz::solve(&kernel, fitted).map_or(f64::INFINITY, |found| -found.log_likelihood)
        };
        Self::from_logarithms(simplex::minimise(cost, start, 1.0, 1e-3))
    }
}

/// `values` smoothed: K_rbf (K_rbf + σ²I)⁻¹ y with the most likely hyperparameters, y normalised to mean 0 and
/// variance 1 and back.
///
/// Exact inference: the samples are evenly spaced, so K is Toeplitz and n samples cost n² operations (0.1 s for
/// a signal of a minute at 15 Hz, most of it for the hyperparameters). Signals of more than 1200 samples are
/// fitted on the 1200 in their middle.
pub(super) fn smooth(values: &[f64]) -> Vec<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let spread = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
    if values.len() < 3 || spread < 1e-9 {
        return values.to_vec();
    }
    let normal: Vec<f64> = values.iter().map(|value| (value - mean) / spread).collect();
    let fitted = Hyperparameters::fit(&normal);
    match toeplitz::solve(&fitted.kernel(normal.len()), &normal) {
        // K_rbf α = (K − σ²I) α = y − σ² α.
        Some(found) => normal
            .iter()
            .zip(found.solution)
            .map(|(value, weight)| mean + spread * (value - fitted.noise * weight))
            .collect(),
        None => values.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(index: usize) -> f64 {
        ((index as f64 * 12.9898).sin() * 43758.5453).rem_euclid(1.0) - 0.5
    }

    #[test]
    fn noise_on_a_slow_wave_is_taken_out() {
        let truth: Vec<f64> = (0..150).map(|t| 2.0 + (0.06 * f64::from(t)).sin()).collect();
        let noisy: Vec<f64> = truth.iter().enumerate().map(|(t, v)| v + 0.3 * noise(t)).collect();
        let error = |found: &[f64]| {
            (found.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 150.0).sqrt()
        };
        let smoothed = smooth(&noisy);
        assert!(error(&smoothed) < 0.4 * error(&noisy), "{} {}", error(&smoothed), error(&noisy));
    }

    #[test]
    fn a_clean_wave_is_left_alone_and_found_to_be_clean() {
        let clean: Vec<f64> = (0..120).map(|t| (0.1 * f64::from(t)).sin()).collect();
        let smoothed = smooth(&clean);
        assert!(smoothed.iter().zip(&clean).all(|(a, b)| (a - b).abs() < 2e-3));
        let spread = (clean.iter().map(|v| v * v).sum::<f64>() / 120.0).sqrt();
        let normal: Vec<f64> = clean.iter().map(|v| v / spread).collect();
        assert!(Hyperparameters::fit(&normal).noise < 1e-3);
    }

    #[test]
    fn the_fit_is_a_maximum_of_the_likelihood() {
        let values: Vec<f64> = (0..80).map(|t| (0.15 * t as f64).sin() * 1.3 + 0.5 * noise(t)).collect();
        let best = Hyperparameters::fit(&values);
        let likelihood =
            |found: Hyperparameters| toeplitz::solve(&found.kernel(80), &values).unwrap().log_likelihood;
        for factor in [0.98, 1.02] {
            let other = Hyperparameters { length: best.length * factor, ..best };
            assert!(likelihood(other) <= likelihood(best) + 1e-9);
            let other = Hyperparameters { noise: best.noise * factor, ..best };
            assert!(likelihood(other) <= likelihood(best) + 1e-9);
        }
    }

    #[test]
    fn constant_and_short_signals_pass() {
        assert_eq!(smooth(&[0.4; 10]), vec![0.4; 10]);
        assert_eq!(smooth(&[1.0, 2.0]), vec![1.0, 2.0]);
        assert!(smooth(&[]).is_empty());
    }
}
