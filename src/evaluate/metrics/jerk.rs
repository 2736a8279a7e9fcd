//! Log dimensionless jerk of a speed profile.

/// The log dimensionless jerk (Balasubramanian et al. 2015; Hogan and Sternad 2009) of `speed` sampled at `fps`:
/// −ln(T³ / v²ₘₐₓ · Σ(Δ²v / Δt²)² Δt) with T the number of samples times Δt. Nearer to zero is smoother. Unlike the
/// spectral measures it grows with white jitter however little.
///
/// `None` for fewer than 4 samples, values that are not finite, a standstill, or no jerk at all.
pub fn log_dimensionless_jerk(speed: &[f64], fps: f64) -> Option<f64> {
    let usable = speed.len() >= 4 && speed.iter().all(|value| value.is_finite());
    let peak = speed.iter().copied().fold(0.0, |peak: f64, value| peak.max(value.abs()));
    if !(usable && peak > 0.0 && fps.is_finite() && fps > 0.0) {
        return None;
    }
    let duration = speed.len() as f64 / fps;
    let second = speed.windows(3).map(|v| (v[2] - 2.0 * v[1] + v[0]) * fps * fps / peak);
    let jerk = duration.powi(3) * second.map(|value| value * value).sum::<f64>() / fps;
    (jerk > 0.0).then(|| -jerk.ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn minimum_jerk(samples: usize) -> Vec<f64> {
        let at = |k: usize| k as f64 / (samples - 1) as f64;
        (0..samples).map(at).map(|x| 30.0 * x.powi(2) - 60.0 * x.powi(3) + 30.0 * x.powi(4)).collect()
    }

    #[test]
    fn a_minimum_jerk_movement_has_the_value_of_its_integral() {
        // ∫(v″)² = 720 and v²ₘₐₓ = 1.875² for a movement of one metre in one second.
        let found = log_dimensionless_jerk(&minimum_jerk(20_001), 20_000.0).unwrap();
        assert!((found + (720.0_f64 / 1.875 / 1.875).ln()).abs() < 1e-3, "{found}");
    }

    #[test]
    fn jitter_makes_it_worse_and_a_steady_or_absent_movement_has_none() {
        let smooth = minimum_jerk(61);
        let rough: Vec<f64> =
            smooth.iter().enumerate().map(|(k, v)| v + if k % 2 == 0 { 0.02 } else { 0.0 }).collect();
        let value = |speed: &[f64]| log_dimensionless_jerk(speed, 30.0).unwrap();
        assert!(value(&rough) < value(&smooth) - 1.0);
        for speed in [vec![1.0; 40], vec![0.0; 40], vec![1.0, 2.0, 1.0], vec![f64::INFINITY; 9]] {
            assert_eq!(log_dimensionless_jerk(&speed, 30.0), None);
        }
    }
}
