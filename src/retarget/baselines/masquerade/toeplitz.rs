//! Symmetric positive definite Toeplitz systems, as evenly spaced samples of a stationary process give.

/// What solving a system tells about its right-hand side as a Gaussian sample.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ToeplitzSolution {
    /// K⁻¹ y.
    pub solution: Vec<f64>,
    /// ln p(y) of y ~ N(0, K).
    pub log_likelihood: f64,
}

/// Solves K x = y where K[i][j] = `column`[|i − j|], exactly and in O(n²) time and O(n) memory (Levinson 1947,
/// Durbin 1960: the best predictors of each sample from those before it; their errors whiten y). `None` when
/// K is not positive definite to working precision.
pub(super) fn solve(column: &[f64], values: &[f64]) -> Option<ToeplitzSolution> {
    let mut predictor: Vec<f64> = Vec::with_capacity(values.len());
    let mut previous = predictor.clone();
    let mut solution = Vec::with_capacity(values.len());
    let mut variance = *column.first()?;
    let mut log_likelihood = 0.0;
    for (order, value) in values.iter().enumerate() {
        if order > 0 {
            let known: f64 = predictor.iter().zip(column[1..order].iter().rev()).map(|(a, b)| a * b).sum();
            let reflection = (column[order] - known) / variance;
            previous.clone_from(&predictor);
            for (coefficient, mirrored) in predictor.iter_mut().zip(previous.iter().rev()) {
                *coefficient -= reflection * mirrored;
            }
            predictor.push(reflection);
            variance *= 1.0 - reflection * reflection;
        }
        if !(variance.is_finite() && variance > 0.0) {
            return None;
        }
        // predictor[j] weighs the sample j + 1 before this one.
        let predicted: f64 = predictor.iter().zip(values[..order].iter().rev()).map(|(a, b)| a * b).sum();
        let error = value - predicted;
        let step = error / variance;
        for (entry, coefficient) in solution.iter_mut().zip(predictor.iter().rev()) {
            *entry -= step * coefficient;
        }
        solution.push(step);
        log_likelihood -= 0.5 * (variance.ln() + error * step + std::f64::consts::TAU.ln());
    }
    Some(ToeplitzSolution { solution, log_likelihood })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Cholesky, DMatrix, DVector};

    use super::*;

    #[test]
    fn it_agrees_with_cholesky() {
        let column: Vec<f64> =
            (0..40).map(|k| (-0.02 * f64::from(k * k)).exp() + if k == 0 { 0.05 } else { 0.0 }).collect();
        let values: Vec<f64> = (0..40).map(|k| (0.3 * f64::from(k)).sin() + 0.2 * f64::from(k % 3)).collect();
        let found = solve(&column, &values).unwrap();
        let matrix = DMatrix::from_fn(40, 40, |i, j| column[i.abs_diff(j)]);
        let right = DVector::from_column_slice(&values);
        let factor = Cholesky::new(matrix).unwrap();
        let exact = factor.solve(&right);
        assert!(found.solution.iter().zip(exact.iter()).all(|(a, b)| (a - b).abs() < 1e-9));
        let log_determinant: f64 = factor.l_dirty().diagonal().iter().map(|v| 2.0 * v.ln()).sum();
        let expected = -0.5 * (right.dot(&exact) + log_determinant + 40.0 * std::f64::consts::TAU.ln());
        assert!((found.log_likelihood - expected).abs() < 1e-9);
    }
}
