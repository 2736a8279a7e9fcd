//! The rectangle of a picture that something touched.

use agenticfocus::{
    geometry::{Pixel, Size},
    image::Mask,
};

/// A rectangle of whole pixels, `x0 <= x < x1`, `y0 <= y < y1`, never empty and never beyond its picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// The column after the last.
    pub x1: u32,
    /// The row after the last.
    pub y1: u32,
}

impl Area {
    /// A whole picture; `None` where it has no pixels.
    pub fn whole(size: Size) -> Option<Self> {
        (size.area() > 0).then_some(Self { x0: 0, y0: 0, x1: size.width, y1: size.height })
    }

    /// The pixels whose centres lie in the closed rectangle between two corners; `None` when there are none
    /// in the picture or a coordinate is no number.
    pub fn between(low: Pixel, high: Pixel, size: Size) -> Option<Self> {
        if [low.x, low.y, high.x, high.y].iter().any(|value| value.is_nan()) {
            return None;
        }
        let first = |value: f64, end: u32| value.ceil().clamp(0.0, f64::from(end)) as u32;
        let after = |value: f64, end: u32| (value.floor() + 1.0).clamp(0.0, f64::from(end)) as u32;
        let (x0, y0) = (first(low.x, size.width), first(low.y, size.height));
        let (x1, y1) = (after(high.x, size.width), after(high.y, size.height));
        (x0 < x1 && y0 < y1).then_some(Self { x0, y0, x1, y1 })
    }

    /// The smallest rectangle around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            x0: self.x0.min(other.x0),
            y0: self.y0.min(other.y0),
            x1: self.x1.max(other.x1),
            y1: self.y1.max(other.y1),
        }
    }

    /// The smallest rectangle around what there is of both.
    pub fn joined(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        match (one, other) {
            (Some(one), Some(other)) => Some(one.union(other)),
            (one, other) => one.or(other),
        }
    }

    /// The rectangle around a mask's inside; `None` when it is empty.
    pub fn of(mask: &Mask) -> Option<Self> {
        let bounds = mask.bounding_box()?;
        let (x0, y0, x1, y1) = (bounds.x0 as u32, bounds.y0 as u32, bounds.x1 as u32, bounds.y1 as u32);
        Some(Self { x0, y0, x1, y1 })
    }

    /// Grown by `margin` pixels on every side, within a picture of `size`.
    #[must_use]
    pub fn grown(self, margin: u32, size: Size) -> Self {
        Self {
            x0: self.x0.saturating_sub(margin),
            y0: self.y0.saturating_sub(margin),
            x1: self.x1.saturating_add(margin).min(size.width),
            y1: self.y1.saturating_add(margin).min(size.height),
        }
    }

    /// Columns.
    pub const fn width(&self) -> usize {
        (self.x1 - self.x0) as usize
    }

    /// Rows.
    pub const fn height(&self) -> usize {
        (self.y1 - self.y0) as usize
    }
}

/// Puts the pixels of row `y` of an area whose centres lie in `from..=to` inside or outside.
pub(super) fn set_span(mask: &mut Mask, (area, y): (Area, u32), from: f64, to: f64, inside: bool) {
    // Comparisons with a value that is no number are false: such a span has no pixels.
    if from <= to {
        // What lies beyond the area is rounding: far away, a pixel is less than a float's last digit.
        let (low, high) = (f64::from(area.x0), f64::from(area.x1));
        let (first, after) = (from.ceil().clamp(low, high), (to.floor() + 1.0).clamp(low, high));
        mask.set_span(y, first as u32..after as u32, inside);
    }
}
