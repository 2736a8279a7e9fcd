//! Smooth completion of a field known only in places (push-pull, Gortler et al. 1996).

/// Fills `values` (`width * height` pixels of `C` channels) where `weights` are below 1 with a smooth
/// interpolation of the rest. Weights of 1 keep their value; nothing known anywhere gives zeros.
///
/// # Panics
/// When the lengths are not `width * height`.
pub fn fill_smoothly<const C: usize>(values: &mut [[f32; C]], weights: &[f32], width: usize, height: usize) {
    assert_eq!(values.len(), width * height, "one value a pixel");
    assert_eq!(weights.len(), width * height, "one weight a pixel");
    if width * height <= 1 || weights.iter().all(|w| *w >= 1.0) {
        for (value, weight) in values.iter_mut().zip(weights) {
            if *weight <= 0.0 {
                *value = [0.0; C];
            }
        }
        return;
    }
    let (half_width, half_height) = (width.div_ceil(2), height.div_ceil(2));
    let (mut coarse, coarse_weights) = halved(values, weights, width, height);
    fill_smoothly(&mut coarse, &coarse_weights, half_width, half_height);
    for y in 0..height {
        for x in 0..width {
            let at = y * width + x;
            let weight = weights[at].clamp(0.0, 1.0);
            if weight < 1.0 {
                let from = bilinear(&coarse, half_width, half_height, x, y);
                for (value, from) in values[at].iter_mut().zip(from) {
                    *value = if weight > 0.0 { weight * *value + (1.0 - weight) * from } else { from };
                }
            }
        }
    }
}

/// Weighted means of 2×2 blocks; their weights add up, at most 1.
fn halved<const C: usize>(
    values: &[[f32; C]],
    weights: &[f32],
    width: usize,
    height: usize,
) -> (Vec<[f32; C]>, Vec<f32>) {
    let (half_width, half_height) = (width.div_ceil(2), height.div_ceil(2));
    let mut coarse = vec![[0.0; C]; half_width * half_height];
    let mut coarse_weights = vec![0.0; half_width * half_height];
    for y in 0..height {
        for x in 0..width {
            let (at, to) = (y * width + x, (y / 2) * half_width + x / 2);
            let weight = weights[at].clamp(0.0, 1.0);
            if weight > 0.0 {
                coarse_weights[to] += weight;
                for (sum, value) in coarse[to].iter_mut().zip(values[at]) {
                    *sum += weight * value;
                }
            }
        }
    }
    for (value, weight) in coarse.iter_mut().zip(&mut coarse_weights) {
        if *weight > 0.0 {
            for channel in value.iter_mut() {
                *channel /= *weight;
            }
        }
        *weight = weight.min(1.0);
    }
    (coarse, coarse_weights)
}

/// The coarse field at fine pixel (`x`, `y`), pixel centres aligned.
fn bilinear<const C: usize>(
    coarse: &[[f32; C]],
    width: usize,
    height: usize,
    x: usize,
    y: usize,
) -> [f32; C] {
    let split = |fine: usize, length: usize| {
        let position = (fine as f32 * 0.5 - 0.25).clamp(0.0, (length - 1) as f32);
        let low = position as usize;
        (low, (low + 1).min(length - 1), position - low as f32)
    };
    let ((x0, x1, fx), (y0, y1, fy)) = (split(x, width), split(y, height));
    let (a, b) = (&coarse[y0 * width + x0], &coarse[y0 * width + x1]);
    let (c, d) = (&coarse[y1 * width + x0], &coarse[y1 * width + x1]);
    std::array::from_fn(|i| {
        let (top, bottom) = (a[i] + (b[i] - a[i]) * fx, c[i] + (d[i] - c[i]) * fx);
        top + (bottom - top) * fy
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hole_in_a_constant_field_becomes_that_constant() {
        let (width, height) = (37, 23);
        let weights: Vec<f32> =
            (0..width * height).map(|i| if (10..30).contains(&(i % width)) { 0.0 } else { 1.0 }).collect();
        let mut values: Vec<[f32; 2]> =
            weights.iter().map(|w| if *w > 0.0 { [3.0, -5.0] } else { [99.0, 99.0] }).collect();
        fill_smoothly(&mut values, &weights, width, height);
        assert!(values.iter().all(|v| (v[0] - 3.0).abs() < 1e-4 && (v[1] + 5.0).abs() < 1e-4));
    }

    #[test]
    fn a_fill_stays_between_what_surrounds_it_and_keeps_what_is_known() {
        let weights: Vec<f32> = (0..64).map(|i| if i % 64 < 8 || i >= 56 { 1.0 } else { 0.0 }).collect();
        let mut values: Vec<[f32; 1]> = (0..64).map(|i| [if i < 8 { 0.0 } else { 10.0 }]).collect();
        fill_smoothly(&mut values, &weights, 8, 8);
        assert!(values[..8].iter().all(|v| v[0] == 0.0) && values[56..].iter().all(|v| v[0] == 10.0));
        assert!(values.iter().all(|v| (0.0..=10.0).contains(&v[0])));
    }
}
