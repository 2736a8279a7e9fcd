//! Shadows that never leave: an arm at rest darkens the same place on every frame.
//!
//! Where a shadow passes, samples with and without it tell how much it darkens. What lies beside
//! unseen ground, has the hue of its surroundings and is darker by just that factor is in the same
//! kind of shadow, and is brightened by the factor.

use opencv::{
    core::{CV_8UC1, CV_32S, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Vec3b},
    imgproc,
};

use super::plate::{Plate, SEEN, UNKNOWN};
use crate::vision::{EdgeWeights, Plane, tv_cut};

/// Side of a cell in work pixels.
const CELL: usize = 8;
/// Cells around a cell that tell how bright lit ground of its hue is.
const REACH: usize = 8;
/// Least darkening worth looking for.
const LEAST: f32 = 1.15;

/// Brightens lasting shadows on `plate` by `factor` (lit colour over shadowed colour, for each channel).
/// Their edges, half in the light, become unknown.
pub(super) fn lift(plate: &mut Plate, factor: [f32; 3]) -> opencv::Result<()> {
    let mean = factor.iter().sum::<f32>() / 3.0;
    if mean < LEAST {
        return Ok(());
    }
    let (columns, rows) = (plate.view.colour.cols() as usize, plate.view.colour.rows() as usize);
    let colours: Vec<[u8; 3]> = plate.view.colour.data_typed::<Vec3b>()?.iter().map(|c| c.0).collect();
    let valid: Vec<bool> = plate.view.valid.data_typed::<u8>()?.iter().map(|v| *v != 0).collect();
    let reference = lit_luma(&colours, &valid, columns, rows);
    let log = mean.ln();
    let mut depth = vec![0.0_f32; colours.len()];
    let mut cost = vec![0.0_f32; colours.len()];
    for (i, colour) in colours.iter().enumerate().filter(|(i, _)| valid[*i]) {
        let cell = (i / columns / CELL) * columns.div_ceil(CELL) + i % columns / CELL;
        if reference[cell] > 0.0 {
            depth[i] = (reference[cell] / luma(*colour).max(1.0)).ln() / log;
            cost[i] = (0.5 - depth[i].min(1.5)).clamp(-0.5, 0.5);
        } else {
            cost[i] = 0.5;
        }
    }
    let edges = EdgeWeights::from_colours(&colours, columns, rows, 1.0);
    let mut inside = Plane::zeros(columns, rows);
    for (u, cost) in inside.data.iter_mut().zip(&cost) {
        *u = if *cost < 0.0 { 1.0 } else { 0.0 };
    }
    tv_cut(&mut inside, &cost, &edges, 80);
    let shadow = beside_unseen(&inside, &valid, &depth)?;
    brighten(plate, &shadow, factor)
}

fn luma(c: [u8; 3]) -> f32 {
    0.25 * f32::from(c[0]) + 0.625 * f32::from(c[1]) + 0.125 * f32::from(c[2])
}

/// For each cell how bright lit ground of its hue is around it; 0 where nothing is known.
fn lit_luma(colours: &[[u8; 3]], valid: &[bool], columns: usize, rows: usize) -> Vec<f32> {
    let (wide, high) = (columns.div_ceil(CELL), rows.div_ceil(CELL));
    let mut sums = vec![([0.0_f32; 3], 0.0_f32); wide * high];
    for (i, colour) in colours.iter().enumerate().filter(|(i, _)| valid[*i]) {
        let (sum, count) = &mut sums[(i / columns / CELL) * wide + i % columns / CELL];
        for (sum, value) in sum.iter_mut().zip(colour) {
            *sum += f32::from(*value);
        }
        *count += 1.0;
    }
    let means: Vec<Option<[f32; 3]>> = sums
        .iter()
        .map(|(sum, count)| (*count >= (CELL * CELL / 4) as f32).then(|| sum.map(|sum| sum / count)))
        .collect();
    (0..wide * high)
        .map(|cell| {
            let Some(own) = means[cell] else { return 0.0 };
            let (x, y) = (cell % wide, cell / wide);
            let mut alike = Vec::new();
            for v in y.saturating_sub(REACH)..(y + REACH + 1).min(high) {
                for u in x.saturating_sub(REACH)..(x + REACH + 1).min(wide) {
                    if let Some(other) = means[v * wide + u].filter(|other| same_hue(own, *other)) {
                        alike.push(0.25 * other[0] + 0.625 * other[1] + 0.125 * other[2]);
                    }
                }
            }
            alike.sort_by(f32::total_cmp);
            alike.get(alike.len() * 7 / 10).copied().unwrap_or(0.0)
        })
        .collect()
}

