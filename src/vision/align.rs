//! Direct alignment of a template to a picture: Gauss–Newton over robust residuals.
//!
//! Lucas–Kanade with the compositional warp of Baker & Matthews 2004, a Geman–McClure weight and
//! Gaussian priors on the update, so that motion nobody can observe stays what was predicted.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::Plane;

/// A template sample: position in template pixels, its value, its weight.
#[derive(Clone, Copy, Debug)]
pub struct AlignPoint {
    /// Column in the template.
    pub x: f64,
    /// Row in the template.
    pub y: f64,
    /// Value there, in the channel's units.
    pub value: f32,
    /// Weight, 0 and up.
    pub weight: f32,
}

/// One picture to match the template's samples against.
#[derive(Debug)]
pub struct AlignChannel<'a> {
    /// Samples of the template.
    pub points: &'a [AlignPoint],
    /// The picture, same units.
    pub target: &'a Plane,
    /// Where the picture may be trusted, 0 to 1, same size; `None`: everywhere.
    pub trust: Option<&'a Plane>,
    /// Residual at which the robust weight falls to a quarter, in the channel's units.
    pub scale: f32,
    /// Weight of the whole channel (a count of independent samples).
    pub strength: f64,
    /// Whether brightness gain and bias are fitted.
    pub photometric: bool,
}

/// How far a transform may move from its prediction: standard deviations in units of the
/// template's radius (translation) or of 1 (the others).
#[derive(Clone, Copy, Debug)]
pub struct AlignPrior {
    /// Translation.
    pub shift: f64,
    /// Scale.
    pub scale: f64,
    /// In-plane rotation, rad.
    pub rotation: f64,
    /// Aspect and shear; 0 forbids.
    pub affine: f64,
    /// Perspective; 0 forbids.
    pub perspective: f64,
}

impl AlignPrior {
    fn sigmas(&self) -> [f64; 8] {
        let Self { shift, scale, rotation, affine, perspective } = *self;
        [scale, rotation, affine, affine, shift, shift, perspective, perspective]
    }
}

/// What alignment found.
#[derive(Clone, Copy, Debug)]
pub struct Alignment {
    /// Template pixels to picture pixels.
    pub transform: Matrix3<f64>,
    /// Share of weighted samples that agree, 0 to 1, of those in trusted parts of the picture.
    pub agreement: f64,
    /// Share of weighted samples that fell on trusted parts of the picture.
    pub seen: f64,
    /// What the picture alone, without the prior, says about the update: its Gauss–Newton normal
    /// matrix over scale, rotation, aspect, shear, shift x, shift y and perspective x, y, shifts in
    /// radii of the template along its own axes.
    pub information: SMatrix<f64, 8, 8>,
}

/// Generators of the update: scale, rotation, aspect, shear, shift x, shift y, perspective x, y.
pub(super) fn generators() -> [Matrix3<f64>; 8] {
    let m = |a: [f64; 9]| Matrix3::from_row_slice(&a);
    [
        m([1., 0., 0., 0., 1., 0., 0., 0., 0.]),
        m([0., -1., 0., 1., 0., 0., 0., 0., 0.]),
        m([1., 0., 0., 0., -1., 0., 0., 0., 0.]),
        m([0., 1., 0., 1., 0., 0., 0., 0., 0.]),
        m([0., 0., 1., 0., 0., 0., 0., 0., 0.]),
        m([0., 0., 0., 0., 0., 1., 0., 0., 0.]),
        m([0., 0., 0., 0., 0., 0., 1., 0., 0.]),
        m([0., 0., 0., 0., 0., 0., 0., 1., 0.]),
    ]
}

