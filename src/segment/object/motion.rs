//! How the object moved between two neighbouring frames.

use nalgebra::{Matrix3, Matrix4, Vector4};

use super::view::{Roi, View};
use crate::vision::{Flow, FlowQuality, dense_flow};

/// Flow between two views inside one rectangle, with its consistency.
pub(crate) struct LocalFlow {
    pub roi: Roi,
    pub forward: Flow,
    pub consistent: Vec<bool>,
}

impl LocalFlow {
    /// Flow from `first` to `second` inside `roi`.
    pub fn between(first: &View, second: &View, roi: Roi) -> opencv::Result<Self> {
        let (a, b) = (roi.crop_mat(&first.gray)?, roi.crop_mat(&second.gray)?);
        let forward = dense_flow(&a, &b, FlowQuality::Medium)?;
        let backward = dense_flow(&b, &a, FlowQuality::Fast)?;
        let consistent = forward.consistency(&backward);
        Ok(Self { roi, forward, consistent })
    }

    /// Consistent matches `(x, y, x', y')` in frame pixels, of pixels of the rectangle where
    /// `wanted` holds, at most about `most`.
    pub fn matches(&self, wanted: impl Fn(usize) -> bool, most: usize) -> Vec<[f64; 4]> {
        let chosen: Vec<usize> =
            (0..self.roi.area()).filter(|at| self.consistent[*at] && wanted(*at)).collect();
        let step = (chosen.len() / most.max(1)).max(1);
        let matches = chosen.into_iter().step_by(step).map(|at| {
            let x = (at % self.roi.width + self.roi.x) as f64;
            let y = (at / self.roi.width + self.roi.y) as f64;
            let w = self.forward.vectors()[at];
            [x, y, x + f64::from(w[0]), y + f64::from(w[1])]
        });
        matches.collect()
    }
}

/// A fitted similarity and the share of matches that agree with it within 1.5 px.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Similarity {
    pub transform: Matrix3<f64>,
    pub agreement: f64,
}

/// Fits `[x', y'] = [[a, -b], [b, a]] [x, y] + t` by iteratively reweighted least squares with
/// Cauchy weights, started from the median translation. `None` with fewer than 12 matches.
pub(crate) fn fit_similarity(matches: &[[f64; 4]]) -> Option<Similarity> {
    if matches.len() < 12 {
        return None;
    }
    let middle = |component: fn(&[f64; 4]) -> f64| {
        let mut values: Vec<f64> = matches.iter().map(component).collect();
        let half = values.len() / 2;
        *values.select_nth_unstable_by(half, f64::total_cmp).1
    };
    let start = Vector4::new(1.0, 0.0, middle(|m| m[2] - m[0]), middle(|m| m[3] - m[1]));
    let (cx, cy) = (middle(|m| m[0]), middle(|m| m[1]));
    // About the centre, the translation is the median one.
    let mut p = start;
    let residual = |p: &Vector4<f64>, m: &[f64; 4]| {
        let (x, y) = (m[0] - cx, m[1] - cy);
        let rx = m[2] - cx - (p[0] * x - p[1] * y + p[2]);
        let ry = m[3] - cy - (p[1] * x + p[0] * y + p[3]);
        (rx, ry)
    };
    for iteration in 0..12 {
        let scale = if iteration < 4 { 2.0 } else { 0.8 };
        let mut normal = Matrix4::zeros();
        let mut right = Vector4::zeros();
        for m in matches {
            let (x, y) = (m[0] - cx, m[1] - cy);
            let (rx, ry) = residual(&p, m);
            let w = 1.0 / (1.0 + (rx * rx + ry * ry) / (scale * scale));
            let (jx, jy) = (Vector4::new(x, -y, 1.0, 0.0), Vector4::new(y, x, 0.0, 1.0));
            normal += w * (jx * jx.transpose() + jy * jy.transpose());
            right += w * (jx * rx + jy * ry);
        }
        // Ten pseudo-observations keep thin evidence near a pure translation.
        normal[(0, 0)] += 200.0;
        normal[(1, 1)] += 200.0;
        right += Vector4::new(200.0 * (1.0 - p[0]), -200.0 * p[1], 0.0, 0.0);
        p += normal.cholesky()?.solve(&right);
    }
    let agreeing = matches.iter().filter(|m| {
        let (rx, ry) = residual(&p, m);
        rx.hypot(ry) < 1.5
    });
    let agreement = agreeing.count() as f64 / matches.len() as f64;
    let (a, b) = (p[0], p[1]);
    let tx = p[2] + cx - (a * cx - b * cy);
    let ty = p[3] + cy - (b * cx + a * cy);
    let transform = Matrix3::new(a, -b, tx, b, a, ty, 0.0, 0.0, 1.0);
    Some(Similarity { transform, agreement })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similarity_is_found_among_a_third_of_strangers() {
        let mut matches = Vec::new();
        for k in 0..90 {
            let (x, y) = (f64::from(k % 10) * 5.0 + 100.0, f64::from(k / 10) * 5.0 + 50.0);
            let moved =
                if k % 3 == 0 { [x, y] } else { [1.02 * x - 0.03 * y + 4.0, 0.03 * x + 1.02 * y - 2.0] };
            matches.push([x, y, moved[0], moved[1]]);
        }
        let found = fit_similarity(&matches).unwrap();
        let (x, y) = super::super::keyframe::apply(&found.transform, 120.0, 70.0);
        let truth = (1.02 * 120.0 - 0.03 * 70.0 + 4.0, 0.03 * 120.0 + 1.02 * 70.0 - 2.0);
        assert!((x - truth.0).hypot(y - truth.1) < 0.6, "{x} {y} {truth:?}");
        assert!(found.agreement > 0.5);
    }
}
