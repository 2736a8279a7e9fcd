//! Boxes and polygons.

use agenticfocus::{
    geometry::{Pixel, PixelBox},
    image::Mask,
};

use super::area::{Area, set_span};

/// Puts the columns and rows that a box covers by half or more inside or outside; `None` when there are none
/// in the picture.
pub fn fill_box(mask: &mut Mask, pixel_box: &PixelBox, inside: bool) -> Option<Area> {
    // A box counts from the corner of the first pixel, positions count from its centre; its far edges are
    // exclusive.
    let low = Pixel::new(pixel_box.x0 - 0.5, pixel_box.y0 - 0.5);
    let high = Pixel::new(pixel_box.x1 - 0.5 - 1e-9, pixel_box.y1 - 0.5 - 1e-9);
    let area = Area::between(low, high, mask.size())?;
    for y in area.y0..area.y1 {
        mask.set_span(y, area.x0..area.x1, inside);
    }
    Some(area)
}

/// Puts the pixels whose centres a closed line encloses an odd number of times inside or outside; corners
/// that are no numbers are left out. `None` when nothing lies in the picture.
pub fn fill_polygon(mask: &mut Mask, corners: &[Pixel], inside: bool) -> Option<Area> {
    // Far corners keep their direction and stay where arithmetic is exact enough.
    let bounded = |value: f64| value.clamp(-1e7, 1e7);
    let finite = corners.iter().filter(|corner| corner.x.is_finite() && corner.y.is_finite());
    let corners: Vec<Pixel> = finite.map(|c| Pixel::new(bounded(c.x), bounded(c.y))).collect();
    if corners.len() < 3 {
        return None;
    }
    let extent = |pick: fn(&Pixel) -> f64| {
        let values = corners.iter().map(pick);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let ((x0, x1), (y0, y1)) = (extent(|c| c.x), extent(|c| c.y));
    let area = Area::between(Pixel::new(x0, y0), Pixel::new(x1, y1), mask.size())?;
    let mut crossings = Vec::new();
    for y in area.y0..area.y1 {
        crossings_of_row(&corners, f64::from(y), &mut crossings);
        for pair in crossings.as_chunks::<2>().0 {
            set_span(mask, (area, y), pair[0], pair[1], inside);
        }
    }
    Some(area)
}

/// Where the closed line crosses row `y`, sorted. A corner on the row belongs to the edge below it.
fn crossings_of_row(corners: &[Pixel], y: f64, crossings: &mut Vec<f64>) {
    crossings.clear();
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    for (a, b) in ends {
        if (a.y <= y) != (b.y <= y) {
            crossings.push(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
        }
    }
    crossings.sort_by(f64::total_cmp);
}
