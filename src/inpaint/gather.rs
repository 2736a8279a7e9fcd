//! Which frames a plate reads: nearest in time first, each for cells that still lack samples.

use nalgebra::Vector3;

use super::{
    InpaintParams,
    survey::{CELL, Survey},
};

/// A plate's canvas in cells: the frame with a margin on every side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Canvas {
    pub columns: usize,
    pub rows: usize,
    /// Cells of margin on every side.
    pub margin: usize,
}

impl Canvas {
    pub fn new(survey: &Survey, margin: f64) -> Self {
        let margin = (margin * survey.columns as f64).round() as usize;
        Self { columns: survey.columns + 2 * margin, rows: survey.rows + 2 * margin, margin }
    }

    /// Centre of a cell in work pixels of the key frame.
    fn centre(&self, cell: usize) -> Vector3<f64> {
        let place = |index: usize| (index as f64 - self.margin as f64 + 0.5) * CELL as f64 - 0.5;
        Vector3::new(place(cell % self.columns), place(cell / self.columns), 1.0)
    }
}

/// Cells of the canvas of `key` that any frame of `frames` draws its hole from.
pub(super) fn needed_cells(
    survey: &Survey,
    canvas: &Canvas,
    key: usize,
    frames: std::ops::Range<usize>,
) -> Vec<bool> {
    let mut needed = vec![false; canvas.columns * canvas.rows];
    for frame in frames {
        let Some(map) = survey.path.between(key, frame) else { continue };
        for (cell, needed) in needed.iter_mut().enumerate().filter(|(_, needed)| !**needed) {
            let p = map * canvas.centre(cell);
            *needed = survey.cell_at(p.x / p.z, p.y / p.z).is_some_and(|at| survey.cells[frame].hole[at]);
        }
    }
    widened(&needed, canvas)
}

/// One cell more on every side: registration moves things a little.
fn widened(cells: &[bool], canvas: &Canvas) -> Vec<bool> {
    let at = |x: isize, y: isize| {
        x >= 0
            && y >= 0
            && (x as usize) < canvas.columns
            && (y as usize) < canvas.rows
            && cells[y as usize * canvas.columns + x as usize]
    };
    (0..cells.len())
        .map(|cell| {
            let (x, y) = ((cell % canvas.columns) as isize, (cell / canvas.columns) as isize);
            (-1..=1).any(|dy| (-1..=1).any(|dx| at(x + dx, y + dy)))
        })
        .collect()
}

/// Frames to read for the cells `needed` on the canvas of `key`, in order of use.
pub(super) fn choose_sources(
    survey: &Survey,
    canvas: &Canvas,
    key: usize,
    needed: &[bool],
    params: &InpaintParams,
) -> Vec<usize> {
    let wanted = params.samples.max(1);
    let mut samples: Vec<usize> = needed.iter().map(|n| if *n { 0 } else { usize::MAX }).collect();
    take(survey, canvas, key, key, &mut samples);
    let mut order: Vec<usize> = (0..survey.path.frame_count()).filter(|frame| *frame != key).collect();
    order.sort_by_key(|frame| (frame.abs_diff(key), *frame));
    let mut chosen: Vec<usize> = Vec::new();
    // First for the samples wanted, well apart in time; then for whatever nobody has seen yet.
    for (goal, gain_share, spread) in [(wanted, 0.04, 0.4), (1, 0.0, 0.0)] {
        for &frame in &order {
            if chosen.len() >= params.max_sources {
                return chosen;
            }
            let lacking = samples.iter().filter(|count| **count < goal).count();
            if lacking == 0 {
                break;
            }
            let apart = (spread * frame.abs_diff(key) as f64).max(2.0);
            if chosen.iter().any(|other| (other.abs_diff(frame) as f64) < apart) {
                continue;
            }
            let gain = gain(survey, canvas, key, frame, &samples, goal);
            if gain as f64 > (gain_share * lacking as f64).max(1.0) {
                take(survey, canvas, key, frame, &mut samples);
                chosen.push(frame);
            }
        }
    }
    chosen
}

/// Cells with fewer than `goal` samples that `frame` sees.
fn gain(survey: &Survey, canvas: &Canvas, key: usize, frame: usize, samples: &[usize], goal: usize) -> usize {
    let Some(map) = survey.path.between(key, frame) else { return 0 };
    let lacking = samples.iter().enumerate().filter(|(_, count)| **count < goal);
    lacking.filter(|(cell, _)| sees(survey, frame, &(map * canvas.centre(*cell)))).count()
}

fn take(survey: &Survey, canvas: &Canvas, key: usize, frame: usize, samples: &mut [usize]) {
    let Some(map) = survey.path.between(key, frame) else { return };
    for (cell, count) in samples.iter_mut().enumerate().filter(|(_, count)| **count != usize::MAX) {
        if sees(survey, frame, &(map * canvas.centre(cell))) {
            *count += 1;
        }
    }
}

fn sees(survey: &Survey, frame: usize, p: &Vector3<f64>) -> bool {
    survey.cell_at(p.x / p.z, p.y / p.z).is_some_and(|at| !survey.cells[frame].blocked[at])
}
