//! From work masks to finished full-size masks: temporal median, edges, sides, quality.

use std::sync::atomic::{AtomicUsize, Ordering};

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual},
    imgproc,
};
use rayon::prelude::*;

use super::{
    ArmTrack, Clip, WorkMasks, decode, dropout::side_part, encode, gaps, runs, work_frame::WorkFrame,
};
use crate::{
    clip::FrameIndex,
    geometry::{PerSide, Side},
    image::Rgb8,
    segment::{MaskAuthor, MaskFlag, MaskFrame, MaskTrack, RleMask, SegmentError},
    vision::{FlowQuality, binary, dense_flow, refine_edges},
};

/// A frame's finished masks.
struct Finished {
    frame: MaskFrame,
    sides: PerSide<RleMask>,
}

pub(super) fn finished(clip: &Clip<'_>, masks: Vec<WorkMasks>) -> Result<ArmTrack, SegmentError> {
    let unions = masks.iter().map(|masks| union(clip, masks)).collect::<Result<Vec<_>, SegmentError>>()?;
    let unions = gaps::closed(&unions)?;
    let areas: Vec<u64> = unions.iter().map(RleMask::area).collect();
    let done = AtomicUsize::new(clip.count());
    let finished = runs(clip.count())
        .into_par_iter()
        .map(|run| finish_run(clip, &masks, &unions, &areas, run, &done))
        .collect::<Result<Vec<_>, SegmentError>>()?;
    let mut sides: PerSide<Vec<RleMask>> = PerSide::default();
    let mut frames = Vec::with_capacity(finished.len());
    for one in finished.into_iter().flatten() {
        sides.left.push(one.sides.left);
        sides.right.push(one.sides.right);
        frames.push(one.frame);
    }
    let union = MaskTrack { size: clip.frames.size(), frames, backend: "classical".to_owned() };
    Ok(ArmTrack { union, sides })
}

/// All of a frame's work masks together.
fn union(clip: &Clip<'_>, masks: &WorkMasks) -> Result<RleMask, SegmentError> {
    let mut all = match &masks.own {
        Some(own) => decode(own)?,
        None => binary::empty(clip.scale.work.height as i32, clip.scale.work.width as i32)?,
    };
    for carried in [&masks.carried.left, &masks.carried.right].into_iter().flatten() {
        all = binary::map2(&all, &decode(carried)?, |a, b| a | b)?;
    }
    Ok(encode(&all)?)
}

/// A run of frames, each read once.
fn finish_run(
    clip: &Clip<'_>,
    masks: &[WorkMasks],
    unions: &[RleMask],
    areas: &[u64],
    run: std::ops::Range<usize>,
    done: &AtomicUsize,
) -> Result<Vec<Finished>, SegmentError> {
    let read = |index: usize| WorkFrame::read(clip.frames, FrameIndex(index as u32), &clip.scale);
    let mut before = run.start.checked_sub(1).map(read).transpose()?;
    let mut current = Some(read(run.start)?);
    let mut finished = Vec::with_capacity(run.len());
    for index in run {
        clip.watch.check()?;
        let after = if index + 1 < clip.count() { Some(read(index + 1)?) } else { None };
        let Some((frame, picture)) = current.take() else { break };
        let neighbours = [
            neighbour(&frame, before.as_ref().map(|(f, _)| f), unions, index.wrapping_sub(1))?,
            neighbour(&frame, after.as_ref().map(|(f, _)| f), unions, index + 1)?,
        ];
        finished.push(finish(clip, &masks[index], unions, areas, (index, &picture, neighbours))?);
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        clip.watch.advance(done, 2 * clip.count());
        before = Some((frame, picture));
        current = after;
    }
    Ok(finished)
}

/// A neighbour's mask carried onto `frame` along the flow; `None` beyond the clip's ends.
fn neighbour(
    frame: &WorkFrame,
    other: Option<&WorkFrame>,
    unions: &[RleMask],
    index: usize,
) -> Result<Option<Mat>, SegmentError> {
    let Some(other) = other else { return Ok(None) };
    let mask = decode(&unions[index])?;
    if binary::area(&mask)? == 0 {
        return Ok(Some(mask));
    }
    let flow = dense_flow(&frame.grey, &other.grey, FlowQuality::Fast)?;
    Ok(Some(flow.pull(&mask)?))
}

