//! Shadows that never leave: an arm at rest darkens the same place on every frame.
//!
//! Where a shadow passes, samples with and without it tell how much it darkens. Ground that was only ever
//! seen near a hand may lie in such a shadow all the time. It does where it is darker, by just that factor,
//! than neighbouring ground of its hue that was seen without shadow; then it is brightened by the factor.
//! Patterns of the ground itself do not count: they go on across that border.

use opencv::{
    core::{
        CV_8UC1, CV_32F, CV_32FC1, CV_32FC3, CV_32S, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual,
        Scalar, Vec3b, Vec3f,
    },
    imgproc,
};

use super::plate::{Plate, SEEN, UNKNOWN};
use crate::vision::{EdgeWeights, Plane, View, box_blurred, tv_cut};

/// Side, as a share of the width, of the neighbourhood in which ground is compared.
const NEIGHBOURHOOD: f64 = 0.06;
/// How far from hand and object ground must be seen, as a share of the width, to be free of their shadows.
const FAR: f64 = 0.15;
/// Side, in work pixels, of the spot around a pixel that must be dark itself.
const SPOT: i32 = 5;
/// Least darkening worth looking for.
const LEAST: f32 = 1.15;

/// Where ground is free of shadow, at work size.
#[derive(Debug)]
pub(super) struct LitGround {
    /// CV_8UC1: 255 where some frame saw it far from any hand.
    pub far: Mat,
    /// CV_8UC1: share, to 255, of pixels seen with a shadow and without.
    pub both: Mat,
}

/// CV_8UC1: 255 where `view` shows ground far from everything that may cast a moving shadow.
pub(super) fn far_ground(view: &View) -> opencv::Result<Mat> {
    let (mut distance, mut far, mut out) = (Mat::default(), Mat::default(), Mat::default());
    if opencv::core::count_non_zero(&view.valid)? as usize == view.valid.total() {
        return view.valid.try_clone();
    }
    imgproc::distance_transform(&view.valid, &mut distance, imgproc::DIST_L2, imgproc::DIST_MASK_3, CV_32F)?;
    let limit = FAR * f64::from(view.valid.cols());
    imgproc::threshold(&distance, &mut far, limit, 255.0, imgproc::THRESH_BINARY)?;
    far.convert_to(&mut out, CV_8UC1, 1.0, 0.0)?;
    Ok(out)
}

/// Brightens lasting shadows on `plate` by `factor` or a power of it (lit colour over shadowed colour, for each channel).
/// Their edges, half in the light, become unknown.
pub(super) fn lift(plate: &mut Plate, ground: &LitGround, factor: [f32; 3]) -> opencv::Result<()> {
    let mean = factor.iter().sum::<f32>() / 3.0;
    if mean < LEAST {
        return Ok(());
    }
    let (columns, rows) = (plate.view.colour.cols() as usize, plate.view.colour.rows() as usize);
    let colours: Vec<[u8; 3]> = plate.view.colour.data_typed::<Vec3b>()?.iter().map(|c| c.0).collect();
    let valid = plate.view.valid.data_typed::<u8>()?;
    let (far, both) = (ground.far.data_typed::<u8>()?, ground.both.data_typed::<u8>()?);
    let lit: Vec<bool> = (0..colours.len()).map(|i| valid[i] != 0 && both[i] > 100).collect();
    let doubtful: Vec<bool> =
        (0..colours.len()).map(|i| valid[i] != 0 && far[i] == 0 && both[i] < 30).collect();
    let size = (NEIGHBOURHOOD * columns as f64).round() as i32 | 1;
    let (lit_mean, lit_share) = mean_around(&plate.view.colour, &lit, size)?;
    let (own_mean, own_share) = mean_around(&plate.view.colour, &doubtful, size)?;
    let (spot, _) = mean_around(&plate.view.colour, &doubtful, SPOT)?;
    let log = mean.ln();
    let mut depth = vec![f32::NAN; colours.len()];
    let mut cost = vec![0.0_f32; colours.len()];
    for i in (0..colours.len()).filter(|i| doubtful[*i]) {
        cost[i] = PRIOR;
        if lit_share[i] < 0.08 || own_share[i] < 0.08 {
            continue;
        }
        if same_hue(lit_mean[i], own_mean[i]) {
            let darker = |own: [f32; 3]| (luma(lit_mean[i]) / luma(own).max(1.0)).ln() / log;
            depth[i] = darker(spot[i]);
            let both = 0.5 * (darker(own_mean[i]) + depth[i].clamp(-1.0, 1.5));
            cost[i] = (0.5 - both).clamp(-0.5, 0.5);
        } else {
            cost[i] = 0.25;
        }
    }
    let edges = EdgeWeights::from_colours(&colours, columns, rows, 1.0);
    let mut inside = Plane::zeros(columns, rows);
    for (u, cost) in inside.data.iter_mut().zip(&cost) {
        *u = if *cost < 0.0 { 1.0 } else { 0.0 };
    }
    tv_cut(&mut inside, &cost, &edges, 120);
    let shadow = depths_of_pieces(&inside, &doubtful, &depth)?;
    brighten(plate, &shadow, factor)
}

