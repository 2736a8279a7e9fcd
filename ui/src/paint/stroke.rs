//! The brush: a disc moved along a line.

use agenticfocus::{geometry::Pixel, image::Mask};

use super::area::{Area, set_span};

/// With a smaller radius a slanted line would fall between pixel centres and leave gaps.
const SMALLEST_RADIUS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Puts every pixel whose centre is no farther than `radius` from the line between `from` and `to` inside or
/// outside, and tells where it worked; `None` when nothing lies in the picture.
pub fn stroke(mask: &mut Mask, from: Pixel, to: Pixel, radius: f64, inside: bool) -> Option<Area> {
    let radius = if radius.is_finite() { radius.max(SMALLEST_RADIUS) } else { return None };
    if ![from.x, from.y, to.x, to.y].iter().all(|value| value.is_finite()) {
        return None;
    }
    let low = Pixel::new(from.x.min(to.x) - radius, from.y.min(to.y) - radius);
    let high = Pixel::new(from.x.max(to.x) + radius, from.y.max(to.y) + radius);
    let area = Area::between(low, high, mask.size())?;
    for y in area.y0..area.y1 {
        if let Some((left, right)) = row_of_capsule(from, to, radius, f64::from(y)) {
            set_span(mask, (area, y), left, right, inside);
        }
    }
    Some(area)
}

/// Where row `y` cuts the set of points no farther than `radius` from a line: the set is convex, so its cut
/// is the hull of the cuts of its parts.
fn row_of_capsule(from: Pixel, to: Pixel, radius: f64, y: f64) -> Option<(f64, f64)> {
    let parts = [row_of_disc(from, radius, y), row_of_disc(to, radius, y), row_of_band(from, to, radius, y)];
    parts.into_iter().flatten().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

fn row_of_disc(centre: Pixel, radius: f64, y: f64) -> Option<(f64, f64)> {
    let half = radius * radius - (y - centre.y).powi(2);
    (half >= 0.0).then(|| (centre.x - half.sqrt(), centre.x + half.sqrt()))
}

/// The rectangle beside the line, without the round ends.
fn row_of_band(from: Pixel, to: Pixel, radius: f64, y: f64) -> Option<(f64, f64)> {
    let length = from.distance(to);
    if length < 1e-9 || !length.is_finite() {
        return None;
    }
    let (ux, uy) = ((to.x - from.x) / length, (to.y - from.y) / length);
    let rise = y - from.y;
    // 0 <= along <= length and -radius <= across <= radius, both linear in x.
    let along = between(ux, rise * uy, 0.0, length)?;
    let across = between(-uy, rise * ux, -radius, radius)?;
    let (left, right) = (from.x + along.0.max(across.0), from.x + along.1.min(across.1));
    (left <= right).then_some((left, right))
}

/// The x with `low <= slope * x + offset <= high`.
fn between(slope: f64, offset: f64, low: f64, high: f64) -> Option<(f64, f64)> {
    if slope.abs() < 1e-12 {
        return (low <= offset && offset <= high).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (a, b) = ((low - offset) / slope, (high - offset) / slope);
    Some((a.min(b), a.max(b)))
}
