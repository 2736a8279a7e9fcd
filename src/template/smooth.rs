//! Placements without jitter: still objects stand still, moving ones move smoothly.

use nalgebra::Matrix3;

use super::placement::Located;
use crate::segment::object::apply;

/// Smooths the path of three points of the template and refits the transforms.
///
/// Per coordinate, minimises `Σ w (p − measured)² + λ Σ ρ(second difference)` by reweighted least
/// squares (a Whittaker smoother whose penalty gives way at real accelerations), where `w` is the
/// evidence of the frame. `half_width` sets λ; 0 leaves everything as it is.
pub(crate) fn smooth(located: &mut [Located], centre: (f64, f64), radius: f64, half_width: u32) {
    if half_width == 0 || located.len() < 5 {
        return;
    }
    let corners = [
        (centre.0 - radius, centre.1 - radius),
        (centre.0 + radius, centre.1 - radius),
        (centre.0, centre.1 + radius),
    ];
    let weights: Vec<f64> = located.iter().map(|l| 0.003 + l.evidence * l.evidence).collect();
    let stiffness = f64::from(half_width).powi(4) / 4.0;
    let mut paths = Vec::new();
    for (x, y) in corners {
        let points: Vec<(f64, f64)> = located.iter().map(|l| apply(&l.transform, x, y)).collect();
        paths.push(whittaker(&points, &weights, stiffness));
    }
    for (at, entry) in located.iter_mut().enumerate() {
        let targets = [paths[0][at], paths[1][at], paths[2][at]];
        if let Some(transform) = affine_through(&corners, &targets) {
            entry.transform = transform;
        }
    }
}

/// The affine transform that takes three points to three others.
fn affine_through(from: &[(f64, f64); 3], to: &[(f64, f64); 3]) -> Option<Matrix3<f64>> {
    let column = |points: &[(f64, f64); 3]| {
        Matrix3::new(
            points[0].0,
            points[1].0,
            points[2].0,
            points[0].1,
            points[1].1,
            points[2].1,
            1.0,
            1.0,
            1.0,
        )
    };
    Some(column(to) * column(from).try_inverse()?)
}

fn whittaker(points: &[(f64, f64)], weights: &[f64], stiffness: f64) -> Vec<(f64, f64)> {
    let n = points.len();
    let mut path = points.to_vec();
    // Second differences beyond this many pixels a frame² are real accelerations.
    let knee = 0.6_f64;
    for _ in 0..6 {
        let penalty: Vec<f64> = (1..n - 1)
            .map(|k| {
                let bend = |p: fn(&(f64, f64)) -> f64| p(&path[k - 1]) - 2.0 * p(&path[k]) + p(&path[k + 1]);
                let size = bend(|p| p.0).hypot(bend(|p| p.1));
                stiffness / (1.0 + (size / knee).powi(2))
            })
            .collect();
        path = solve_banded(points, weights, &penalty);
    }
    path
}

/// Solves `(W + Dᵀ Λ D) p = W measured` for both coordinates, D the second difference: a symmetric
/// system with two off-diagonals, by LDLᵀ.
fn solve_banded(points: &[(f64, f64)], weights: &[f64], penalty: &[f64]) -> Vec<(f64, f64)> {
    let n = points.len();
    let (mut diagonal, mut first, mut second) = (weights.to_vec(), vec![0.0; n], vec![0.0; n]);
    for (k, lambda) in penalty.iter().enumerate() {
        for (offset, factor) in [1.0, 4.0, 1.0].into_iter().enumerate() {
            diagonal[k + offset] += lambda * factor;
        }
        first[k] -= 2.0 * lambda;
        first[k + 1] -= 2.0 * lambda;
        second[k] += lambda;
    }
    // LDLᵀ with unit lower factors l1 (one below) and l2 (two below).
    let (mut d, mut l1, mut l2) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    for k in 0..n {
        d[k] = diagonal[k];
        if k >= 1 {
            d[k] -= l1[k - 1] * l1[k - 1] * d[k - 1];
        }
        if k >= 2 {
            d[k] -= l2[k - 2] * l2[k - 2] * d[k - 2];
        }
        let carried = if k >= 1 { l1[k - 1] * l2[k - 1] * d[k - 1] } else { 0.0 };
        l1[k] = (first[k] - carried) / d[k];
        l2[k] = second[k] / d[k];
    }
    let solve = |pick: fn(&(f64, f64)) -> f64| {
        let mut x: Vec<f64> = points.iter().zip(weights).map(|(p, w)| w * pick(p)).collect();
        for k in 0..n {
            if k >= 1 {
                x[k] -= l1[k - 1] * x[k - 1];
            }
            if k >= 2 {
                x[k] -= l2[k - 2] * x[k - 2];
            }
        }
        for k in (0..n).rev() {
            x[k] /= d[k];
            if k + 1 < n {
                x[k] -= l1[k] * x[k + 1];
            }
            if k + 2 < n {
                x[k] -= l2[k] * x[k + 2];
            }
        }
        x
    };
    solve(|p| p.0).into_iter().zip(solve(|p| p.1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jitter_of_a_still_object_goes_and_a_real_start_stays() {
        let truth = |k: usize| if k < 30 { 50.0 } else { 50.0 + 4.0 * (k - 30) as f64 };
        let mut located: Vec<Located> = (0..60)
            .map(|k| {
                let noise = 0.4 * ((k * 7919 % 13) as f64 / 6.0 - 1.0);
                let transform = Matrix3::new(1.0, 0.0, truth(k) + noise, 0.0, 1.0, 20.0, 0.0, 0.0, 1.0);
                Located { transform, evidence: 1.0, visible: 1.0, predicted: transform }
            })
            .collect();
        smooth(&mut located, (10.0, 10.0), 10.0, 3);
        for k in 1..24 {
            let step = located[k].transform[(0, 2)] - located[k - 1].transform[(0, 2)];
            assert!(step.abs() < 0.12, "frame {k} moves by {step}");
        }
        for (k, entry) in located.iter().enumerate() {
            assert!((entry.transform[(0, 2)] - truth(k)).abs() < 1.2, "frame {k}");
        }
    }
}