/// Refines `initial` (template to picture pixels) so that all channels agree.
///
/// `centre` and `radius` describe the template in its own pixels and condition the problem.
pub fn align(
    channels: &[AlignChannel<'_>],
    initial: &Matrix3<f64>,
    centre: (f64, f64),
    radius: f64,
    prior: &AlignPrior,
    iterations: usize,
) -> Alignment {
    let normalise = Matrix3::new(
        1.0 / radius,
        0.0,
        -centre.0 / radius,
        0.0,
        1.0 / radius,
        -centre.1 / radius,
        0.0,
        0.0,
        1.0,
    );
    let base = initial * Matrix3::new(radius, 0.0, centre.0, 0.0, radius, centre.1, 0.0, 0.0, 1.0);
    let basis = generators();
    let sigmas = prior.sigmas();
    let mut parameters = SVector::<f64, 8>::zeros();
    let compose = |parameters: &SVector<f64, 8>| {
        let update = basis.iter().zip(parameters.iter()).map(|(g, p)| g * *p).sum::<Matrix3<f64>>();
        base * (Matrix3::identity() + update)
    };
    let mut result =
        Alignment { transform: *initial, agreement: 0.0, seen: 0.0, information: SMatrix::zeros() };
    for iteration in 0..=iterations {
        let warp = compose(&parameters);
        let mut normal = SMatrix::<f64, 8, 8>::zeros();
        let mut gradient = SVector::<f64, 8>::zeros();
        let (mut agreement, mut seen) = ((0.0, 0.0), (0.0, 0.0));
        for channel in channels {
            let sums = accumulate(channel, &warp, &base, &normalise, &basis);
            if sums.weight <= 0.0 {
                continue;
            }
            let scale = channel.strength / sums.total.max(1e-9);
            normal += sums.normal * scale;
            gradient += sums.gradient * scale;
            agreement.0 += channel.strength * sums.agreeing / sums.weight;
            agreement.1 += channel.strength;
            seen.0 += channel.strength * sums.weight / sums.total.max(1e-9);
            seen.1 += channel.strength;
        }
        result = Alignment {
            transform: warp * normalise,
            agreement: if agreement.1 > 0.0 { agreement.0 / agreement.1 } else { 0.0 },
            seen: if seen.1 > 0.0 { seen.0 / seen.1 } else { 0.0 },
            information: normal,
        };
        if iteration == iterations {
            break;
        }
        for k in 0..8 {
            if sigmas[k] > 0.0 {
                let precision = 1.0 / (sigmas[k] * sigmas[k]);
                normal[(k, k)] += precision;
                gradient[k] -= precision * parameters[k];
            } else {
                for j in 0..8 {
                    normal[(k, j)] = 0.0;
                    normal[(j, k)] = 0.0;
                }
                normal[(k, k)] = 1.0;
                gradient[k] = 0.0;
            }
        }
        let Some(factor) = normal.cholesky() else { break };
        let step = factor.solve(&gradient);
        if !step.iter().all(|value| value.is_finite()) {
            break;
        }
        let limit = (0.15 / step.norm().max(1e-12)).min(1.0);
        parameters += step * limit;
        if step.norm() * radius < 0.005 {
            // Settled: one more pass only measures.
            result.transform = compose(&parameters) * normalise;
            break;
        }
    }
    let corner = result.transform[(2, 2)];
    if corner.abs() > 1e-9 {
        result.transform /= corner;
    }
    result
}

struct Sums {
    normal: SMatrix<f64, 8, 8>,
    gradient: SVector<f64, 8>,
    /// Weight of samples on trusted parts.
    weight: f64,
    /// Weight of all samples.
    total: f64,
    /// Weight of trusted samples that agree.
    agreeing: f64,
}

fn accumulate(
    channel: &AlignChannel<'_>,
    warp: &Matrix3<f64>,
    base: &Matrix3<f64>,
    normalise: &Matrix3<f64>,
    basis: &[Matrix3<f64>; 8],
) -> Sums {
    let mut sums =
        Sums { normal: SMatrix::zeros(), gradient: SVector::zeros(), weight: 0.0, total: 0.0, agreeing: 0.0 };
    let columns: Vec<Matrix3<f64>> = basis.iter().map(|g| base * g).collect();
    let (gain, bias) = if channel.photometric { gain_bias(channel, warp, normalise) } else { (1.0, 0.0) };
    for point in channel.points {
        let weight = f64::from(point.weight);
        sums.total += weight;
        let u = Vector3::new(
            normalise[(0, 0)] * point.x + normalise[(0, 2)],
            normalise[(1, 1)] * point.y + normalise[(1, 2)],
            1.0,
        );
        let v = warp * u;
        if v.z < 1e-6 {
            continue;
        }
        let (x, y) = (v.x / v.z, v.y / v.z);
        let Some(value) = channel.target.sample(x, y) else { continue };
        let trust = channel.trust.map_or(1.0, |plane| plane.sample(x, y).unwrap_or(0.0));
        if trust < 0.05 {
            continue;
        }
        let difference = |dx: f64, dy: f64| {
            let ahead = channel.target.sample(x + dx, y + dy).unwrap_or(value);
            let behind = channel.target.sample(x - dx, y - dy).unwrap_or(value);
            f64::from(ahead - behind)
        };
        let (gx, gy) = (0.5 * difference(1.0, 0.0), 0.5 * difference(0.0, 1.0));
        let residual = f64::from(gain * point.value + bias - value) / f64::from(channel.scale);
        let robust = 1.0 / (1.0 + residual * residual).powi(2);
        let trusted = weight * f64::from(trust);
        sums.weight += trusted;
        sums.agreeing += trusted * robust.sqrt();
        let mut row = SVector::<f64, 8>::zeros();
        for (k, column) in columns.iter().enumerate() {
            let d = column * u;
            let slope = gx * (d.x - x * d.z) / v.z + gy * (d.y - y * d.z) / v.z;
            row[k] = slope / f64::from(channel.scale);
        }
        let w = trusted * robust;
        sums.gradient += row * (w * residual);
        sums.normal.syger(w, &row, &row, 1.0);
    }
    sums.normal.fill_upper_triangle_with_lower_triangle();
    sums
}

/// Gain and bias that take template values to the picture's, from the middle of the residuals.
fn gain_bias(channel: &AlignChannel<'_>, warp: &Matrix3<f64>, normalise: &Matrix3<f64>) -> (f32, f32) {
    let full = warp * normalise;
    let mut pairs = Vec::with_capacity(channel.points.len());
    for point in channel.points {
        let v = full * Vector3::new(point.x, point.y, 1.0);
        let (x, y) = (v.x / v.z, v.y / v.z);
        let trusted = channel.trust.is_none_or(|plane| plane.sample(x, y).unwrap_or(0.0) > 0.5);
        if let (true, Some(value)) = (trusted, channel.target.sample(x, y)) {
            pairs.push((point.value, value));
        }
    }
    if pairs.len() < 12 {
        return (1.0, 0.0);
    }
    let mut offsets: Vec<f32> = pairs.iter().map(|(a, b)| b - a).collect();
    let middle = offsets.len() / 2;
    let (_, median, _) = offsets.select_nth_unstable_by(middle, f32::total_cmp);
    let median = *median;
    let close: Vec<_> = pairs.iter().filter(|(a, b)| (b - a - median).abs() < 1.5 * channel.scale).collect();
    let count = close.len().max(1) as f32;
    let mean = |pick: fn(&(f32, f32)) -> f32| close.iter().map(|pair| pick(pair)).sum::<f32>() / count;
    let (mean_a, mean_b) = (mean(|p| p.0), mean(|p| p.1));
    let covariance: f32 = close.iter().map(|(a, b)| (a - mean_a) * (b - mean_b)).sum();
    let variance: f32 = close.iter().map(|(a, _)| (a - mean_a).powi(2)).sum();
    let gain = (covariance / variance.max(1e-3)).clamp(0.7, 1.4);
    // A flat template says nothing about gain.
    let gain = if variance / count < 16.0 { 1.0 } else { gain };
    (gain, mean_b - gain * mean_a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(x: f64, y: f64) -> f32 {
        (100.0 + 40.0 * (0.21 * x).sin() * (0.17 * y).cos() + 25.0 * (0.13 * x + 0.19 * y).sin()) as f32
    }

    #[test]
    fn a_known_similarity_is_found_to_a_twentieth_of_a_pixel() {
        let truth = Matrix3::new(1.03, -0.05, 6.0, 0.05, 1.03, -4.0, 0.0, 0.0, 1.0);
        let back = truth.try_inverse().unwrap();
        let target = Plane::from_fn(160, 140, |x, y| {
            let v = back * Vector3::new(x as f64, y as f64, 1.0);
            1.1 * texture(v.x, v.y) + 5.0
        });
        let points: Vec<_> = (30..110)
            .step_by(3)
            .flat_map(|y| (30..110).step_by(3).map(move |x| (f64::from(x), f64::from(y))))
            .map(|(x, y)| AlignPoint { x, y, value: texture(x, y), weight: 1.0 })
            .collect();
        let channel = AlignChannel {
            points: &points,
            target: &target,
            trust: None,
            scale: 20.0,
            strength: 300.0,
            photometric: true,
        };
        let prior = AlignPrior { shift: 0.5, scale: 0.2, rotation: 0.3, affine: 0.1, perspective: 0.0 };
        let start = Matrix3::new(1.0, 0.0, 3.0, 0.0, 1.0, -2.0, 0.0, 0.0, 1.0);
        let found = align(&[channel], &start, (70.0, 70.0), 40.0, &prior, 30);
        for (x, y) in [(30.0, 30.0), (109.0, 35.0), (70.0, 100.0)] {
            let (a, b) = (truth * Vector3::new(x, y, 1.0), found.transform * Vector3::new(x, y, 1.0));
            assert!((a - b / b.z).norm() < 0.05, "{a} {b}");
        }
        assert!(found.agreement > 0.9);
    }
}