/// The median of the mask and its neighbours carried here, and its IoU with them.
fn steadied(own: &RleMask, neighbours: [Option<Mat>; 2]) -> Result<(Mat, f64), SegmentError> {
    let own = decode(own)?;
    let [Some(before), Some(after)] = neighbours else { return Ok((own, 1.0)) };
    let agreed = binary::map2(&before, &after, |a, b| if a > 127 && b > 127 { 255 } else { 0 })?;
    let either = binary::map2(&before, &after, |a, b| if a > 127 || b > 127 { 255 } else { 0 })?;
    let overlap = binary::iou(&own, &agreed)?.max(binary::iou(&own, &either)?);
    let kept = binary::map2(&own, &either, |a, b| a & b)?;
    Ok((binary::map2(&kept, &agreed, |a, b| a | b)?, overlap))
}

fn finish(
    clip: &Clip<'_>,
    masks: &WorkMasks,
    unions: &[RleMask],
    areas: &[u64],
    (index, picture, neighbours): (usize, &Rgb8, [Option<Mat>; 2]),
) -> Result<Finished, SegmentError> {
    let (steady, overlap) = steadied(&unions[index], neighbours)?;
    let work_sides = split(clip, masks, &steady, index)?;
    let human = clip.human.get(&FrameIndex(index as u32));
    let picture = picture.to_mat()?;
    let full = match human {
        Some(mask) => decode(mask)?,
        None => full_size(clip, &picture, &steady)?,
    };
    let sides = PerSide {
        left: full_side(clip, &full, &work_sides.left)?,
        right: full_side(clip, &full, &work_sides.right)?,
    };
    let frame = judged(clip, masks, &full, &steady, overlap, (areas, index))?;
    Ok(Finished { frame, sides })
}

/// Enlarged with edges that follow the full-size picture, only around the mask.
fn full_size(clip: &Clip<'_>, picture: &Mat, steady: &Mat) -> opencv::Result<Mat> {
    let (fx, _) = clip.scale.factors();
    let bounds = imgproc::bounding_rect(steady)?;
    let mut full = binary::empty(picture.rows(), picture.cols())?;
    if bounds.width == 0 {
        return Ok(full);
    }
    let large = clip.scale.enlarge(steady)?;
    let margin = (6.0 / fx).ceil() as i32;
    let scaled = |v: i32| (f64::from(v) / fx).floor() as i32;
    let roi = opencv::core::Rect::new(
        scaled(bounds.x) - margin,
        scaled(bounds.y) - margin,
        scaled(bounds.width) + 2 * margin,
        scaled(bounds.height) + 2 * margin,
    ) & opencv::core::Rect::new(0, 0, picture.cols(), picture.rows());
    let (crop, coarse) = (picture.roi(roi)?.try_clone()?, large.roi(roi)?.try_clone()?);
    let radius = (2.5 / fx).round().max(2.0) as i32;
    let soft = refine_edges(&crop, &coarse, radius, 1e-4)?;
    let sharp = binary::map2(&soft, &soft, |value, _| if value > 110 { 255 } else { 0 })?;
    let grown = binary::dilated(&sharp, clip.params.grow)?;
    let mut target = opencv::prelude::MatTrait::roi_mut(&mut full, roi)?;
    grown.copy_to(&mut target)?;
    drop(target);
    Ok(full)
}

/// The steady mask by side at work scale.
fn split(clip: &Clip<'_>, masks: &WorkMasks, steady: &Mat, index: usize) -> opencv::Result<PerSide<Mat>> {
    let part = |side: Side| -> opencv::Result<Mat> {
        let hands = &clip.sides[index];
        if hands[side].is_some() {
            return side_part(steady, hands, side);
        }
        match &masks.carried[side] {
            Some(carried) => binary::map2(&decode(carried)?, steady, |a, b| a & b),
            None => binary::empty(steady.rows(), steady.cols()),
        }
    };
    Ok(PerSide { left: part(Side::Left)?, right: part(Side::Right)? })
}

fn full_side(clip: &Clip<'_>, full: &Mat, side: &Mat) -> opencv::Result<RleMask> {
    let grown = binary::dilated(side, 2)?;
    let large = clip.scale.enlarge(&grown)?;
    encode(&binary::map2(full, &large, |full, side| if side > 127 { full } else { 0 })?)
}

fn judged(
    clip: &Clip<'_>,
    masks: &WorkMasks,
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
    let mut score = if masks.own.is_some() { 1.0 } else { 0.97_f64.powi(masks.distance as i32) };
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
    let author = if masks.own.is_some() { MaskAuthor::Seeded } else { MaskAuthor::Propagated };
    Ok(MaskFrame { mask, author, score, flags })
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
