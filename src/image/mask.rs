//! Binary masks.

use crate::geometry::{PixelBox, Size};

/// A binary mask, one byte a pixel: 0 outside, 255 inside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    size: Size,
    data: Vec<u8>,
}

impl Mask {
    /// An empty mask.
    pub fn new(size: Size) -> Self {
        Self { size, data: vec![0; size.area()] }
    }

    /// Every non-zero byte is inside; `None` when the length is not `width * height`.
    pub fn from_bytes(size: Size, mut data: Vec<u8>) -> Option<Self> {
        if data.len() != size.area() {
            return None;
        }
        for value in &mut data {
            *value = if *value == 0 { 0 } else { 255 };
        }
        Some(Self { size, data })
    }

    /// A mask made by asking `inside(x, y)` for every pixel.
    pub fn from_fn(size: Size, inside: impl Fn(u32, u32) -> bool) -> Self {
        let mut mask = Self::new(size);
        for y in 0..size.height {
            for x in 0..size.width {
                mask.set(x, y, inside(x, y));
            }
        }
        mask
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Bytes, row after row, 0 or 255.
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// Whether column `x`, row `y` is inside; false beyond the border.
    pub fn get(&self, x: u32, y: u32) -> bool {
        x < self.size.width
            && y < self.size.height
            && self.data[y as usize * self.size.width as usize + x as usize] != 0
    }

    /// Puts column `x`, row `y` inside or outside.
    pub fn set(&mut self, x: u32, y: u32, inside: bool) {
        self.data[y as usize * self.size.width as usize + x as usize] = if inside { 255 } else { 0 };
    }

    /// Puts the columns `columns` of row `y` inside or outside; what lies beyond the border is left out.
    pub fn set_span(&mut self, y: u32, columns: std::ops::Range<u32>, inside: bool) {
        let (first, after) = (columns.start.min(self.size.width), columns.end.min(self.size.width));
        if y < self.size.height && first < after {
            let row = y as usize * self.size.width as usize;
            self.data[row + first as usize..row + after as usize].fill(if inside { 255 } else { 0 });
        }
    }

    /// Pixels inside.
    pub fn area(&self) -> usize {
        self.data.iter().filter(|value| **value != 0).count()
    }

    /// Whether nothing is inside.
    pub fn is_empty(&self) -> bool {
        self.data.iter().all(|value| *value == 0)
    }

    /// The tight box around the inside; `None` when empty.
    pub fn bounding_box(&self) -> Option<PixelBox> {
        let width = self.size.width as usize;
        let (mut x0, mut x1, mut y0, mut y1) = (usize::MAX, 0, usize::MAX, 0);
        for (y, row) in self.data.chunks_exact(width.max(1)).enumerate() {
            if let (Some(first), Some(last)) =
                (row.iter().position(|v| *v != 0), row.iter().rposition(|v| *v != 0))
            {
                x0 = x0.min(first);
                x1 = x1.max(last + 1);
                y0 = y0.min(y);
                y1 = y + 1;
            }
        }
        (x1 > 0).then_some(PixelBox { x0: x0 as f64, y0: y0 as f64, x1: x1 as f64, y1: y1 as f64 })
    }

    /// Pixels inside both. Masks of different sizes share nothing.
    pub fn intersection_area(&self, other: &Self) -> usize {
        if self.size != other.size {
            return 0;
        }
        self.data.iter().zip(&other.data).filter(|(a, b)| **a != 0 && **b != 0).count()
    }

    /// Intersection over union, the DAVIS J; 1 when both are empty.
    pub fn iou(&self, other: &Self) -> f64 {
        let intersection = self.intersection_area(other);
        let union = self.area() + other.area() - intersection;
        if union == 0 { 1.0 } else { intersection as f64 / union as f64 }
    }

    /// Pixelwise combination with a mask of the same size.
    ///
    /// # Panics
    /// When the sizes differ: callers combine masks of one clip.
    #[must_use]
    pub fn combined(&self, other: &Self, keep: impl Fn(bool, bool) -> bool) -> Self {
        assert_eq!(self.size, other.size, "masks of one clip have one size");
        let data = self.data.iter().zip(&other.data);
        let data = data.map(|(a, b)| if keep(*a != 0, *b != 0) { 255 } else { 0 }).collect();
        Self { size: self.size, data }
    }

    /// `self ∪ other`.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        self.combined(other, |a, b| a || b)
    }

    /// `self ∩ other`.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        self.combined(other, |a, b| a && b)
    }

    /// `self ∩ ¬other`.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        self.combined(other, |a, b| a && !b)
    }
}
