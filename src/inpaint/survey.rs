//! A first look at the whole clip: how the camera moves, and roughly where the holes are.

use nalgebra::{Matrix3, Vector3};
use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, Size as CvSize},
    imgproc,
};
use rayon::prelude::*;

use super::{InpaintError, scene::Scene};
use crate::{
    progress::Watch,
    vision::{CameraPath, View},
};

/// Side of a cell in work pixels.
pub(super) const CELL: usize = 8;

/// Which cells of one frame are touched by the hole, and by anything that is not background.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    pub hole: Vec<bool>,
    pub blocked: Vec<bool>,
}

/// The survey's result: small numbers for every frame.
#[derive(Debug)]
pub(super) struct Survey {
    pub columns: usize,
    pub rows: usize,
    pub cells: Vec<Cells>,
    /// In work pixels.
    pub path: CameraPath,
}

impl Survey {
    /// Reads every frame once.
    pub fn new(scene: &Scene<'_>, watch: &dyn Watch) -> Result<Self, InpaintError> {
        let count = scene.frame_count();
        let work = scene.scale.work;
        let (columns, rows) = ((work.width as usize).div_ceil(CELL), (work.height as usize).div_ceil(CELL));
        let (mut cells, mut steps) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut previous: Option<View> = None;
        for start in (0..count).step_by(CHUNK) {
            watch.check()?;
            let end = (start + CHUNK).min(count);
            let looked: Vec<Result<_, InpaintError>> = (start..end)
                .into_par_iter()
                .map(|index| {
                    let glance = scene.glance(index)?;
                    let hole = touched(&glance.hole, columns, rows)?;
                    let blocked = touched(&glance.blocked, columns, rows)?;
                    Ok((Cells { hole, blocked }, glance.view))
                })
                .collect();
            let mut views: Vec<View> = previous.take().into_iter().collect();
            for look in looked {
                let (cell, view) = look?;
                cells.push(cell);
                views.push(view);
            }
            let motions: Vec<opencv::Result<Option<Matrix3<f64>>>> = (1..views.len())
                .into_par_iter()
                .map(|i| {
                    let motion = views[i - 1].motion_into(&views[i].gray, None)?;
                    Ok(motion.map(|motion| {
                        if is_still(&motion, &views[i].gray) { Matrix3::identity() } else { motion }
                    }))
                })
                .collect();
            for motion in motions {
                steps.push(motion?);
            }
            previous = views.pop();
        }
        // One lost step is taken as no motion: later registration decides what fits.
        bridge_single_breaks(&mut steps);
        Ok(Self { columns, rows, cells, path: CameraPath::from_steps(&steps) })
    }

    /// How far the camera carries the picture's corners between two frames, at most, as a share of the
    /// width; `None` across a break.
    pub fn displacement(&self, from: usize, to: usize) -> Option<f64> {
        let map = self.path.between(from, to)?;
        let (right, bottom) = ((self.columns * CELL) as f64, (self.rows * CELL) as f64);
        let corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)];
        let moved = |(x, y): (f64, f64)| {
            let q = map * Vector3::new(x, y, 1.0);
            (q.x / q.z - x).hypot(q.y / q.z - y)
        };
        Some(corners.into_iter().map(moved).fold(0.0, f64::max) / right)
    }

    /// The cell at work position (`x`, `y`); `None` outside the picture.
    pub fn cell_at(&self, x: f64, y: f64) -> Option<usize> {
        let (column, row) = ((x / CELL as f64).floor(), (y / CELL as f64).floor());
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then(|| row as usize * self.columns + column as usize)
    }
}

const CHUNK: usize = 16;

fn bridge_single_breaks(steps: &mut [Option<Matrix3<f64>>]) {
    for i in 0..steps.len() {
        let before = i == 0 || steps[i - 1].is_some();
        let after = steps.get(i + 1).is_none_or(Option::is_some);
        if steps[i].is_none() && before && after {
            steps[i] = Some(Matrix3::identity());
        }
    }
}

/// Whether the picture's corners stay within a quarter of a pixel.
fn is_still(motion: &Matrix3<f64>, picture: &Mat) -> bool {
    let (right, bottom) = (f64::from(picture.cols()), f64::from(picture.rows()));
    [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)].into_iter().all(|(x, y)| {
        let q = motion * Vector3::new(x, y, 1.0);
        (q.x / q.z - x).hypot(q.y / q.z - y) < 0.25
    })
}

/// Cells with any pixel of the mask.
fn touched(mask: &Mat, columns: usize, rows: usize) -> opencv::Result<Vec<bool>> {
    let mut coarse = Mat::default();
    let size = CvSize::new(columns as i32, rows as i32);
    imgproc::resize(mask, &mut coarse, size, 0.0, 0.0, imgproc::INTER_AREA)?;
    Ok(coarse.data_typed::<u8>()?.iter().map(|value| *value > 0).collect())
}
