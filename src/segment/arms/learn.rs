//! Learns the clip's colours: from skeletons first, then from the masks themselves.

use opencv::core::{Mat, MatTraitConst};
use rayon::prelude::*;

use super::{
    Clip,
    colour::ColourModel,
    cut::{cut_frame, sleeve_to_learn},
    plate::UNKNOWN,
    work_frame::WorkFrame,
};
use crate::{clip::FrameIndex, segment::SegmentError, vision::binary};

/// Frames with all hands seen that are enough to learn from.
const ENOUGH_WHOLE_FRAMES: usize = 10;

/// Frames to learn from: those with hands or human masks, evenly spread.
pub(super) fn training_frames(clip: &Clip<'_>) -> Vec<usize> {
    let usable: Vec<usize> =
        (0..clip.count()).filter(|i| !clip.hands[*i].is_empty() || clip.human_mask(*i).is_some()).collect();
    // A hand that the estimator missed would teach the background its sleeve.
    let whole: Vec<usize> =
        usable.iter().copied().filter(|i| clip.hands[*i].len() == clip.most_hands).collect();
    let usable = if whole.len() >= ENOUGH_WHOLE_FRAMES { whole } else { usable };
    let stride = usable.len().div_ceil(clip.params.training_frames.max(1)).max(1);
    let mut chosen: Vec<usize> = usable.iter().copied().skip(stride / 2).step_by(stride).collect();
    chosen.extend(clip.human.keys().map(|frame| frame.as_usize()));
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

fn merged(models: Vec<ColourModel>) -> ColourModel {
    models.iter().fold(ColourModel::default(), |mut sum, model| {
        sum.merge(model);
        sum
    })
}

/// Colours from eroded skeletons (or human masks) and from what lies far from any hand.
pub(super) fn first_model(clip: &Clip<'_>, chosen: &[usize]) -> Result<ColourModel, SegmentError> {
    let learn = |index: &usize| {
        clip.watch.check()?;
        let (frame, _) = WorkFrame::read(clip.frames, FrameIndex(*index as u32), &clip.scale)?;
        let mut model = ColourModel::default();
        if let Some(mask) = clip.human_mask(*index) {
            learn_from_mask(&mut model, &frame, &mask?, None, clip.palm_width)?;
            return Ok(model);
        }
        let (rows, cols) = (frame.grey.rows(), frame.grey.cols());
        let (mut core, mut near) = (binary::empty(rows, cols)?, binary::empty(rows, cols)?);
        for (hand, reach) in &clip.hands[*index] {
            hand.draw_core(&mut core, 0.12)?;
            hand.draw_hull(&mut near, 0.8)?;
            hand.draw_cone(&mut near, 80.0, *reach)?;
        }
        let core = binary::eroded(&core, 1)?;
        let far = binary::map2(&near, &near, |near, _| if near == 0 { 255 } else { 0 })?;
        model.learn(&frame, &core, &far)?;
        Ok(model)
    };
    let models = chosen.par_iter().map(learn).collect::<Result<Vec<_>, SegmentError>>()?;
    Ok(merged(models))
}

/// Colours from the masks that `table` gives: this is what brings forearm and sleeve in.
pub(super) fn next_model(
    clip: &Clip<'_>,
    chosen: &[usize],
    table: &[u8],
) -> Result<ColourModel, SegmentError> {
    let learn = |index: &usize| {
        clip.watch.check()?;
        let (frame, _) = WorkFrame::read(clip.frames, FrameIndex(*index as u32), &clip.scale)?;
        let change = clip.change(*index, &frame)?;
        let mask = match clip.human_mask(*index) {
            Some(mask) => mask?,
            None => {
                let posterior = frame.posterior(table)?;
                let evidence = clip.evidence(*index, &posterior, change.as_ref(), None);
                let mask = cut_frame(&frame, &evidence, clip.params)?;
                let sleeves = sleeve_to_learn(&evidence, &mask, clip.params)?;
                binary::map2(&mask, &sleeves, |a, b| a | b)?
            }
        };
        let mut model = ColourModel::default();
        learn_from_mask(&mut model, &frame, &mask, change.as_ref(), clip.palm_width)?;
        Ok(model)
    };
    let models = chosen.par_iter().map(learn).collect::<Result<Vec<_>, SegmentError>>()?;
    Ok(merged(models))
}

/// Inside the eroded mask is arm; outside the grown mask is background, unless it has changed:
/// a sleeve not yet found must not teach the background.
fn learn_from_mask(
    model: &mut ColourModel,
    frame: &WorkFrame,
    mask: &Mat,
    change: Option<&Mat>,
    palm_width: f64,
) -> opencv::Result<()> {
    let inside = binary::eroded(mask, 1)?;
    let near = binary::dilated(mask, (0.25 * palm_width).round().clamp(3.0, 12.0) as i32)?;
    let mut outside = binary::map2(&near, &near, |near, _| if near == 0 { 255 } else { 0 })?;
    if let Some(change) = change {
        outside = binary::map2(
            &outside,
            change,
            |outside, change| if change > 40 && change != UNKNOWN { 0 } else { outside },
        )?;
    }
    model.learn(frame, &inside, &outside)
}

/// The posterior table after all rounds; `None` when there is nothing to learn from.
pub(super) fn learned_table(clip: &mut Clip<'_>, chosen: &[usize]) -> Result<Option<Vec<u8>>, SegmentError> {
    let first = first_model(clip, chosen)?;
    if !first.is_usable() {
        return Ok(None);
    }
    let mut table = first.posterior_table();
    for round in 0..clip.params.training_rounds {
        let model = next_model(clip, chosen, &table)?;
        if model.is_usable() {
            table = model.posterior_table();
        }
        if round == 0 {
            clip.align(&table)?;
        }
    }
    Ok(Some(table))
}
