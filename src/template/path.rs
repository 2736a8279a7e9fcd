//! The placements of a whole clip together: what every frame measures, and how the object moved
//! between frames, weighed by how much each says.

use nalgebra::{Matrix3, Matrix4, Vector4};

use super::{placement::Located, pose::Pose};
use crate::segment::object::apply;

/// How far a step between two frames may be trusted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Pixels of the earlier frame to pixels of the later.
    pub transform: Matrix3<f64>,
    /// Standard deviation of the centre's step, pixels.
    pub shift: f64,
    /// Standard deviation of size (logarithm) and turn (rad).
    pub form: f64,
}

impl Step {
    /// The step from the later frame to the earlier.
    pub fn reversed(&self) -> Self {
        Self { transform: self.transform.try_inverse().unwrap_or_else(Matrix3::identity), ..*self }
    }

    /// The precision of the step as a difference of [`Pose::vector`].
    pub fn precision(&self) -> Matrix4<f64> {
        let (shift, form) = (self.shift.powi(-2), self.form.powi(-2));
        Matrix4::from_diagonal(&Vector4::new(shift, shift, form, form))
    }

    /// The difference of [`Pose::vector`] that the step makes at `from`.
    pub fn difference(&self, from: (f64, f64)) -> Vector4<f64> {
        let to = apply(&self.transform, from.0, from.1);
        let (c, s) = (self.transform[(0, 0)], self.transform[(1, 0)]);
        Vector4::new(to.0 - from.0, to.1 - from.1, c.hypot(s).max(1e-6).ln(), s.atan2(c))
    }
}

/// Replaces the placements by the most likely path through what all frames measured (a Gauss–Markov
/// smoother, solved at once over the block-tridiagonal normal equations). Measurements that the path
/// contradicts lose weight.
///
/// `steps[k]` leads from frame k to k + 1. `centre` and `radius` are the template's.
pub(crate) fn smooth(located: &mut [Located], steps: &[Step], centre: (f64, f64), radius: f64) {
    let measured: Vec<Pose> = located.iter().map(|l| Pose::of(&l.transform, centre)).collect();
    let mut path: Vec<Vector4<f64>> = measured.iter().map(Pose::vector).collect();
    let unrolled = unrolled(&path);
    for (pose, turn) in path.iter_mut().zip(&unrolled) {
        pose[3] = *turn;
    }
    let seen = path.clone();
    for _ in 0..4 {
        let weights: Vec<f64> =
            seen.iter().zip(&path).map(|(seen, path)| credence(&(seen - path), radius)).collect();
        path = most_likely(&seen, &path, located, steps, &weights);
    }
    let shear = quiet(located, |at| (measured[at].aspect, measured[at].shear));
    for (at, entry) in located.iter_mut().enumerate() {
        let pose = Pose { aspect: shear[at].0, shear: shear[at].1, ..measured[at].with_vector(&path[at]) };
        let transform = pose.transform(centre);
        if transform.iter().all(|v| v.is_finite()) {
            entry.transform = transform;
        }
    }
}

/// How far to believe a measurement that lies `off` the path: half at a tenth of the radius.
fn credence(off: &Vector4<f64>, radius: f64) -> f64 {
    let pixels = off[0].hypot(off[1]) + radius * off[2].hypot(off[3]);
    let knee = (0.1 * radius).max(1.5);
    1.0 / (1.0 + (pixels / knee).powi(2))
}

/// Angles without jumps of a whole turn.
fn unrolled(path: &[Vector4<f64>]) -> Vec<f64> {
    let mut last = 0.0;
    let mut turns = Vec::with_capacity(path.len());
    for (k, pose) in path.iter().enumerate() {
        let step: f64 = pose[3] - last;
        last = if k == 0 { pose[3] } else { last + step.sin().atan2(step.cos()) };
        turns.push(last);
    }
    turns
}

/// Solves `Σ (p − seen)ᵀ I (p − seen) + Σ (p' − p − d)ᵀ Q (p' − p − d)` by block elimination.
fn most_likely(
    seen: &[Vector4<f64>],
    around: &[Vector4<f64>],
    located: &[Located],
    steps: &[Step],
    weights: &[f64],
) -> Vec<Vector4<f64>> {
    let n = seen.len();
    let mut diagonal = Vec::with_capacity(n);
    let mut right = Vec::with_capacity(n);
    for k in 0..n {
        let information = located[k].information * weights[k] + Matrix4::identity() * 1e-6;
        right.push(information * seen[k]);
        diagonal.push(information);
    }
    for (k, step) in steps.iter().enumerate().take(n.saturating_sub(1)) {
        let precision = step.precision();
        let d = precision * step.difference((around[k][0], around[k][1]));
        diagonal[k] += precision;
        diagonal[k + 1] += precision;
        right[k] -= d;
        right[k + 1] += d;
    }
    // Forward elimination: D'k = Dk − Q D'k₋₁⁻¹ Q with off-diagonal blocks −Q.
    for k in 1..n {
        let precision = steps[k - 1].precision();
        let Some(inverse) = diagonal[k - 1].try_inverse() else { return around.to_vec() };
        let factor = precision * inverse;
        diagonal[k] -= factor * precision;
        right[k] = right[k] + factor * right[k - 1];
    }
    let mut path = vec![Vector4::zeros(); n];
    for k in (0..n).rev() {
        let mut rest = right[k];
        if k + 1 < n {
            rest += steps[k].precision() * path[k + 1];
        }
        let Some(inverse) = diagonal[k].try_inverse() else { return around.to_vec() };
        path[k] = inverse * rest;
    }
    path
}

/// Aspect and shear, averaged over about a quarter of a second by evidence.
fn quiet(located: &[Located], value: impl Fn(usize) -> (f64, f64)) -> Vec<(f64, f64)> {
    let reach = 12_usize;
    let average = |at: usize| {
        let (low, high) = (at.saturating_sub(reach), (at + reach + 1).min(located.len()));
        let mut sum = (1e-9, 0.0, 0.0);
        for (k, entry) in located.iter().enumerate().take(high).skip(low) {
            let near = (-0.5 * ((k as f64 - at as f64) / 4.0).powi(2)).exp();
            let weight = near * (1e-3 + entry.evidence * entry.visible * entry.visible);
            let (aspect, shear) = value(k);
            sum = (sum.0 + weight, sum.1 + weight * aspect, sum.2 + weight * shear);
        }
        (sum.1 / sum.0, sum.2 / sum.0)
    };
    (0..located.len()).map(average).collect()
}
