//! From work masks to finished full-size masks: temporal median, edges, sides, quality.

use std::sync::atomic::{AtomicUsize, Ordering};

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual},
    imgproc,
};
use rayon::prelude::*;

use super::{
    ArmTrack, Clip, WorkMask, decode,
    edges::EdgeLine,
    encode,
    scratch::Towards,
    shape::{HandShape, nearer},
};
use crate::{
    clip::FrameIndex,
    geometry::{PerSide, Side},
    segment::{MaskAuthor, MaskFlag, MaskFrame, MaskTrack, RleMask, SegmentError},
    vision::binary,
};

/// Frames over which a side that is not seen now is told by where its hand was.
const SIDE_MEMORY: usize = 45;

/// A frame's finished masks.
struct Finished {
    frame: MaskFrame,
    sides: PerSide<RleMask>,
}

pub(super) fn finished(clip: &Clip<'_>, masks: &[WorkMask]) -> Result<ArmTrack, SegmentError> {
    let areas: Vec<u64> = masks.iter().map(|mask| mask.mask.as_ref().map_or(0, RleMask::area)).collect();
    let done = AtomicUsize::new(2 * clip.count());
    let finished = (0..clip.count())
        .into_par_iter()
        .map(|index| {
            clip.watch.check()?;
            let finished = finish(clip, masks, &areas, index)?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            clip.watch.advance(done, 3 * clip.count());
            Ok(finished)
        })
        .collect::<Result<Vec<_>, SegmentError>>()?;
    let mut sides: PerSide<Vec<RleMask>> = PerSide::default();
    let mut frames = Vec::with_capacity(finished.len());
    for one in finished {
        sides.left.push(one.sides.left);
        sides.right.push(one.sides.right);
        frames.push(one.frame);
    }
    let union = MaskTrack { size: clip.frames.size(), frames, backend: "classical".to_owned() };
    Ok(ArmTrack { union, sides })
}

/// A neighbour's mask carried onto frame `index` along the flow; `None` beyond the clip's ends.
fn neighbour(
    clip: &Clip<'_>,
    masks: &[WorkMask],
    index: usize,
    towards: Towards,
) -> Result<Option<Mat>, SegmentError> {
    let other = match towards {
        Towards::Before => index.checked_sub(1),
        Towards::After => Some(index + 1).filter(|other| *other < masks.len()),
    };
    let Some(other) = other else { return Ok(None) };
    match &masks[other].mask {
        Some(mask) => Ok(Some(clip.scratch.pulled(index, towards, &decode(mask)?)?)),
        None => Ok(Some(binary::empty(clip.scale.work.height as i32, clip.scale.work.width as i32)?)),
    }
}

/// The median of the mask and its neighbours carried here, and its IoU with them.
fn steadied(own: Mat, neighbours: [Option<Mat>; 2]) -> Result<(Mat, f64), SegmentError> {
    let [Some(before), Some(after)] = neighbours else { return Ok((own, 1.0)) };
    let agreed = binary::map2(&before, &after, |a, b| if a > 127 && b > 127 { 255 } else { 0 })?;
    let either = binary::map2(&before, &after, |a, b| if a > 127 || b > 127 { 255 } else { 0 })?;
    let overlap = binary::iou(&own, &agreed)?.max(binary::iou(&own, &either)?);
    let kept = binary::map2(&own, &either, |a, b| a & b)?;
    Ok((binary::map2(&kept, &agreed, |a, b| a | b)?, overlap))
}

fn finish(
    clip: &Clip<'_>,
    masks: &[WorkMask],
    areas: &[u64],
    index: usize,
) -> Result<Finished, SegmentError> {
    let human = clip.human.get(&FrameIndex(index as u32));
    let nearby = index.saturating_sub(1)..(index + 2).min(masks.len());
    if human.is_none() && masks[nearby].iter().all(|mask| mask.mask.is_none()) {
        let empty = RleMask::empty(clip.frames.size());
        let flags = vec![MaskFlag::Lost];
        let frame = MaskFrame { mask: empty.clone(), author: MaskAuthor::Propagated, score: 0.0, flags };
        return Ok(Finished { frame, sides: PerSide { left: empty.clone(), right: empty } });
    }
    let neighbours =
        [neighbour(clip, masks, index, Towards::Before)?, neighbour(clip, masks, index, Towards::After)?];
    let own = match &masks[index].mask {
        Some(own) => decode(own)?,
        None => binary::empty(clip.scale.work.height as i32, clip.scale.work.width as i32)?,
    };
    let (steady, overlap) = steadied(own, neighbours)?;
    let full = match human {
        Some(mask) => decode(mask)?,
        None => full_size(clip, index, &steady)?,
    };
    let work_sides = split(clip, &steady, index)?;
    let sides = PerSide {
        left: full_side(clip, &full, &work_sides.left)?,
        right: full_side(clip, &full, &work_sides.right)?,
    };
    let frame = judged(clip, masks, &full, &steady, overlap, (areas, index))?;
    Ok(Finished { frame, sides })
}

