//! Moving a mask's border by an exact Euclidean distance.

use agenticfocus::image::Mask;

use super::Area;

/// Every pixel no farther than `radius` from a pixel inside.
#[must_use]
pub fn grow(mask: &Mask, radius: u32) -> Mask {
    let mut grown = mask.clone();
    if let Some(area) = Area::of(mask) {
        spread(mask, &mut grown, area, radius, true);
    }
    grown
}

/// Every pixel inside that is farther than `radius` from every pixel of the picture outside. The picture's
/// border is no border of the mask: what leaves the picture stays whole there.
#[must_use]
pub fn shrink(mask: &Mask, radius: u32) -> Mask {
    let mut shrunk = mask.clone();
    if let Some(area) = Area::of(mask) {
        spread(mask, &mut shrunk, area.grown(1, mask.size()), radius, false);
    }
    shrunk
}

/// Gives `target` the value `inside` wherever a disc about a pixel of that value in `area` reaches. Runs of
/// pixels are moved as a whole: a disc's row widens a run by the same amount on both sides.
fn spread(mask: &Mask, target: &mut Mask, area: Area, radius: u32, inside: bool) {
    let size = mask.size();
    let (width, height) = (size.width as usize, i64::from(size.height));
    let radius = radius.min(size.width.max(size.height));
    let reach = i64::from(radius);
    let half_widths: Vec<usize> =
        (-reach..=reach).map(|dy| ((reach * reach - dy * dy) as f64).sqrt() as usize).collect();
    for y in area.y0..area.y1 {
        let row = &mask.data()[y as usize * width..][..width];
        for (start, end) in runs(row, area, inside) {
            for (dy, half) in (-reach..=reach).zip(&half_widths) {
                let to = i64::from(y) + dy;
                if (0..height).contains(&to) {
                    let (first, after) = (start.saturating_sub(*half), (end + half).min(width));
                    target.set_span(to as u32, first as u32..after as u32, inside);
                }
            }
        }
    }
}

/// Runs of pixels with the value `inside` in the columns of `area`.
fn runs(row: &[u8], area: Area, inside: bool) -> impl Iterator<Item = (usize, usize)> {
    let mut at = area.x0 as usize;
    let end = area.x1 as usize;
    std::iter::from_fn(move || {
        let is = |value: &u8| (*value != 0) == inside;
        let start = at + row[at..end].iter().position(is)?;
        at = row[start..end].iter().position(|value| !is(value)).map_or(end, |length| start + length);
        Some((start, at))
    })
}
