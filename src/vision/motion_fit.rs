//! A camera's motion from tracked points, that stays near none where the points do not tell.
//!
//! A homography has eight degrees of freedom. Points on one side of the picture, on things of different depth, or at
//! the edge of a moving shadow determine some of them badly, and what is made of those is wrong by many pixels where
//! no point lies: under an arm. Heads turn little between two looks at one place: a Gaussian prior on everything but
//! the shift keeps what nobody can observe small, and gives way where the points do tell.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use opencv::{
    calib3d,
    core::{Mat, MatTraitConst, MatTraitConstManual, Point2f, Vector},
};

use super::align::generators;

/// A motion between two pictures.
#[derive(Clone, Copy, Debug)]
pub(super) struct FittedMotion {
    /// Takes pixels of the first picture to the second.
    pub homography: Matrix3<f64>,
    /// Points that agree.
    pub inliers: usize,
}

/// Standard deviations of scale, rotation, aspect, shear, shift (twice) and perspective (twice), in a picture whose
/// longer half is 1.
const PRIOR: [f64; 8] = [0.1, 0.2, 0.02, 0.02, 10.0, 10.0, 0.03, 0.03];
/// Pixels by which tracked points err, neighbours alike.
const POINT_ERROR: f64 = 1.0;
/// Rounds of reweighting.
const ROUNDS: usize = 12;

/// Pictures' pixels to coordinates whose origin is the centre and whose unit is half the longer side.
fn normalisation(width: f64, height: f64) -> (Matrix3<f64>, f64) {
    let unit = 0.5 * width.max(height);
    let centre = (0.5 * (width - 1.0), 0.5 * (height - 1.0));
    let scale = 1.0 / unit;
    (Matrix3::new(scale, 0.0, -centre.0 * scale, 0.0, scale, -centre.1 * scale, 0.0, 0.0, 1.0), unit)
}

/// The likeliest motion that takes `from` to `to`, pixels of pictures of `size` (columns, rows): started from a
/// shift, a similarity and a homography by seeded RANSAC, each refined under the prior; points within `tolerance`
/// pixels agree. `None` without a motion that could be inverted.
///
/// # Errors
/// When OpenCV fails.
pub(super) fn fitted_motion(
    from: &Vector<Point2f>,
    to: &Vector<Point2f>,
    size: (i32, i32),
    tolerance: f64,
) -> opencv::Result<Option<FittedMotion>> {
    let (normalise, unit) = normalisation(f64::from(size.0), f64::from(size.1));
    let Some(back) = normalise.try_inverse() else { return Ok(None) };
    let place = |p: Point2f| normalise * Vector3::new(f64::from(p.x), f64::from(p.y), 1.0);
    let pairs: Vec<(Vector3<f64>, Vector3<f64>)> =
        from.iter().zip(to.iter()).map(|(a, b)| (place(a), place(b))).collect();
    let basis = generators();
    let mut best: Option<(f64, Parameters)> = None;
    for start in starts(from, to, &pairs, tolerance)? {
        let parameters = parameters_of(&(normalise * start * back));
        let refined = refined(&pairs, &basis, parameters, POINT_ERROR / unit);
        if best.as_ref().is_none_or(|(cost, _)| refined.0 < *cost) {
            best = Some(refined);
        }
    }
    let Some((_, parameters)) = best else { return Ok(None) };
    let motion = composed(&basis, &parameters);
    let agrees = |(a, b): &&(Vector3<f64>, Vector3<f64>)| {
        let q = motion * a;
        (q.x / q.z - b.x).hypot(q.y / q.z - b.y) * unit < tolerance
    };
    let inliers = pairs.iter().filter(agrees).count();
    let mut homography = back * motion * normalise;
    homography /= homography[(2, 2)];
    let sound = homography.iter().all(|v| v.is_finite()) && homography.determinant().abs() > 1e-9;
    Ok(sound.then_some(FittedMotion { homography, inliers }))
}

