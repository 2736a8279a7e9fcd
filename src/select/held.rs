//! What stays in a hand: places that move with it and keep their place relative to it over many frames.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Vec3b},
    imgproc,
};

use super::{SelectError, arm_colours::ArmColours, motion::Moment, scene::to_lab};
use crate::{
    geometry::{Pixel, Side},
    landmarks::keypoint,
    vision::{WorkScale, binary},
};

/// Cells a side of the grid that moves with the hand.
const CELLS: usize = 96;
/// Cells a palm's width.
const CELLS_A_PALM: f64 = 12.0;
/// Share of its sights in which a cell of a held thing is seen to move with the hand.
const MOSTLY: f64 = 0.15;

/// A thing that a hand holds at several moments.
pub(super) struct Held {
    /// Index of the frame on which it is shown.
    pub index: usize,
    /// CV_8UC1, work size, on that frame.
    pub shape: Mat,
    /// CV_8UC1: what may belong to it.
    pub around: Mat,
    /// Moments that show it.
    pub sights: usize,
    /// Mean share of sights in which its cells move with the hand, 0 to 1.
    pub steady: f64,
    /// Whether it reaches the picture's border, where arms and bodies come from.
    pub at_border: bool,
    /// How much it looks like an arm, 0 to 1.
    pub arm_like: f64,
    /// Area in squares of the palm's width.
    pub relative_area: f64,
}

/// The hand's own frame on a picture: origin between the knuckles, x away from the wrist, in palm widths.
#[derive(Clone, Copy)]
struct Palm {
    origin: Pixel,
    along: (f64, f64),
}

impl Palm {
    fn new(points: &[Pixel], width: f64) -> Option<Self> {
        let mut middle = Pixel::new(0.0, 0.0);
        for knuckle in [5, 9, 13, 17] {
            middle.x += 0.25 * points[knuckle].x;
            middle.y += 0.25 * points[knuckle].y;
        }
        let (x, y) = (middle.x - points[0].x, middle.y - points[0].y);
        let length = x.hypot(y);
        let along = (x / length * width, y / length * width);
        (length > 1e-6 && width > 1e-6).then_some(Self { origin: middle, along })
    }

    fn to_picture(self, (u, v): (f64, f64)) -> Pixel {
        let (x, y) = self.along;
        Pixel::new(self.origin.x + u * x - v * y, self.origin.y + u * y + v * x)
    }

    fn to_hand(self, p: Pixel) -> (f64, f64) {
        let (x, y) = self.along;
        let (dx, dy) = (p.x - self.origin.x, p.y - self.origin.y);
        let square = x * x + y * y;
        ((dx * x + dy * y) / square, (dy * x - dx * y) / square)
    }
}

/// Where the centre of cell `at` lies in the hand's frame.
fn cell_centre(at: usize) -> (f64, f64) {
    let half = 0.5 * CELLS as f64;
    (((at % CELLS) as f64 + 0.5 - half) / CELLS_A_PALM, ((at / CELLS) as f64 + 0.5 - half) / CELLS_A_PALM)
}

/// The cell around a place in the hand's frame.
fn cell_of((u, v): (f64, f64)) -> Option<usize> {
    let half = 0.5 * CELLS as f64;
    let (x, y) = ((u * CELLS_A_PALM + half).floor(), (v * CELLS_A_PALM + half).floor());
    let inside = |value: f64| (0.0..CELLS as f64).contains(&value);
    (inside(x) && inside(y)).then(|| y as usize * CELLS + x as usize)
}

/// Things that either hand holds over `moments`, which belong to pictures of `scale`.
pub(super) fn held(
    moments: &[Moment],
    scale: &WorkScale,
    arms: &ArmColours,
) -> Result<Vec<Held>, SelectError> {
    let mut found = Vec::new();
    for side in Side::BOTH {
        let grips: Vec<(Palm, &Moment)> = moments
            .iter()
            .filter(|moment| moment.hand.side == side)
            .filter_map(|moment| Some((Palm::new(&moment.hand.keypoints, moment.hand.palm_width)?, moment)))
            .collect();
        if grips.len() < 4 {
            continue;
        }
        for region in regions(&grips, scale)? {
            found.extend(shown_best(&grips, &region, scale, arms)?);
        }
    }
    Ok(found)
}

/// A region of the hand's frame that mostly moves with the hand.
struct Region {
    inside: Vec<bool>,
    steady: f64,
}

