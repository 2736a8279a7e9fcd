//! Symmetric banded systems, as smoothing along a clip gives.

/// A symmetric matrix whose entries vanish farther than the bandwidth from the diagonal; the lower half is kept.
#[derive(Clone, Debug)]
pub(super) struct Banded {
    /// Entries of a row from the bandwidth before the diagonal to the diagonal.
    width: usize,
    entries: Vec<f64>,
}

impl Banded {
    /// Zeros; `bandwidth` is the largest distance from the diagonal.
    pub fn zeros(size: usize, bandwidth: usize) -> Self {
        Self { width: bandwidth + 1, entries: vec![0.0; size * (bandwidth + 1)] }
    }

    fn at(&self, row: usize, column: usize) -> usize {
        row * self.width + self.width - 1 + column - row
    }

    /// Adds `value` to an entry and its mirror, which counts once: `column` is at most `row`.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        let at = self.at(row, column);
        self.entries[at] += value;
    }

    /// Keeps variable `index` out of the system: its row and column become the identity's.
    pub fn hold(&mut self, index: usize, size: usize) {
        for column in index.saturating_sub(self.width - 1)..index {
            let at = self.at(index, column);
            self.entries[at] = 0.0;
        }
        for row in index + 1..(index + self.width).min(size) {
            let at = self.at(row, index);
            self.entries[at] = 0.0;
        }
        let at = self.at(index, index);
        self.entries[at] = 1.0;
    }

    /// Solves (A + `damping` I) x = `right` in place by Cholesky; false where that is not positive definite.
    pub fn solve(mut self, damping: f64, right: &mut [f64]) -> bool {
        let size = right.len();
        for row in 0..size {
            let first = (row + 1).saturating_sub(self.width);
            for column in first..=row {
                let from = first.max((column + 1).saturating_sub(self.width));
                let (mine, its) = (self.at(row, from), self.at(column, from));
                let shared = column - from;
                let taken: f64 = self.entries[mine..mine + shared]
                    .iter()
                    .zip(&self.entries[its..its + shared])
                    .map(|(a, b)| a * b)
                    .sum();
                let at = self.at(row, column);
                let value = self.entries[at] - taken;
                self.entries[at] = if column < row {
                    value / self.entries[self.at(column, column)]
                } else {
                    if value + damping <= 0.0 {
                        return false;
                    }
                    (value + damping).sqrt()
                };
            }
        }
        for row in 0..size {
            for column in (row + 1).saturating_sub(self.width)..row {
                right[row] -= self.entries[self.at(row, column)] * right[column];
            }
            right[row] /= self.entries[self.at(row, row)];
        }
        for row in (0..size).rev() {
            right[row] /= self.entries[self.at(row, row)];
            for column in (row + 1).saturating_sub(self.width)..row {
                right[column] -= self.entries[self.at(row, column)] * right[row];
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Cholesky, DMatrix, DVector};

    use super::*;

    #[test]
    fn it_agrees_with_a_dense_solver() {
        let (size, bandwidth) = (12, 3);
        let mut banded = Banded::zeros(size, bandwidth);
        let mut dense = DMatrix::zeros(size, size);
        for row in 0..size {
            for column in row.saturating_sub(bandwidth)..=row {
                let value = if row == column { 5.0 } else { ((row * 7 + column * 3) % 5) as f64 * 0.2 };
                banded.add(row, column, value);
                dense[(row, column)] = value;
                dense[(column, row)] = value;
            }
        }
        let right = DVector::from_fn(size, |row, _| row as f64 - 4.0);
        let mut found = right.as_slice().to_vec();
        assert!(banded.solve(0.5, &mut found));
        let exact = Cholesky::new(dense + DMatrix::identity(size, size) * 0.5).unwrap().solve(&right);
        assert!(found.iter().zip(exact.iter()).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