/// Scale, rotation, aspect, shear, shift and perspective.
type Parameters = SVector<f64, 8>;

fn composed(basis: &[Matrix3<f64>; 8], parameters: &Parameters) -> Matrix3<f64> {
    let update = basis.iter().zip(parameters.iter()).map(|(g, p)| g * *p).sum::<Matrix3<f64>>();
    Matrix3::identity() + update
}

fn parameters_of(h: &Matrix3<f64>) -> Parameters {
    let h = if h[(2, 2)].abs() > 1e-9 { h / h[(2, 2)] } else { Matrix3::identity() };
    let (a, b, c, d) = (h[(0, 0)] - 1.0, h[(0, 1)], h[(1, 0)], h[(1, 1)] - 1.0);
    Parameters::from([
        0.5 * (a + d),
        0.5 * (c - b),
        0.5 * (a - d),
        0.5 * (b + c),
        h[(0, 2)],
        h[(1, 2)],
        h[(2, 0)],
        h[(2, 1)],
    ])
}

/// Guesses in pixels: the median shift, and what RANSAC makes of all points.
fn starts(
    from: &Vector<Point2f>,
    to: &Vector<Point2f>,
    pairs: &[(Vector3<f64>, Vector3<f64>)],
    tolerance: f64,
) -> opencv::Result<Vec<Matrix3<f64>>> {
    let shift = |of: &dyn Fn(usize) -> f64| {
        let mut values: Vec<f64> = (0..pairs.len()).map(of).collect();
        values.sort_unstable_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let point = |points: &Vector<Point2f>, i: usize| points.get(i).unwrap_or_default();
    let x = shift(&|i| f64::from(point(to, i).x - point(from, i).x));
    let y = shift(&|i| f64::from(point(to, i).y - point(from, i).y));
    let mut starts = vec![Matrix3::new(1.0, 0.0, x, 0.0, 1.0, y, 0.0, 0.0, 1.0)];
    let mut agreeing = Mat::default();
    opencv::core::set_rng_seed(1)?;
    let similar = calib3d::estimate_affine_partial_2d(
        from,
        to,
        &mut agreeing,
        calib3d::RANSAC,
        tolerance,
        500,
        0.99,
        0,
    )?;
    if similar.total() == 6 {
        let v = similar.data_typed::<f64>()?;
        starts.push(Matrix3::new(v[0], v[1], v[2], v[3], v[4], v[5], 0.0, 0.0, 1.0));
    }
    opencv::core::set_rng_seed(1)?;
    let full = calib3d::find_homography(from, to, &mut agreeing, calib3d::RANSAC, tolerance)?;
    if full.total() == 9 {
        starts.push(Matrix3::from_row_slice(full.data_typed::<f64>()?));
    }
    Ok(starts)
}

/// Gauss–Newton with Geman–McClure weights (scale `error`) and the prior. Returns the cost with it.
fn refined(
    pairs: &[(Vector3<f64>, Vector3<f64>)],
    basis: &[Matrix3<f64>; 8],
    mut parameters: Parameters,
    error: f64,
) -> (f64, Parameters) {
    let cost = |parameters: &Parameters, scale: f64| -> f64 {
        let motion = composed(basis, parameters);
        let data = pairs.iter().map(|(a, b)| {
            let q = motion * a;
            let squared = ((q.x / q.z - b.x).powi(2) + (q.y / q.z - b.y).powi(2)) / (scale * scale);
            if squared.is_finite() { squared / (1.0 + squared) } else { 1.0 }
        });
        let prior = parameters.iter().zip(PRIOR).map(|(p, sigma)| (p / sigma).powi(2));
        data.sum::<f64>() + prior.sum::<f64>()
    };
    for round in 0..ROUNDS {
        // Wide at first: a start that is a little off must still see its points.
        let scale = error * (1.0 + 2.0 * (1.0 - round as f64 / (ROUNDS as f64 - 4.0)).max(0.0));
        let motion = composed(basis, &parameters);
        let (mut normal, mut gradient) = (SMatrix::<f64, 8, 8>::zeros(), Parameters::zeros());
        for (a, b) in pairs {
            let q = motion * a;
            if q.z.abs() < 1e-6 {
                continue;
            }
            let (x, y) = (q.x / q.z, q.y / q.z);
            let (rx, ry) = (b.x - x, b.y - y);
            let weight = (1.0 + (rx * rx + ry * ry) / (scale * scale)).powi(-2) / (scale * scale);
            let (mut jx, mut jy) = (Parameters::zeros(), Parameters::zeros());
            for (k, generator) in basis.iter().enumerate() {
                let d = generator * a;
                jx[k] = (d.x - x * d.z) / q.z;
                jy[k] = (d.y - y * d.z) / q.z;
            }
            normal += (jx * jx.transpose() + jy * jy.transpose()) * weight;
            gradient += (jx * rx + jy * ry) * weight;
        }
        for (k, sigma) in PRIOR.iter().enumerate() {
            let precision = 1.0 / (sigma * sigma);
            normal[(k, k)] += precision;
            gradient[k] -= precision * parameters[k];
        }
        let Some(factor) = normal.cholesky() else { break };
        let step = factor.solve(&gradient);
        if !step.iter().all(|value| value.is_finite()) {
            break;
        }
        parameters += step;
    }
    (cost(&parameters, error), parameters)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (i32, i32) = (320, 240);

    fn moved(truth: &Matrix3<f64>, points: &[(f64, f64)]) -> (Vector<Point2f>, Vector<Point2f>) {
        let to = |(x, y): (f64, f64)| {
            let q = truth * Vector3::new(x, y, 1.0);
            Point2f::new((q.x / q.z) as f32, (q.y / q.z) as f32)
        };
        let from = points.iter().map(|(x, y)| Point2f::new(*x as f32, *y as f32)).collect();
        (from, points.iter().map(|point| to(*point)).collect())
    }

    fn farthest(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
        let corners = [(0.0, 0.0), (319.0, 0.0), (0.0, 239.0), (319.0, 239.0)];
        let distance = |(x, y): (f64, f64)| {
            let (p, q) = (a * Vector3::new(x, y, 1.0), b * Vector3::new(x, y, 1.0));
            (p.x / p.z - q.x / q.z).hypot(p.y / p.z - q.y / q.z)
        };
        corners.into_iter().map(distance).fold(0.0, f64::max)
    }

    #[test]
    fn a_turn_of_the_head_is_found_from_points_all_over() {
        let truth = Matrix3::new(1.02, -0.03, 9.0, 0.03, 1.01, -6.0, 6e-5, -9e-5, 1.0);
        let points: Vec<(f64, f64)> =
            (0..120).map(|i| (f64::from(i * 37 % 320), f64::from(i * 53 % 240))).collect();
        let (from, to) = moved(&truth, &points);
        let found = fitted_motion(&from, &to, SIZE, 1.5).unwrap().unwrap();
        assert!(found.inliers > 110 && farthest(&found.homography, &truth) < 0.7);
    }

    #[test]
    fn points_in_one_corner_that_err_a_little_leave_the_other_corners_alone() {
        let points: Vec<(f64, f64)> =
            (0..40).map(|i| (20.0 + f64::from(i * 7 % 60), 15.0 + f64::from(i * 11 % 50))).collect();
        let (from, still) = moved(&Matrix3::identity(), &points);
        // Half of them stand higher and move by parallax.
        let to = still.iter().enumerate().map(|(i, p)| {
            let err = if i % 2 == 0 { 0.8 } else { -0.3 };
            Point2f::new(p.x + err * p.y / 60.0, p.y - err * p.x / 80.0)
        });
        let found = fitted_motion(&from, &to.collect(), SIZE, 1.5).unwrap().unwrap();
        assert!(farthest(&found.homography, &Matrix3::identity()) < 8.0);
    }
}
