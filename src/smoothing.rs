//! A robust zero-phase smoother for measured signals.

/// Zero-phase smoothing of unevenly trusted samples with outliers held off.
///
/// A Whittaker smoother (Eilers 2003, "A perfect smoother") with third differences: minimises
/// Σ wᵢ (zᵢ − yᵢ)² + λ Σ (Δ³z)², where λ puts the half-power point at `cutoff` cycles a sample. Residuals beyond
/// 2.5 robust standard deviations, but at least `floor` (units of the signal), lose weight in proportion
/// (Huber), re-fitted three times. A sample without weight is interpolated.
///
/// Several signals are outliers together: the residual is the norm over all of them.
pub fn smooth_together(signals: &[&[f64]], weights: &[f64], cutoff: f64, floor: f64) -> Vec<Vec<f64>> {
    let length = weights.len();
    let mut smoothed: Vec<Vec<f64>> = signals.iter().map(|signal| signal.to_vec()).collect();
    // Above half of the Nyquist frequency there is nothing to smooth.
    if length < 4 || cutoff >= 0.45 {
        return smoothed;
    }
    let lambda = (2.0 * (std::f64::consts::PI * cutoff).sin()).powi(-6);
    let mut trust = weights.to_vec();
    for round in 0..4 {
        let system = Banded::factor(&trust, lambda);
        for (signal, out) in signals.iter().zip(&mut smoothed) {
            *out = signal.iter().zip(&trust).map(|(value, weight)| value * weight).collect();
            system.solve(out);
        }
        if round == 3 {
            break;
        }
        let residuals: Vec<f64> = (0..length)
            .map(|t| signals.iter().zip(&smoothed).map(|(s, z)| (s[t] - z[t]).powi(2)).sum::<f64>().sqrt())
            .collect();
        let bound = (2.5 * 1.4826 * median(&residuals)).max(floor);
        for t in 0..length {
            trust[t] = weights[t] * (bound / residuals[t].max(bound));
        }
    }
    smoothed
}

/// The median of finite values; 0 of none.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

/// LDLᵀ of the smoother's matrix: bandwidth 3.
struct Banded {
    diagonal: Vec<f64>,
    /// `below[i][k]` is L[i, i − 1 − k].
    below: Vec<[f64; 3]>,
}

impl Banded {
    fn factor(weights: &[f64], lambda: f64) -> Self {
        const THIRD: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];
        let n = weights.len();
        let mut diagonal: Vec<f64> = weights.iter().map(|w| w.max(1e-9)).collect();
        let mut below = vec![[0.0; 3]; n];
        for start in 0..n - 3 {
            for row in 0..4 {
                diagonal[start + row] += lambda * THIRD[row] * THIRD[row];
                for column in 0..row {
                    below[start + row][row - column - 1] += lambda * THIRD[row] * THIRD[column];
                }
            }
        }
        for i in 0..n {
            // Columns from left to right, each needing the ones further left.
            for k in (0..3.min(i)).rev() {
                let j = i - 1 - k;
                let mut value = below[i][k];
                for m in (k + 1)..3.min(i) {
                    let column = i - 1 - m;
                    let in_j = j - column - 1;
                    if in_j < 3 {
                        value -= below[i][m] * diagonal[column] * below[j][in_j];
                    }
                }
                below[i][k] = value / diagonal[j];
            }
            let taken: f64 = (0..3.min(i)).map(|k| below[i][k].powi(2) * diagonal[i - 1 - k]).sum();
            diagonal[i] -= taken;
        }
        Self { diagonal, below }
    }

    fn solve(&self, x: &mut [f64]) {
        let n = x.len();
        for i in 0..n {
            for k in 0..3.min(i) {
                x[i] -= self.below[i][k] * x[i - 1 - k];
            }
        }
        for (value, pivot) in x.iter_mut().zip(&self.diagonal) {
            *value /= pivot;
        }
        for i in (0..n).rev() {
            for k in 0..3.min(i) {
                x[i - 1 - k] -= self.below[i][k] * x[i];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_passes_unchanged_and_a_spike_is_taken_out() {
        let truth: Vec<f64> = (0..60).map(|t| 0.001 * f64::from(t * t)).collect();
        let mut spiked = truth.clone();
        spiked[30] += 5.0;
        let weights = vec![1.0; 60];
        let clean = smooth_together(&[&truth], &weights, 0.1, 0.01).swap_remove(0);
        assert!(clean.iter().zip(&truth).all(|(a, b)| (a - b).abs() < 1e-6));
        let healed = smooth_together(&[&spiked], &weights, 0.1, 0.01).swap_remove(0);
        assert!(healed.iter().zip(&truth).all(|(a, b)| (a - b).abs() < 0.1));
    }

    #[test]
    fn half_of_the_amplitude_is_left_at_the_cutoff() {
        let wave: Vec<f64> =
            (0..300).map(|t| (2.0 * std::f64::consts::PI * 3.0 * f64::from(t) / 30.0).sin()).collect();
        let smoothed = smooth_together(&[&wave], &vec![1.0; 300], 0.1, 10.0).swap_remove(0);
        let gain = smoothed[100..200].iter().fold(0.0, |peak: f64, v| peak.max(v.abs()))
            / wave[100..200].iter().fold(0.0, |peak: f64, v| peak.max(v.abs()));
        assert!((gain - 0.5).abs() < 0.01, "{gain}");
    }
}
