//! Filling holes.

use agenticfocus::image::Mask;

use super::Area;

/// What is known of a pixel while the outside is searched.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cell {
    /// In the mask.
    Inside,
    /// Not in the mask, not reached: a hole, if it stays so.
    Unreached,
    /// Reached from the picture's border.
    Open,
}

/// Puts everything inside that cannot be reached from the picture's border without crossing the mask (stepping
/// sideways, up and down). Tells which rectangle may have changed; `None` when the mask is empty.
pub fn fill_holes(mask: &mut Mask) -> Option<Area> {
    let area = Area::of(mask)?;
    // One ring of outside around the mask makes everything beside it one piece.
    let width = area.width() + 2;
    let mut cells = vec![Cell::Open; width * (area.height() + 2)];
    let mut pending = Vec::new();
    for (row, y) in (area.y0..area.y1).enumerate() {
        for (column, x) in (area.x0..area.x1).enumerate() {
            let at = (row + 1) * width + column + 1;
            let edge = x == area.x0 || y == area.y0 || x + 1 == area.x1 || y + 1 == area.y1;
            cells[at] = match (mask.get(x, y), edge) {
                (true, _) => Cell::Inside,
                (false, false) => Cell::Unreached,
                (false, true) => {
                    pending.push(at);
                    Cell::Open
                }
            };
        }
    }
    while let Some(at) = pending.pop() {
        for next in [at - 1, at + 1, at - width, at + width] {
            if cells[next] == Cell::Unreached {
                cells[next] = Cell::Open;
                pending.push(next);
            }
        }
    }
    for (row, y) in (area.y0..area.y1).enumerate() {
        for (column, x) in (area.x0..area.x1).enumerate() {
            if cells[(row + 1) * width + column + 1] == Cell::Unreached {
                mask.set(x, y, true);
            }
        }
    }
    Some(area)
}
