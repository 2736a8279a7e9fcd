//! Colour models: smoothed Lab histograms (after Jones and Rehg 2002).

/// Bins along L, a and b.
const BINS: [usize; 3] = [16, 32, 32];
const CELLS: usize = BINS[0] * BINS[1] * BINS[2];
/// What every cell counts beforehand.
const UNSEEN: f64 = 0.02;

/// A histogram of 8-bit Lab pixels (OpenCV's `COLOR_RGB2Lab` scaling) with 16×32×32 bins.
#[derive(Clone, Debug)]
pub struct LabHistogram {
    counts: Vec<f32>,
    total: f64,
}

impl Default for LabHistogram {
    fn default() -> Self {
        Self { counts: vec![0.0; CELLS], total: 0.0 }
    }
}

/// The cell of a Lab pixel.
fn cell(lab: [u8; 3]) -> usize {
    let (l, a, b) = (usize::from(lab[0]) >> 4, usize::from(lab[1]) >> 3, usize::from(lab[2]) >> 3);
    (l * BINS[1] + a) * BINS[2] + b
}

impl LabHistogram {
    /// Counts one pixel.
    pub fn add(&mut self, lab: [u8; 3]) {
        self.add_weighted(lab, 1.0);
    }

    /// Counts one pixel with a weight.
    pub fn add_weighted(&mut self, lab: [u8; 3], weight: f32) {
        self.counts[cell(lab)] += weight;
        self.total += f64::from(weight);
    }

    /// Adds all counts of `other`.
    pub fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.counts.iter_mut().zip(&other.counts) {
            *mine += theirs;
        }
        self.total += other.total;
    }

    /// Weight counted so far.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Convolved along each axis with [1 2 1]/4 `times` times: neighbours of seen colours become likely too.
    #[must_use]
    pub fn smoothed(&self, times: usize) -> Self {
        let mut counts = self.counts.clone();
        for _ in 0..times {
            for (stride, length) in [(BINS[1] * BINS[2], BINS[0]), (BINS[2], BINS[1]), (1, BINS[2])] {
                counts = smoothed_along(&counts, stride, length);
            }
        }
        Self { counts, total: self.total }
    }

    /// The probability of the pixel's cell, at least a floor that stands for colours never seen.
    pub fn density(&self, lab: [u8; 3]) -> f64 {
        self.cell_density(cell(lab))
    }

    fn cell_density(&self, cell: usize) -> f64 {
        (f64::from(self.counts[cell]) + UNSEEN) / (self.total + UNSEEN * CELLS as f64)
    }

    /// The density of a colour never seen.
    fn floor(&self) -> f64 {
        UNSEEN / (self.total + UNSEEN * CELLS as f64)
    }

    /// A table of P(self | colour) against `other` with even priors, 0 to 255, for [`Self::look_up`].
    pub fn posterior_table(&self, other: &Self) -> Vec<u8> {
        self.posterior_table_above(other, 0.0)
    }

    /// [`Self::posterior_table`] for counts of very different sizes: of two histograms the smaller thinks more of
    /// colours that neither has seen; here such colours are even (127 or 128).
    pub fn fair_posterior_table(&self, other: &Self) -> Vec<u8> {
        self.posterior_table_above(other, self.floor().max(other.floor()))
    }

    /// The table with densities of at least `least`.
    fn posterior_table_above(&self, other: &Self, least: f64) -> Vec<u8> {
        (0..CELLS)
            .map(|cell| {
                let (mine, theirs) =
                    (self.cell_density(cell).max(least), other.cell_density(cell).max(least));
                (255.0 * mine / (mine + theirs)).round() as u8
            })
            .collect()
    }

    /// The table's value for a pixel.
    pub fn look_up(table: &[u8], lab: [u8; 3]) -> u8 {
        table[cell(lab)]
    }

    /// Bhattacharyya distance to `other`, 0 (same) to 1 (nothing in common).
    pub fn distance(&self, other: &Self) -> f64 {
        if self.total <= 0.0 || other.total <= 0.0 {
            return 1.0;
        }
        let norm = (self.total * other.total).sqrt();
        let overlap: f64 =
            self.counts.iter().zip(&other.counts).map(|(a, b)| (f64::from(*a) * f64::from(*b)).sqrt()).sum();
        (1.0 - (overlap / norm).min(1.0)).sqrt()
    }
}

fn smoothed_along(counts: &[f32], stride: usize, length: usize) -> Vec<f32> {
    (0..CELLS)
        .map(|index| {
            let position = (index / stride) % length;
            let before = if position > 0 { counts[index - stride] } else { counts[index] };
            let after = if position + 1 < length { counts[index + stride] } else { counts[index] };
            0.25 * before + 0.5 * counts[index] + 0.25 * after
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn posterior_prefers_the_histogram_that_saw_the_colour() {
        let (mut skin, mut table) = (LabHistogram::default(), LabHistogram::default());
        (0..100).for_each(|_| skin.add([150, 145, 150]));
        (0..100).for_each(|_| table.add([60, 128, 128]));
        let posterior = skin.smoothed(1).posterior_table(&table.smoothed(1));
        assert!(LabHistogram::look_up(&posterior, [150, 145, 150]) > 240);
        assert!(LabHistogram::look_up(&posterior, [150, 153, 150]) > 200, "neighbouring cell is likely too");
        assert!(LabHistogram::look_up(&posterior, [60, 128, 128]) < 15);
    }

    #[test]
    fn a_small_histogram_claims_no_colours_that_it_has_not_seen() {
        let (mut object, mut skin) = (LabHistogram::default(), LabHistogram::default());
        for _ in 0..100 {
            object.add([60, 128, 128]);
        }
        for _ in 0..100_000 {
            skin.add([150, 145, 150]);
        }
        let claimed = LabHistogram::look_up(&object.posterior_table(&skin), [200, 90, 90]);
        let table = object.fair_posterior_table(&skin);
        assert!(claimed > 240, "{claimed}");
        assert!((127..=128).contains(&LabHistogram::look_up(&table, [200, 90, 90])));
        assert!(LabHistogram::look_up(&table, [60, 128, 128]) > 240);
        assert!(LabHistogram::look_up(&table, [150, 145, 150]) < 15);
    }

    #[test]
    fn distance_is_zero_to_itself_and_one_to_a_stranger() {
        let (mut a, mut b) = (LabHistogram::default(), LabHistogram::default());
        a.add([10, 10, 10]);
        b.add([200, 10, 10]);
        assert!(a.distance(&a) < 1e-6);
        assert!((a.distance(&b) - 1.0).abs() < 1e-6);
    }
}
