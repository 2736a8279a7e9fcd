//! Shapes of what changed: how far colours differ, what is only shadow, where two places touch.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Point, Vector},
    imgproc,
};

use super::timeline::Ends;
use crate::vision::{ColourModel, binary, box_blurred, log_odds};

/// How far two Lab colours are apart, lightness halved.
pub(super) fn distance(a: [u8; 3], b: [u8; 3]) -> f32 {
    let d = |c: usize| f32::from(a[c]) - f32::from(b[c]);
    (0.25 * d(0) * d(0) + d(1) * d(1) + d(2) * d(2)).sqrt()
}

/// How far first and last colours differ, whatever shift of a pixel either way; zero where unknown
/// or less than `least`.
pub(super) fn difference(ends: &Ends, columns: usize, least: f32) -> Vec<f32> {
    let rows = ends.first.len() / columns;
    let nearest = |colours: &[Option<[u8; 3]>], colour: [u8; 3], x: usize, y: usize| {
        let mut closest = f32::INFINITY;
        for y in y.saturating_sub(1)..(y + 2).min(rows) {
            for x in x.saturating_sub(1)..(x + 2).min(columns) {
                if let Some(other) = colours[y * columns + x] {
                    closest = closest.min(distance(colour, other));
                }
            }
        }
        closest
    };
    (0..ends.first.len())
        .map(|at| {
            let (Some(first), Some(last)) = (ends.first[at], ends.last[at]) else { return 0.0 };
            if distance(first, last) < least {
                return 0.0;
            }
            let (x, y) = (at % columns, at / columns);
            nearest(&ends.last, first, x, y).max(nearest(&ends.first, last, x, y))
        })
        .collect()
}

/// CV_8UC1: where `values` are at least `least`.
pub(super) fn threshold(values: &[f32], columns: usize, least: f32) -> opencv::Result<Mat> {
    let mut mask = binary::empty((values.len() / columns) as i32, columns as i32)?;
    for (inside, value) in mask.data_bytes_mut()?.iter_mut().zip(values) {
        *inside = if *value >= least { 255 } else { 0 };
    }
    Ok(mask)
}

/// A changed place whole, and, where what was taken away and what was put down touch each other, its part of the
/// wanted kind: there the other end shows the colours of the surroundings.
pub(super) fn divided(around: &Mat, ends: &Ends, taken: bool) -> opencv::Result<Vec<Mat>> {
    let area = binary::area(around)? as f64;
    let reach = (0.5 * area.sqrt()).round().clamp(4.0, 24.0) as i32;
    let (near, beyond) = (binary::dilated(around, 1)?, binary::dilated(around, reach)?);
    let ring = near.data_bytes()?.iter().zip(beyond.data_bytes()?).enumerate();
    let ring = ring.filter(|(_, (near, beyond))| **near == 0 && **beyond != 0);
    let ground = ring.filter_map(|(at, _)| ends.first[at]).map(|lab| (lab, 1.0));
    let Some(ground) = ColourModel::learn(ground) else { return Ok(vec![around.try_clone()?]) };
    let mut lean = around.try_clone()?;
    for (at, value) in lean.data_bytes_mut()?.iter_mut().enumerate().filter(|(_, value)| **value != 0) {
        let (Some(first), Some(last)) = (ends.first[at], ends.last[at]) else { continue };
        let (with, without) = if taken { (first, last) } else { (last, first) };
        let odds = log_odds(ground.likelihood(without), ground.likelihood(with));
        *value = (128.0 + 30.0 * odds.clamp(-4.0, 4.0)) as u8;
    }
    let inside = box_blurred(around, 5)?;
    let mean = box_blurred(&lean, 5)?;
    let mut part = around.try_clone()?;
    for (value, (mean, inside)) in
        part.data_bytes_mut()?.iter_mut().zip(mean.data_bytes()?.iter().zip(inside.data_bytes()?))
    {
        if u32::from(*mean) * 255 < 128 * u32::from(*inside) {
            *value = 0;
        }
    }
    let part = binary::opened(&part, 1)?;
    let (found, labels) = binary::components(&part)?;
    let Some(largest) = found.iter().max_by_key(|c| c.area) else { return Ok(vec![around.try_clone()?]) };
    let keep: Vec<bool> = (0..=found.len()).map(|label| label as i32 == largest.label).collect();
    let share = f64::from(largest.area) / area;
    let mut parts = vec![around.try_clone()?];
    if (0.15..0.85).contains(&share) {
        parts.push(binary::by_label(&part, &labels, &keep)?);
    }
    Ok(parts)
}

/// The object's part of what changed: a shadow darkens and keeps the hue. All of it when hardly anything
/// is more than a shadow.
pub(super) fn without_shadow(around: &Mat, ends: &Ends, taken: bool) -> opencv::Result<(Mat, f64)> {
    let mut solid = around.try_clone()?;
    for (at, inside) in solid.data_bytes_mut()?.iter_mut().enumerate().filter(|(_, inside)| **inside != 0) {
        if let (Some(first), Some(last)) = (ends.first[at], ends.last[at]) {
            let (with, without) = if taken { (first, last) } else { (last, first) };
            if shadowed(with, without) {
                *inside = 0;
            }
        }
    }
    let solid = binary::opened(&binary::closed(&solid, 1)?, 1)?;
    let (found, labels) = binary::components(&solid)?;
    let largest = found.iter().map(|c| c.area).max().unwrap_or(0);
    let keep: Vec<bool> = std::iter::once(false).chain(found.iter().map(|c| 5 * c.area >= largest)).collect();
    let solid = binary::by_label(&solid, &labels, &keep)?;
    let solid = binary::small_holes_filled(&solid, largest / 2)?;
    let share = binary::area(&solid)? as f64 / binary::area(around)?.max(1) as f64;
    Ok((if share >= 0.2 { solid } else { around.try_clone()? }, share))
}

/// Share of the convex hull of `mask` that it fills, 0 to 1.
pub(super) fn compactness(mask: &Mat) -> opencv::Result<f64> {
    let (mut points, mut hull) = (Vector::<Point>::new(), Vector::<Point>::new());
    opencv::core::find_non_zero(mask, &mut points)?;
    if points.len() < 3 {
        return Ok(0.0);
    }
    imgproc::convex_hull_def(&points, &mut hull)?;
    // The hull runs through the centres of pixels: half its length lies outside.
    let around = imgproc::contour_area_def(&hull)? + 0.5 * imgproc::arc_length(&hull, true)? + 1.0;
    Ok((points.len() as f64 / around).min(1.0))
}

/// Whether `with` is `without` in shade.
pub(super) fn shadowed(with: [u8; 3], without: [u8; 3]) -> bool {
    let ratio = f32::from(with[0]) / f32::from(without[0]).max(1.0);
    let chroma = |c: usize| f32::from(with[c]) - 128.0 - ratio * (f32::from(without[c]) - 128.0);
    (0.45..0.97).contains(&ratio) && chroma(1).hypot(chroma(2)) < 6.0
}
