//! From a rough shape to the object's box on a frame where it is well visible.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual},
    imgproc,
};

use super::{SelectError, scene::to_lab};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::PixelBox,
    segment::MaskTrack,
    vision::{WorkScale, binary, grab_cut},
};

/// Longer side of the picture that the outline is cut on, pixels.
const FINE: u32 = 640;

/// What is known of an object's shape on a frame, work pixels of `scale`.
pub(super) struct Rough<'a> {
    /// CV_8UC1: surely mostly the object.
    pub shape: &'a Mat,
    /// CV_8UC1: how far it may reach, where the shape is only a part of it.
    pub around: Option<&'a Mat>,
    pub scale: &'a WorkScale,
}

/// The object's box on frame `index`, full-size pixels: GrabCut from the rough shape, the arm as background.
/// A cut that leaves the rough shape far behind is not believed. `None` where nothing is left.
pub(super) fn bounds(
    frames: &dyn FrameSource,
    arms: &MaskTrack,
    index: usize,
    rough: &Rough<'_>,
) -> Result<Option<PixelBox>, SelectError> {
    let full = frames.size();
    let fine = WorkScale::fit(full, FINE);
    let lab = to_lab(&fine.shrink(&frames.frame(FrameIndex(index as u32))?.to_mat()?)?)?;
    let arm = fine.shrink_mask(&arms.frames[index].mask.decode().to_mat()?)?;
    let enlarged = |mask: &Mat| -> opencv::Result<Mat> {
        let mut large = Mat::default();
        imgproc::resize(mask, &mut large, lab.size()?, 0.0, 0.0, imgproc::INTER_LINEAR)?;
        binary::map2(&large, &large, |v, _| if v > 127 { 255 } else { 0 })
    };
    let shape = enlarged(rough.shape)?;
    if binary::area(&shape)? < 8 {
        return Ok(None);
    }
    let zoom = f64::from(fine.work.width) / f64::from(rough.scale.work.width);
    let around = rough.around.map(&enlarged).transpose()?;
    let cut = cut(&lab, &shape, around.as_ref(), &arm, zoom)?;
    let rect = imgproc::bounding_rect(&cut)?;
    let (sx, sy) = fine.factors();
    let edges = [rect.x, rect.y, rect.x + rect.width, rect.y + rect.height].map(f64::from);
    let bounds = PixelBox { x0: edges[0] / sx, y0: edges[1] / sy, x1: edges[2] / sx, y1: edges[3] / sy };
    Ok(bounds.clipped(full))
}

fn cut(lab: &Mat, shape: &Mat, around: Option<&Mat>, arm: &Mat, zoom: f64) -> opencv::Result<Mat> {
    let size = (binary::area(shape)? as f64).sqrt();
    let core = binary::eroded(shape, (0.12 * size).round().clamp(1.0, 8.0) as i32)?;
    let reach = (0.08 * size + zoom).round().clamp(2.0, 10.0) as i32;
    let near = binary::dilated(shape, reach)?;
    let beyond = match around {
        Some(around) => binary::map2(&near, around, |a, b| a | b)?,
        None => near,
    };
    let mut seeds = binary::map2(shape, &beyond, |shape, beyond| match (shape != 0, beyond != 0) {
        (true, _) => grab_cut::SEED_PROBABLY_FOREGROUND,
        (false, true) => grab_cut::SEED_PROBABLY_BACKGROUND,
        _ => grab_cut::SEED_BACKGROUND,
    })?;
    let others = core.data_bytes()?.iter().zip(arm.data_bytes()?);
    for (seed, (core, arm)) in seeds.data_bytes_mut()?.iter_mut().zip(others) {
        if *arm != 0 {
            *seed = grab_cut::SEED_BACKGROUND;
        } else if *core != 0 {
            *seed = grab_cut::SEED_FOREGROUND;
        }
    }
    let margin = (0.5 * size).max(8.0) as i32;
    let cut = grab_cut::grab_cut(lab, &seeds, 3, margin)?;
    let cut = binary::touching(&binary::opened(&cut, 1)?, shape)?;
    let believed = if around.is_some() {
        let grown = binary::area(&cut)? as f64 / binary::area(shape)?.max(1) as f64;
        (0.5..4.0).contains(&grown)
    } else {
        binary::iou(&cut, shape)? > 0.5
    };
    if believed { Ok(cut) } else { shape.try_clone() }
}