fn regions(grips: &[(Palm, &Moment)], scale: &WorkScale) -> Result<Vec<Region>, SelectError> {
    let (columns, rows) = (i64::from(scale.work.width), i64::from(scale.work.height));
    let (mut votes, mut sights) = (vec![0_u32; CELLS * CELLS], vec![0_u32; CELLS * CELLS]);
    for (palm, moment) in grips {
        for at in 0..CELLS * CELLS {
            let p = palm.to_picture(cell_centre(at));
            let (x, y) = (p.x.round() as i64, p.y.round() as i64);
            if x < 0 || y < 0 || x >= columns || y >= rows {
                continue;
            }
            let place = (y * columns + x) as usize;
            if moment.seen[place] {
                sights[at] += 1;
                votes[at] += u32::from(moment.moving[place]);
            }
        }
    }
    let enough = (grips.len() as u32 / 4).max(3);
    let share = |at: usize| {
        f64::from(votes[at]) / f64::from(sights[at].max(1)) * f64::from(u8::from(sights[at] >= enough))
    };
    let mut mostly = binary::empty(CELLS as i32, CELLS as i32)?;
    for (at, value) in mostly.data_bytes_mut()?.iter_mut().enumerate() {
        let (u, v) = cell_centre(at);
        // The forearm lies behind the wrist.
        let behind = u < -1.0 && v.abs() < 0.9 * -u;
        *value = if share(at) > MOSTLY && !behind { 255 } else { 0 };
    }
    let mostly = binary::opened(&binary::closed(&mostly, 1)?, 1)?;
    let tips: Vec<(f64, f64)> = grips
        .iter()
        .flat_map(|(palm, moment)| keypoint::TIPS.iter().map(|k| palm.to_hand(moment.hand.keypoints[*k])))
        .collect();
    let (found, labels) = binary::components(&mostly)?;
    let mut regions = Vec::new();
    for component in found.iter().filter(|c| f64::from(c.area) > 0.05 * CELLS_A_PALM * CELLS_A_PALM) {
        let inside: Vec<bool> = labels.iter().map(|label| *label == component.label).collect();
        let cells = || inside.iter().enumerate().filter(|(_, inside)| **inside).map(|(at, _)| at);
        let gap = |at: usize| {
            let (u, v) = cell_centre(at);
            tips.iter().map(|(x, y)| (x - u).hypot(y - v)).fold(f64::INFINITY, f64::min)
        };
        if cells().map(gap).fold(f64::INFINITY, f64::min) > 0.5 {
            continue;
        }
        let steady = cells().map(share).sum::<f64>() / f64::from(component.area);
        regions.push(Region { inside, steady });
    }
    Ok(regions)
}

fn mask_of(inside: &[bool], scale: &WorkScale) -> opencv::Result<Mat> {
    let mut mask = binary::empty(scale.work.height as i32, scale.work.width as i32)?;
    for (value, inside) in mask.data_bytes_mut()?.iter_mut().zip(inside) {
        *value = if *inside { 255 } else { 0 };
    }
    Ok(mask)
}

/// The moment that shows most of a region, cut to what moves with the hand there.
fn shown_best(
    grips: &[(Palm, &Moment)],
    region: &Region,
    scale: &WorkScale,
    arms: &ArmColours,
) -> Result<Option<Held>, SelectError> {
    let columns = scale.work.width as usize;
    let mut best: Option<(f64, usize, Vec<bool>)> = None;
    let mut sights = 0;
    for (number, (palm, moment)) in grips.iter().enumerate() {
        let within: Vec<bool> = (0..moment.seen.len())
            .map(|at| {
                let p = Pixel::new((at % columns) as f64, (at / columns) as f64);
                cell_of(palm.to_hand(p)).is_some_and(|cell| region.inside[cell])
            })
            .collect();
        let inside = within.iter().filter(|within| **within).count() as f64;
        let hit: Vec<bool> =
            within.iter().zip(&moment.moving).map(|(within, moving)| *within && *moving).collect();
        let share = hit.iter().filter(|hit| **hit).count() as f64 / inside.max(1.0);
        sights += usize::from(share > 0.15);
        let palm = palm.along.0.hypot(palm.along.1);
        let score = share * inside / (palm * palm);
        if best.as_ref().is_none_or(|(other, _, _)| score > *other) {
            best = Some((score, number, hit));
        }
    }
    let Some((_, number, hit)) = best else { return Ok(None) };
    let (palm, moment) = &grips[number];
    let palm = palm.along.0.hypot(palm.along.1);
    let core = mask_of(&hit, scale)?;
    // All that moves with the hand and hangs together with the steady part.
    let near = binary::dilated(&core, (0.5 * palm).round().clamp(2.0, 20.0) as i32)?;
    let moving = binary::closed(&mask_of(&moment.moving, scale)?, 3)?;
    let moving = binary::map2(&moving, &near, |a, b| a & b)?;
    let moving = binary::map2(&moving, &mask_of(&moment.seen, scale)?, |a, b| a & b)?;
    let shape = binary::touching(&binary::opened(&moving, 1)?, &core)?;
    let lab = to_lab(&moment.view)?;
    let pixels = lab.data_typed::<Vec3b>()?.iter().zip(shape.data_bytes()?);
    let colours: Vec<[u8; 3]> = pixels.filter(|(_, inside)| **inside != 0).map(|(lab, _)| lab.0).collect();
    if colours.len() < 12 {
        return Ok(None);
    }
    let rect = imgproc::bounding_rect(&shape)?;
    let at_border = rect.x <= 1
        || rect.y <= 1
        || rect.x + rect.width >= shape.cols() - 1
        || rect.y + rect.height >= shape.rows() - 1;
    Ok(Some(Held {
        at_border,
        index: moment.index,
        shape,
        around: near,
        sights,
        steady: region.steady,
        arm_like: arms.share_of_all(&colours),
        relative_area: colours.len() as f64 / (palm * palm),
    }))
}
