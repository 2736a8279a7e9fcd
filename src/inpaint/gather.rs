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

/// Cells of the canvas of `key` that any frame of `frames` draws its hole from, or the shadow beside it.
pub(super) fn needed_cells(
    survey: &Survey,
    canvas: &Canvas,
    key: usize,
    frames: std::ops::Range<usize>,
    params: &InpaintParams,
) -> Vec<bool> {
    let mut needed = vec![false; canvas.columns * canvas.rows];
    for frame in frames {
        let Some(map) = survey.path.between(key, frame) else { continue };
        for (cell, needed) in needed.iter_mut().enumerate().filter(|(_, needed)| !**needed) {
            let p = map * canvas.centre(cell);
            *needed = survey.cell_at(p.x / p.z, p.y / p.z).is_some_and(|at| survey.cells[frame].hole[at]);
        }
    }
    // One cell more on every side: registration moves things a little.
    let reach = (params.shadow_reach * survey.columns as f64).round() as usize;
    (0..reach.max(1)).fold(needed, |needed, _| widened(&needed, canvas))
}

/// One cell more on every side.
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

/// Frames to read for the cells `needed` on the canvas of `key`, nearest in time first.
///
/// They are picked one by one for what the cells still lack, well apart in time, because a shadow or a
/// moved thing stays where it is for a while, and from near views, because those register best.
pub(super) fn choose_sources(
    survey: &Survey,
    canvas: &Canvas,
    key: usize,
    needed: &[bool],
    params: &InpaintParams,
) -> Vec<usize> {
    let cells: Vec<usize> = (0..needed.len()).filter(|cell| needed[*cell]).collect();
    let mut samples = vec![0_u32; cells.len()];
    let mut candidates: Vec<Candidate> = candidate_frames(key, survey.path.frame_count())
        .into_iter()
        .filter_map(|frame| Candidate::new(survey, canvas, key, frame, &cells))
        .collect();
    let mut chosen = vec![key];
    while chosen.len() <= params.max_sources {
        let value = |candidate: &Candidate| candidate.value(&samples, &chosen);
        let best =
            (0..candidates.len()).max_by(|a, b| value(&candidates[*a]).total_cmp(&value(&candidates[*b])));
        let Some(best) = best.filter(|best| value(&candidates[*best]) > 0.5) else { break };
        let best = candidates.swap_remove(best);
        for (count, seen) in samples.iter_mut().zip(&best.sees) {
            *count += u32::from(*seen);
        }
        chosen.push(best.frame);
    }
    chosen.remove(0);
    chosen.sort_by_key(|frame| (frame.abs_diff(key), *frame));
    chosen
}

/// At most about a hundred frames of the clip, denser near `key`.
fn candidate_frames(key: usize, count: usize) -> Vec<usize> {
    let near = 24;
    let stride = (count / 64).max(1);
    (0..count).filter(|frame| *frame != key && (frame.abs_diff(key) <= near || frame % stride == 0)).collect()
}

/// A frame that a plate might read.
struct Candidate {
    frame: usize,
    /// Which of the needed cells it shows.
    sees: Vec<bool>,
    /// 1 for the key frame's own view, falling as the camera moves away.
    nearness: f64,
}

impl Candidate {
    fn new(survey: &Survey, canvas: &Canvas, key: usize, frame: usize, cells: &[usize]) -> Option<Self> {
        let map = survey.path.between(key, frame)?;
        let sees: Vec<bool> =
            cells.iter().map(|cell| sees(survey, frame, &(map * canvas.centre(*cell)))).collect();
        let moved = survey.displacement(key, frame)?;
        sees.iter().any(|seen| *seen).then(|| Self {
            frame,
            sees,
            nearness: 1.0 / (1.0 + (moved * 20.0).powi(2)),
        })
    }

    fn value(&self, samples: &[u32], chosen: &[usize]) -> f64 {
        let lacking = |count: u32| 1.0 / f64::from((1 + count) * (1 + count));
        let seen = self.sees.iter().zip(samples).filter(|(seen, _)| **seen);
        let gain: f64 = seen.map(|(_, count)| lacking(*count)).sum();
        let apart = chosen.iter().map(|other| other.abs_diff(self.frame)).min().unwrap_or(1);
        gain * self.nearness * (apart as f64).sqrt()
    }
}

fn sees(survey: &Survey, frame: usize, p: &Vector3<f64>) -> bool {
    survey.cell_at(p.x / p.z, p.y / p.z).is_some_and(|at| !survey.cells[frame].blocked[at])
}
