//! The border of a mask as closed lines along the edges of pixels.

use agenticfocus::image::Mask;

use super::Area;

/// A closed line between pixels inside and outside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outline {
    /// Where it turns, in columns and rows: (x, y) is the top-left corner of that pixel. The inside lies on
    /// the right-hand side of the way.
    pub corners: Vec<[u32; 2]>,
    /// A pixel inside that the line runs along.
    pub inside: [u32; 2],
}

/// East, south, west, north.
const STEPS: [[i64; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// All lines around a mask and its holes. Pixels that touch at a corner alone get lines of their own.
pub fn outline(mask: &Mask) -> Vec<Outline> {
    let Some(area) = Area::of(mask) else { return Vec::new() };
    let width = area.width();
    // Every closed line goes east somewhere, along the top edge of a pixel inside.
    let mut walked = vec![false; width * area.height()];
    let mut lines = Vec::new();
    let row = |y: u32| &mask.data()[y as usize * mask.size().width as usize..][..mask.size().width as usize];
    for y in area.y0..area.y1 {
        let above = (y > 0).then(|| row(y - 1));
        let own = row(y);
        for x in area.x0..area.x1 {
            let at = x as usize;
            let starts = own[at] != 0 && above.is_none_or(|above| above[at] == 0);
            if starts && !walked[(y - area.y0) as usize * width + (x - area.x0) as usize] {
                lines.push(walk(mask, [x, y], |x, y| {
                    walked[(y - area.y0) as usize * width + (x - area.x0) as usize] = true;
                }));
            }
        }
    }
    lines
}

/// Follows the line that goes east along the top edge of the pixel `start`, calling `walked` for each top
/// edge.
fn walk(mask: &Mask, start: [u32; 2], mut walked: impl FnMut(u32, u32)) -> Outline {
    let is_inside = |x: i64, y: i64| x >= 0 && y >= 0 && mask.get(x as u32, y as u32);
    let first = [i64::from(start[0]), i64::from(start[1])];
    let (mut at, mut heading) = (first, 0);
    let mut corners = Vec::new();
    loop {
        if heading == 0 {
            walked(at[0] as u32, at[1] as u32);
        }
        at = [at[0] + STEPS[heading][0], at[1] + STEPS[heading][1]];
        // The pixels ahead to the left and to the right of the way, as their top-left corners.
        let [left, right] = match heading {
            0 => [[at[0], at[1] - 1], at],
            1 => [at, [at[0] - 1, at[1]]],
            2 => [[at[0] - 1, at[1]], [at[0] - 1, at[1] - 1]],
            _ => [[at[0] - 1, at[1] - 1], [at[0], at[1] - 1]],
        };
        let turn = if !is_inside(right[0], right[1]) {
            1
        } else if is_inside(left[0], left[1]) {
            3
        } else {
            0
        };
        if turn != 0 {
            corners.push([at[0] as u32, at[1] as u32]);
        }
        heading = (heading + turn) % 4;
        if at == first && heading == 0 {
            return Outline { corners, inside: start };
        }
    }
}
