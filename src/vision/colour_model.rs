//! Smoothed Lab histograms as colour likelihoods.

const L_BINS: usize = 16;
const AB_BINS: usize = 32;
/// Lab levels, cubed, that one bin of a [`ColourModel`] holds.
pub const COLOUR_BIN_VOLUME: f32 = 16.0 * 3.0 * 3.0;

/// A normalised Lab histogram (16 × 32 × 32 bins; a and b in steps of 3 levels around grey).
#[derive(Clone, Debug)]
pub struct ColourModel {
    bins: Vec<f32>,
}

fn bin(lab: [u8; 3]) -> usize {
    let chroma = |value: u8| ((i32::from(value) - 128).div_euclid(3) + 16).clamp(0, 31) as usize;
    (usize::from(lab[0]) >> 4) * AB_BINS * AB_BINS + chroma(lab[1]) * AB_BINS + chroma(lab[2])
}

impl ColourModel {
    /// Learns from weighted 8-bit Lab colours; `None` when the weights sum to less than 1.
    pub fn learn(samples: impl Iterator<Item = ([u8; 3], f32)>) -> Option<Self> {
        let mut bins = vec![0.0_f32; L_BINS * AB_BINS * AB_BINS];
        let mut total = 0.0_f32;
        for (lab, weight) in samples {
            bins[bin(lab)] += weight;
            total += weight;
        }
        if total < 1.0 {
            return None;
        }
        for value in &mut bins {
            *value /= total;
        }
        let smooth = |bins: &mut Vec<f32>| {
            smooth_axis(bins, L_BINS, AB_BINS * AB_BINS);
            smooth_axis(bins, AB_BINS, AB_BINS);
            smooth_axis(bins, AB_BINS, 1);
        };
        smooth(&mut bins);
        Some(Self { bins })
    }

    /// Likelihood of a colour; the bins sum to 1.
    pub fn likelihood(&self, lab: [u8; 3]) -> f32 {
        self.bins[bin(lab)]
    }

    /// Moves this model towards `other` by `rate` in [0, 1].
    pub fn blend(&mut self, other: &Self, rate: f32) {
        for (mine, theirs) in self.bins.iter_mut().zip(&other.bins) {
            *mine += rate * (theirs - *mine);
        }
    }

    /// Bhattacharyya distance, 0 for equal models, 1 for disjoint ones.
    pub fn distance(&self, other: &Self) -> f64 {
        let overlap: f64 = self.bins.iter().zip(&other.bins).map(|(a, b)| f64::from(a * b).sqrt()).sum();
        (1.0 - overlap).max(0.0).sqrt()
    }
}

/// Smooths one axis of `count` bins, `stride` apart, with [1 2 1] / 4.
fn smooth_axis(bins: &mut [f32], count: usize, stride: usize) {
    let block = count * stride;
    for start in (0..bins.len()).step_by(block) {
        for offset in 0..stride {
            let mut previous = bins[start + offset];
            for step in 0..count {
                let at = start + offset + step * stride;
                let here = bins[at];
                let next = if step + 1 < count { bins[at + stride] } else { here };
                bins[at] = 0.25 * (previous + next) + 0.5 * here;
                previous = here;
            }
        }
    }
}

/// `ln(f / b)` with both floored: colours nobody has seen lean to the background, as mixtures along
/// borders do.
pub fn log_odds(foreground: f32, background: f32) -> f32 {
    ((foreground + 1.2e-5) / (background + 2e-5)).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_learned_colour_is_likely_and_others_are_not() {
        let model = ColourModel::learn(std::iter::repeat_n(([120, 150, 140], 1.0), 50)).unwrap();
        assert!(model.likelihood([120, 150, 140]) > 0.05);
        assert_eq!(model.likelihood([120, 100, 140]), 0.0);
        assert!(model.distance(&model) < 1e-3);
    }
}
