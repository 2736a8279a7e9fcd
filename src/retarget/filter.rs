//! Filters over one signal: the exponential moving average, rate limits.

/// The method's moving average `q_t = α q̂_t + (1−α) q_{t−1}`, from the first sample on, in place.
pub fn moving_average(values: &mut [f64], alpha: f64) {
    for t in 1..values.len() {
        values[t] = alpha * values[t] + (1.0 - alpha) * values[t - 1];
    }
}

/// The moving average forward and then backward: the same smoothing twice, without lag.
pub fn moving_average_zero_phase(values: &mut [f64], alpha: f64) {
    moving_average(values, alpha);
    values.reverse();
    moving_average(values, alpha);
    values.reverse();
}

/// Holds the change from sample to sample within `step`, in place, without lag: the mean of a limiter that
/// runs forward (late) and one that runs backward (early). Both keep the limit, so their mean does, and a
/// signal that keeps it already is returned as it is.
pub fn limit_rate(values: &mut [f64], step: f64) {
    let mut early = values.to_vec();
    for t in 1..values.len() {
        values[t] = values[t].clamp(values[t - 1] - step, values[t - 1] + step);
    }
    for t in (1..early.len()).rev() {
        early[t - 1] = early[t - 1].clamp(early[t] - step, early[t] + step);
    }
    for (late, early) in values.iter_mut().zip(early) {
        *late += 0.5 * (early - *late);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_zero_phase_average_does_not_move_a_peak() {
        let mut bump: Vec<f64> = (0..41).map(|t| (-0.02 * f64::from((t - 20) * (t - 20))).exp()).collect();
        moving_average_zero_phase(&mut bump, 0.4);
        let peak = (0..41).max_by(|&a, &b| bump[a].total_cmp(&bump[b])).unwrap();
        assert_eq!(peak, 20);
    }

    proptest! {
        #[test]
        fn rate_limited_signals_keep_the_rate_and_kept_ones_stay(
            mut values in prop::collection::vec(-3.0_f64..3.0, 1..80),
            step in 0.01_f64..1.0,
        ) {
            limit_rate(&mut values, step);
            prop_assert!(values.windows(2).all(|w| (w[1] - w[0]).abs() <= step + 1e-12));
            let again = { let mut copy = values.clone(); limit_rate(&mut copy, step); copy };
            prop_assert!(again.iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-12));
        }
    }
}