/// Ground of which nothing is known counts as lit, a little.
const PRIOR: f32 = 0.01;

fn luma(c: [f32; 3]) -> f32 {
    0.25 * c[0] + 0.625 * c[1] + 0.125 * c[2]
}

/// Mean colour of those pixels around each pixel that are `inside`, and their share.
fn mean_around(picture: &Mat, inside: &[bool], size: i32) -> opencv::Result<(Vec<[f32; 3]>, Vec<f32>)> {
    let zero = Scalar::all(0.0);
    let mut share = Mat::new_rows_cols_with_default(picture.rows(), picture.cols(), CV_32FC1, zero)?;
    let mut colour = Mat::default();
    picture.convert_to(&mut colour, CV_32FC3, 1.0, 0.0)?;
    let pairs = share.data_typed_mut::<f32>()?.iter_mut().zip(colour.data_typed_mut::<Vec3f>()?);
    for ((share, colour), inside) in pairs.zip(inside) {
        if *inside {
            *share = 1.0;
        } else {
            *colour = Vec3f::default();
        }
    }
    let (share, colour) = (box_blurred(&share, size)?, box_blurred(&colour, size)?);
    let share = share.data_typed::<f32>()?.to_vec();
    let colour = colour.data_typed::<Vec3f>()?.iter().zip(&share);
    Ok((colour.map(|(colour, share)| colour.0.map(|value| value / share.max(1e-6))).collect(), share))
}

/// Whether two colours differ by little but a common factor.
fn same_hue(a: [f32; 3], b: [f32; 3]) -> bool {
    let (total_a, total_b) = (a.iter().sum::<f32>().max(1.0), b.iter().sum::<f32>().max(1.0));
    a.iter().zip(b).all(|(a, b)| (a / total_a - b / total_b).abs() < 0.025)
}

/// CV_32FC1 at work size: by which power of the measured factor each connected piece of `inside` is darker than
/// lit ground; 0 where there is no shadow, or none of a plausible depth.
fn depths_of_pieces(inside: &Plane, doubtful: &[bool], depth: &[f32]) -> opencv::Result<Mat> {
    let (columns, rows) = (inside.width as i32, inside.height as i32);
    let bytes = |of: &dyn Fn(usize) -> bool| -> opencv::Result<Mat> {
        let data: Vec<u8> = (0..doubtful.len()).map(|i| if of(i) { 255 } else { 0 }).collect();
        Mat::new_rows_cols_with_data(rows, columns, &data)?.try_clone()
    };
    let pieces = bytes(&|i| doubtful[i] && inside.data[i] > 0.5)?;
    let mut labels = Mat::default();
    let count = imgproc::connected_components(&pieces, &mut labels, 8, CV_32S)? as usize;
    let labels = labels.data_typed::<i32>()?;
    let mut areas = vec![(0_u32, 0_u32, 0.0_f32); count];
    for (label, depth) in labels.iter().zip(depth) {
        let (area, known, sum) = &mut areas[*label as usize];
        *area += 1;
        if depth.is_finite() {
            *known += 1;
            *sum += depth;
        }
    }
    let powers: Vec<f32> = areas
        .iter()
        .enumerate()
        .map(|(label, (area, known, sum))| {
            let mean = sum / (*known as f32).max(1.0);
            let sound = label > 0 && *area >= 24 && 20 * known >= *area && (0.5..4.0).contains(&mean);
            // The factor itself was measured on single pixels: it is the better guess for all but deep shadows.
            if !sound {
                0.0
            } else if mean < 1.4 {
                1.0
            } else {
                mean
            }
        })
        .collect();
    let data: Vec<f32> = labels.iter().map(|label| powers[*label as usize]).collect();
    Mat::new_rows_cols_with_data(rows, columns, &data)?.try_clone()
}

fn brighten(plate: &mut Plate, shadow: &Mat, factor: [f32; 3]) -> opencv::Result<()> {
    let size = plate.picture.size()?;
    let (mut binary, mut soft, mut mask, mut powers) =
        (Mat::default(), Mat::default(), Mat::default(), Mat::default());
    opencv::core::compare(shadow, &Scalar::all(0.0), &mut binary, opencv::core::CMP_GT)?;
    imgproc::resize(&binary, &mut soft, size, 0.0, 0.0, imgproc::INTER_LINEAR)?;
    imgproc::threshold(&soft, &mut mask, 127.0, 255.0, imgproc::THRESH_BINARY)?;
    imgproc::resize(shadow, &mut powers, size, 0.0, 0.0, imgproc::INTER_NEAREST)?;
    let powers = powers.data_typed::<f32>()?;
    let edge = (plate.picture.cols() / 200).max(2);
    let (outer, inner) = (super::hole::grown(&mask, edge)?, super::hole::grown(&mask, -edge)?);
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
            *value = (f32::from(*value) * factor.powf(powers[i])).round().min(255.0) as u8;
        }
    }
    Ok(())
}
