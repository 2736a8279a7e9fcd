//! Filling holes.

use agenticfocus::image::Mask;

use super::Area;

/// Puts everything inside that cannot be reached from the picture's border without crossing the mask (stepping
/// sideways, up and down). Tells which rectangle may have changed; `None` when the mask is empty.
pub fn fill_holes(mask: &mut Mask) -> Option<Area> {
    let area = Area::of(mask)?;
    // One ring of outside around the mask makes everything beside it one piece.
    let (width, height) = (area.width() + 2, area.height() + 2);
    let mut open = vec![false; width * height];
    let is_inside = |at: usize| {
        let (x, y) = (at % width, at / width);
        let ring = x == 0 || y == 0 || x == width - 1 || y == height - 1;
        !ring && mask.get(area.x0 + x as u32 - 1, area.y0 + y as u32 - 1)
    };
    let mut pending = vec![0];
    open[0] = true;
    while let Some(at) = pending.pop() {
        let (x, y) = (at % width, at / width);
        let beside = [
            (x > 0).then(|| at - 1),
            (x + 1 < width).then_some(at + 1),
            (y > 0).then(|| at - width),
            (y + 1 < height).then_some(at + width),
        ];
        for next in beside.into_iter().flatten() {
            if !open[next] && !is_inside(next) {
                open[next] = true;
                pending.push(next);
            }
        }
    }
    for y in area.y0..area.y1 {
        for x in area.x0..area.x1 {
            let at = (y - area.y0 + 1) as usize * width + (x - area.x0 + 1) as usize;
            if !open[at] {
                mask.set(x, y, true);
            }
        }
    }
    Some(area)
}
