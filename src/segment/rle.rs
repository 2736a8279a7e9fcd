//! Lossless run-length masks in COCO's column-major order.

use serde::{Deserialize, Serialize};

use crate::{geometry::Size, image::Mask};

/// A mask as alternating run lengths, outside first, down the columns (COCO's uncompressed RLE).
///
/// Holes, several components, empty and full masks survive exactly.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct RleMask {
    size: Size,
    counts: Vec<u32>,
}

#[derive(Deserialize)]
struct Unchecked {
    size: Size,
    counts: Vec<u32>,
}

/// Why run lengths were refused.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum RleError {
    /// The runs do not cover the picture.
    #[error("run lengths sum to {found} pixels, expected {expected} for a {size} picture")]
    Length {
        /// The picture.
        size: Size,
        /// Its pixels.
        expected: u64,
        /// The runs' pixels.
        found: u64,
    },
}

impl TryFrom<Unchecked> for RleMask {
    type Error = RleError;
    fn try_from(raw: Unchecked) -> Result<Self, RleError> {
        Self::from_counts(raw.size, raw.counts)
    }
}

impl RleMask {
    /// Checked run lengths.
    ///
    /// # Errors
    /// When they do not sum to the picture's area.
    pub fn from_counts(size: Size, counts: Vec<u32>) -> Result<Self, RleError> {
        let found: u64 = counts.iter().map(|count| u64::from(*count)).sum();
        let expected = u64::from(size.width) * u64::from(size.height);
        if found != expected {
            return Err(RleError::Length { size, expected, found });
        }
        Ok(Self { size, counts })
    }

    /// The empty mask.
    pub fn empty(size: Size) -> Self {
        Self { size, counts: vec![size.area() as u32] }
    }

    /// Encodes `mask`.
    pub fn encode(mask: &Mask) -> Self {
        let size = mask.size();
        let (width, height) = (size.width as usize, size.height as usize);
        let data = mask.data();
        let (mut counts, mut run, mut inside) = (Vec::new(), 0_u32, false);
        for x in 0..width {
            for y in 0..height {
                let value = data[y * width + x] != 0;
                if value != inside {
                    counts.push(run);
                    (run, inside) = (0, value);
                }
                run += 1;
            }
        }
        counts.push(run);
        Self { size, counts }
    }

    /// Decodes to a picture mask.
    pub fn decode(&self) -> Mask {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let mut data = vec![0; self.size.area()];
        let (mut position, mut inside) = (0_usize, false);
        for count in &self.counts {
            let end = position + *count as usize;
            if inside {
                for index in position..end {
                    data[(index % height) * width + index / height] = 255;
                }
            }
            (position, inside) = (end, !inside);
        }
        Mask::from_bytes(self.size, data).unwrap_or_else(|| Mask::new(self.size))
    }

    /// What is inside this mask and outside of `other`, which has the same size; all of it where the sizes differ.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        if self.size != other.size || other.is_empty() {
            return self.clone();
        }
        let (mut mine, mut theirs) = (Runs::of(self), Runs::of(other));
        let (mut counts, mut run, mut inside) = (Vec::new(), 0_u32, false);
        while let Some(length) = mine.left().zip(theirs.left()).map(|(a, b)| a.min(b)) {
            let value = mine.inside && !theirs.inside;
            if value != inside {
                counts.push(run);
                (run, inside) = (0, value);
            }
            run += length;
            mine.advance(length);
            theirs.advance(length);
        }
        counts.push(run);
        Self { size: self.size, counts }
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Alternating run lengths, outside first.
    pub fn counts(&self) -> &[u32] {
        &self.counts
    }

    /// Pixels inside.
    pub fn area(&self) -> u64 {
        self.counts.iter().skip(1).step_by(2).map(|count| u64::from(*count)).sum()
    }

    /// Whether nothing is inside.
    pub fn is_empty(&self) -> bool {
        self.area() == 0
    }
}

/// A walk along the runs of a mask.
struct Runs<'a> {
    counts: &'a [u32],
    walked: u32,
    inside: bool,
}

impl<'a> Runs<'a> {
    fn of(mask: &'a RleMask) -> Self {
        let mut runs = Self { counts: &mask.counts, walked: 0, inside: false };
        runs.advance(0);
        runs
    }

    /// Pixels to the end of the present run; `None` at the end of the picture.
    fn left(&self) -> Option<u32> {
        self.counts.first().map(|count| count - self.walked)
    }

    /// Walks on by no more than what is left, past empty runs.
    fn advance(&mut self, length: u32) {
        self.walked += length;
        while let Some((count, rest)) = self.counts.split_first()
            && *count <= self.walked
        {
            self.walked -= count;
            self.counts = rest;
            self.inside = !self.inside;
        }
    }
}