/// Enlarged with edges that follow the full-size picture, only around the mask.
fn full_size(clip: &Clip<'_>, index: usize, steady: &Mat) -> Result<Mat, SegmentError> {
    let full = clip.frames.size();
    let mut out = binary::empty(full.height as i32, full.width as i32)?;
    let bounds = imgproc::bounding_rect(steady)?;
    if bounds.width == 0 {
        return Ok(out);
    }
    let picture = clip.frames.frame(FrameIndex(index as u32))?.to_mat()?;
    let line = EdgeLine::fitted(&clip.scratch.grey(index)?, steady)?;
    let (fx, fy) = clip.scale.factors();
    let margin = (6.0 / fx).ceil() as i32;
    let roi = opencv::core::Rect::new(
        (f64::from(bounds.x) / fx).floor() as i32 - margin,
        (f64::from(bounds.y) / fy).floor() as i32 - margin,
        (f64::from(bounds.width) / fx).floor() as i32 + 2 * margin,
        (f64::from(bounds.height) / fy).floor() as i32 + 2 * margin,
    ) & opencv::core::Rect::new(0, 0, picture.cols(), picture.rows());
    let mut grey = Mat::default();
    imgproc::cvt_color(&picture.roi(roi)?.try_clone()?, &mut grey, imgproc::COLOR_RGB2GRAY, 0)?;
    let sharp = line.drawn(&grey, (roi.x, roi.y), clip)?;
    let grown = binary::dilated(&sharp, clip.params.grow)?;
    let mut target = opencv::prelude::MatTrait::roi_mut(&mut out, roi)?;
    grown.copy_to(&mut target)?;
    drop(target);
    Ok(out)
}

/// A side's hand on frame `index`, or where it was last or will be next.
fn hand_around<'c>(clip: &'c Clip<'_>, index: usize, side: Side) -> Option<&'c HandShape> {
    let near = (0..=SIDE_MEMORY).flat_map(|d| [index.checked_sub(d), Some(index + d)]);
    near.flatten().find_map(|index| clip.sides.get(index)?[side].as_ref())
}

/// The steady mask by side at work scale: each pixel to the hand and forearm that it is nearer to.
fn split(clip: &Clip<'_>, steady: &Mat, index: usize) -> opencv::Result<PerSide<Mat>> {
    let (left, right) = (hand_around(clip, index, Side::Left), hand_around(clip, index, Side::Right));
    let nothing = || binary::empty(steady.rows(), steady.cols());
    Ok(match (left, right) {
        (Some(left), Some(right)) => {
            let (to_left, to_right) = (left.distances(steady)?, right.distances(steady)?);
            let left = nearer(steady, &to_left, &to_right)?;
            let right = binary::map2(steady, &left, |all, left| all & !left)?;
            PerSide { left, right }
        }
        (Some(_), None) => PerSide { left: steady.try_clone()?, right: nothing()? },
        (None, Some(_)) => PerSide { left: nothing()?, right: steady.try_clone()? },
        (None, None) => PerSide { left: nothing()?, right: nothing()? },
    })
}

fn full_side(clip: &Clip<'_>, full: &Mat, side: &Mat) -> opencv::Result<RleMask> {
    let grown = binary::dilated(side, 2)?;
    let large = clip.scale.enlarge(&grown)?;
    encode(&binary::map2(full, &large, |full, side| if side > 127 { full } else { 0 })?)
}

fn judged(
    clip: &Clip<'_>,
    masks: &[WorkMask],
    full: &Mat,
    steady: &Mat,
    overlap: f64,
    (areas, index): (&[u64], usize),
) -> Result<MaskFrame, SegmentError> {
    let mask = encode(full)?;
    if clip.human.contains_key(&FrameIndex(index as u32)) {
        return Ok(MaskFrame { mask, author: MaskAuthor::Human, score: 1.0, flags: Vec::new() });
    }
    let mut flags = Vec::new();
    let distance = (0..masks.len()).find(|distance| seen_at(masks, index, *distance));
    let mut score = 0.97_f64.powi(distance.unwrap_or(90) as i32);
    let before = index.checked_sub(1).map(|before| areas[before] as f64);
    if before.is_some_and(|before| before > 0.0 && !(0.6..=1.6).contains(&(areas[index] as f64 / before))) {
        flags.push(MaskFlag::AreaJump);
    }
    if overlap < 0.7 {
        flags.push(MaskFlag::LowOverlap);
    }
    let mut covered: f64 = 1.0;
    for (hand, _) in &clip.hands[index] {
        covered = covered.min(hand.core_covered(steady)?);
    }
    score *= overlap.clamp(0.3, 1.0) * covered.max(0.2);
    if touches_border(full)? {
        flags.push(MaskFlag::TouchesBorder);
    }
    if mask.is_empty() {
        flags.push(MaskFlag::Lost);
        score = 0.0;
    }
    let author = if masks[index].seen { MaskAuthor::Seeded } else { MaskAuthor::Propagated };
    Ok(MaskFrame { mask, author, score, flags })
}

fn seen_at(masks: &[WorkMask], index: usize, distance: usize) -> bool {
    let seen = |index: usize| masks.get(index).is_some_and(|mask| mask.seen);
    index.checked_sub(distance).is_some_and(seen) || seen(index + distance)
}

fn touches_border(mask: &Mat) -> opencv::Result<bool> {
    let (rows, cols) = (mask.rows() as usize, mask.cols() as usize);
    let bytes = mask.data_bytes()?;
    let at_border = |index: usize| {
        let (x, y) = (index % cols, index / cols);
        x == 0 || y == 0 || x + 1 == cols || y + 1 == rows
    };
    Ok(bytes.iter().enumerate().any(|(index, value)| *value != 0 && at_border(index)))
}