/// Whether two colours differ by little but a common factor.
fn same_hue(a: [f32; 3], b: [f32; 3]) -> bool {
    let (total_a, total_b) = (a.iter().sum::<f32>().max(1.0), b.iter().sum::<f32>().max(1.0));
    a.iter().zip(b).all(|(a, b)| (a / total_a - b / total_b).abs() < 0.025)
}

/// CV_8UC1 at work size: 255 in those connected pieces of `inside` that touch unseen ground and are about
/// as dark as a shadow is.
fn beside_unseen(inside: &Plane, valid: &[bool], depth: &[f32]) -> opencv::Result<Mat> {
    let (columns, rows) = (inside.width as i32, inside.height as i32);
    let bytes = |of: &dyn Fn(usize) -> bool| -> opencv::Result<Mat> {
        let data: Vec<u8> = (0..valid.len()).map(|i| if of(i) { 255 } else { 0 }).collect();
        Mat::new_rows_cols_with_data(rows, columns, &data)?.try_clone()
    };
    let pieces = bytes(&|i| valid[i] && inside.data[i] > 0.5)?;
    let unseen = super::hole::grown(&bytes(&|i| !valid[i])?, 3)?;
    let unseen = unseen.data_typed::<u8>()?;
    let mut labels = Mat::default();
    let count = imgproc::connected_components(&pieces, &mut labels, 8, CV_32S)? as usize;
    let labels = labels.data_typed::<i32>()?;
    let mut areas = vec![(0_u32, 0_u32, 0.0_f32); count];
    for (i, label) in labels.iter().enumerate() {
        let (area, touching, sum) = &mut areas[*label as usize];
        *area += 1;
        *touching += u32::from(unseen[i] != 0);
        *sum += depth[i];
    }
    let keep: Vec<bool> = areas
        .iter()
        .enumerate()
        .map(|(label, (area, touching, sum))| {
            let mean = sum / (*area as f32).max(1.0);
            label > 0 && *area >= 24 && 40 * *touching >= *area && (0.6..1.6).contains(&mean)
        })
        .collect();
    bytes(&|i| keep[labels[i] as usize])
}

fn brighten(plate: &mut Plate, shadow: &Mat, factor: [f32; 3]) -> opencv::Result<()> {
    let mut wide = Mat::default();
    let size = plate.picture.size()?;
    debug_assert_eq!(shadow.typ(), CV_8UC1);
    imgproc::resize(shadow, &mut wide, size, 0.0, 0.0, imgproc::INTER_LINEAR)?;
    let edge = (plate.picture.cols() / 200).max(2);
    let (outer, inner) =
        (super::hole::grown(&wide_mask(&wide)?, edge)?, super::hole::grown(&wide_mask(&wide)?, -edge)?);
    let (outer, inner) = (outer.data_typed::<u8>()?, inner.data_typed::<u8>()?);
    let (picture, origin) = (plate.picture.data_typed_mut::<Vec3b>()?, plate.origin.data_typed_mut::<u8>()?);
    for (i, (outer, inner)) in outer.iter().zip(inner).enumerate() {
        if *outer == 0 || origin[i] != SEEN {
            continue;
        }
        if *inner == 0 {
            origin[i] = UNKNOWN;
            continue;
        }
        for (value, factor) in picture[i].0.iter_mut().zip(factor) {
            *value = (f32::from(*value) * factor).round().min(255.0) as u8;
        }
    }
    Ok(())
}

fn wide_mask(soft: &Mat) -> opencv::Result<Mat> {
    let mut binary = Mat::default();
    imgproc::threshold(soft, &mut binary, 127.0, 255.0, imgproc::THRESH_BINARY)?;
    Ok(binary)
}
