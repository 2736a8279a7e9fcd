//! Learns the clip's colours: from skeletons first, then from the masks themselves.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual};
use rayon::prelude::*;

use super::{
    Clip, HandledObject,
    colour::{ColourModel, Tables},
    cut::{SURELY_BACKGROUND, cut_frame, grip, has_changed, sleeve_to_learn},
    plate::UNKNOWN,
    scratch::Layer,
    shape::FROM_BELOW,
    unseen,
    work_frame::WorkFrame,
};
use crate::{
    geometry::Pixel,
    segment::SegmentError,
    vision::{LabHistogram, binary},
};

/// Frames with all hands seen that are enough to learn the background from.
const ENOUGH_WHOLE_FRAMES: usize = 6;
/// Object pixels that are enough to know its colours.
const ENOUGH_OBJECT_PIXELS: f64 = 25.0;
/// P(object | colour) from which a pixel under a skeleton is the object's.
pub(super) const OBJECT: u8 = 150;

/// What is known of the clip's colours.
#[derive(Clone, Debug)]
pub(super) struct Learned {
    /// From the last round.
    pub tables: Tables,
    /// P(arm | colour) from skeletons alone.
    pub skin: Vec<u8>,
}

impl Learned {
    /// Pixels of `frame` that have the handled object's colours, if it is known.
    pub fn object(&self, frame: &WorkFrame) -> opencv::Result<Option<Mat>> {
        let Some(table) = &self.tables.object else { return Ok(None) };
        let seen = frame.posterior(table)?;
        binary::map2(&seen, &seen, |p, _| if p > OBJECT { 255 } else { 0 }).map(Some)
    }
}

/// Frames to learn from: half of them with all hands seen, half with any hand or human mask, evenly spread.
pub(super) fn training_frames(clip: &Clip<'_>) -> Vec<usize> {
    let usable: Vec<usize> =
        (0..clip.count()).filter(|i| !clip.hands[*i].is_empty() || clip.human_mask(*i).is_some()).collect();
    let whole: Vec<usize> =
        usable.iter().copied().filter(|i| clip.hands[*i].len() == clip.most_hands).collect();
    let half = clip.params.training_frames.div_ceil(2).max(1);
    let spread = |from: &[usize]| -> Vec<usize> {
        let stride = from.len().div_ceil(half).max(1);
        from.iter().copied().skip(stride / 2).step_by(stride).collect()
    };
    let mut chosen = spread(&whole);
    chosen.extend(spread(&usable));
    chosen.extend(clip.human.keys().map(|frame| frame.as_usize()));
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// Those of the `chosen` frames that may teach the background: a hand that the estimator missed would teach
/// it skin and sleeve.
fn whole_frames(clip: &Clip<'_>, chosen: &[usize]) -> Vec<bool> {
    let whole: Vec<bool> = chosen
        .iter()
        .map(|i| clip.hands[*i].len() == clip.most_hands || clip.human_mask(*i).is_some())
        .collect();
    let enough = whole.iter().filter(|whole| **whole).count() >= ENOUGH_WHOLE_FRAMES;
    if enough { whole } else { vec![true; chosen.len()] }
}

fn merged(models: Vec<ColourModel>) -> ColourModel {
    models.iter().fold(ColourModel::default(), |mut sum, model| {
        sum.merge(model);
        sum
    })
}

/// The colours of the object in its box that its surroundings do not have; hands are left out.
fn object_colours(clip: &Clip<'_>, object: &HandledObject) -> Result<Option<LabHistogram>, SegmentError> {
    let index = object.frame.as_usize();
    if index >= clip.count() {
        return Ok(None);
    }
    let frame = clip.scratch.frame(index)?;
    let mut hands = binary::empty(frame.grey.rows(), frame.grey.cols())?;
    for (hand, reach) in &clip.hands[index] {
        hand.draw_hull(&mut hands, 0.2)?;
        hand.draw_cone(&mut hands, 40.0, *reach)?;
    }
    let b = object.bounds;
    let corner = |x: f64, y: f64| clip.scale.to_work(Pixel::new(x, y));
    let (low, high) = (corner(b.x0, b.y0), corner(b.x1, b.y1));
    let (centre_x, centre_y) = (f64::midpoint(low.x, high.x), f64::midpoint(low.y, high.y));
    let (half_x, half_y) = ((0.5 * (high.x - low.x)).max(1.0), (0.5 * (high.y - low.y)).max(1.0));
    let (mut inside, mut ring) = (LabHistogram::default(), LabHistogram::default());
    let cols = frame.grey.cols() as usize;
    let relative = |position: usize| {
        let dx = ((position % cols) as f64 - centre_x).abs() / half_x;
        dx.max(((position / cols) as f64 - centre_y).abs() / half_y)
    };
    let pixels = frame.pixels()?;
    let free: Vec<usize> =
        (0..pixels.len()).zip(hands.data_bytes()?).filter(|(_, hand)| **hand == 0).map(|(i, _)| i).collect();
    for position in &free {
        match relative(*position) {
            r if r < 1.0 => inside.add(pixels[*position]),
            r if r < 1.8 => ring.add(pixels[*position]),
            _ => {}
        }
    }
    let own = inside.smoothed(1).posterior_table(&ring.smoothed(1));
    let mut colours = LabHistogram::default();
    for position in free {
        if relative(position) < 1.0 && LabHistogram::look_up(&own, pixels[position]) > 150 {
            colours.add(pixels[position]);
        }
    }
    Ok((colours.total() >= ENOUGH_OBJECT_PIXELS).then_some(colours))
}

/// Colours from eroded skeletons (or human masks) and from what lies far from any hand.
fn first_model(clip: &Clip<'_>, chosen: &[usize]) -> Result<ColourModel, SegmentError> {
    let learn = |(index, whole): (&usize, bool)| {
        clip.watch.check()?;
        let frame = clip.scratch.frame(*index)?;
        let mut model = ColourModel::default();
        if let Some(mask) = clip.human_mask(*index) {
            learn_from_mask(clip, (*index, whole), &mut model, &frame, &mask?, None)?;
            return Ok(model);
        }
        let (rows, cols) = (frame.grey.rows(), frame.grey.cols());
        let (mut core, mut near) = (binary::empty(rows, cols)?, binary::empty(rows, cols)?);
        for (hand, reach) in &clip.hands[*index] {
            hand.draw_core(&mut core, 0.12)?;
            hand.draw_hull(&mut near, 0.8)?;
            hand.draw_cone(&mut near, 80.0, *reach)?;
            if clip.leaves_picture {
                hand.draw_below(&mut near, FROM_BELOW, *reach)?;
            }
        }
        let core = binary::eroded(&core, 1)?;
        let far = binary::map2(&near, &near, |near, _| if near == 0 { 255 } else { 0 })?;
        let far = if whole { far } else { binary::empty(rows, cols)? };
        model.learn(&frame, &core, &far, &clip.shadows())?;
        Ok(model)
    };
    let models = chosen
        .par_iter()
        .zip(whole_frames(clip, chosen))
        .map(learn)
        .collect::<Result<Vec<_>, SegmentError>>()?;
    Ok(merged(models))
}

/// Colours from the masks that were `learned` so far: this is what brings forearm and sleeve in.
fn next_model(clip: &Clip<'_>, chosen: &[usize], learned: &Learned) -> Result<ColourModel, SegmentError> {
    let learn = |(index, whole): (&usize, bool)| {
        clip.watch.check()?;
        let frame = clip.scratch.frame(*index)?;
        let change = if clip.plate.is_some() { Some(clip.scratch.get(*index, Layer::Change)?) } else { None };
        let skin = frame.posterior(&learned.skin)?;
        let colour = frame.posterior(&learned.tables.colour)?;
        let mut sleeves = binary::empty(frame.grey.rows(), frame.grey.cols())?;
        let mut unseen = sleeves.try_clone()?;
        let mut mask = match clip.human_mask(*index) {
            Some(mask) => mask?,
            None => {
                let likely = learned.tables.likely(&colour, change.as_ref())?;
                let object = learned.object(&frame)?;
                let evidence =
                    clip.evidence(*index, [&colour, &likely, &skin], change.as_ref(), object.as_ref());
                let mask = cut_frame(&frame, &evidence, clip.params)?;
                sleeves = sleeve_to_learn(&evidence, &mask, clip.params)?;
                if clip.leaves_picture {
                    unseen = unseen::arms(&evidence, &mask, &unseen::moving(clip, *index)?)?;
                }
                mask
            }
        };
        let mut model = ColourModel::default();
        if let Some(change) = change.as_ref().filter(|_| whole) {
            model.learn_change(change, &binary::map2(&mask, &unseen, |a, b| a | b)?)?;
        }
        if !clip.human.contains_key(&crate::clip::FrameIndex(*index as u32)) {
            if let Some(object) = learned.object(&frame)? {
                mask = binary::map2(&mask, &object, |mask, object| mask & !object)?;
            }
            let known = binary::map2(&skin, &colour, |skin, colour| skin.max(colour / 2))?;
            leave_out_known(&mut mask, &grip(&clip.hands[*index], &skin)?, [&skin, &known], change.as_ref())?;
        }
        // What is surely background is no sleeve either.
        let changes = change.as_ref().map(MatTraitConstManual::data_bytes).transpose()?;
        for (position, (sleeve, skin)) in
            sleeves.data_bytes_mut()?.iter_mut().zip(skin.data_bytes()?).enumerate()
        {
            let change = changes.map_or(UNKNOWN, |changes| changes[position]);
            if *skin <= SURELY_BACKGROUND && !has_changed(change) {
                *sleeve = 0;
            }
        }
        mask = binary::map2(&mask, &sleeves, |a, b| a | b)?;
        mask = binary::map2(&mask, &unseen, |a, b| a | b)?;
        learn_from_mask(clip, (*index, whole), &mut model, &frame, &mask, change.as_ref())?;
        Ok(model)
    };
    let models = chosen
        .par_iter()
        .zip(whole_frames(clip, chosen))
        .map(learn)
        .collect::<Result<Vec<_>, SegmentError>>()?;
    Ok(merged(models))
}

/// Takes out of `mask` what must not teach arm colours: in a grip, what skeletons do not have, for it is held; and
/// elsewhere what the far background has, unless it has surely changed. `skin` is P(arm | colour) by skeletons and
/// far background alone, `known` also grants what sleeves have taught since.
fn leave_out_known(
    mask: &mut Mat,
    grip: &Mat,
    [skin, known]: [&Mat; 2],
    change: Option<&Mat>,
) -> opencv::Result<()> {
    let changes = change.map(MatTraitConstManual::data_bytes).transpose()?;
    let (grip, skin, known) = (grip.data_bytes()?, skin.data_bytes()?, known.data_bytes()?);
    for (position, mask) in mask.data_bytes_mut()?.iter_mut().enumerate() {
        let change = changes.map_or(UNKNOWN, |changes| changes[position]);
        if (grip[position] != 0 && skin[position] < 90) || (known[position] < 45 && !has_changed(change)) {
            *mask = 0;
        }
    }
    Ok(())
}

/// Inside the eroded mask is arm. Outside the grown mask is background, unless it has changed, hides a background
/// that no frame shows, or lies where a forearm must be and is not known to be unchanged: a sleeve not yet found
/// must not teach the background.
fn learn_from_mask(
    clip: &Clip<'_>,
    (index, whole): (usize, bool),
    model: &mut ColourModel,
    frame: &WorkFrame,
    mask: &Mat,
    change: Option<&Mat>,
) -> opencv::Result<()> {
    let inside = binary::eroded(mask, 1)?;
    if !whole {
        return model.learn(frame, &inside, &binary::empty(mask.rows(), mask.cols())?, &clip.shadows());
    }
    let near = binary::dilated(mask, (0.25 * clip.palm_width).round().clamp(3.0, 12.0) as i32)?;
    let mut behind = binary::empty(mask.rows(), mask.cols())?;
    for (hand, reach) in clip.hands[index].iter().filter(|_| clip.leaves_picture) {
        hand.draw_cone(&mut behind, 45.0, *reach)?;
    }
    let mut outside = binary::map2(&near, &behind, |near, behind| match (near, behind) {
        (0, 0) => 255,
        (0, _) => 128,
        _ => 0,
    })?;
    let changes = change.map(MatTraitConstManual::data_bytes).transpose()?;
    for (position, outside) in outside.data_bytes_mut()?.iter_mut().enumerate() {
        let change = changes.map_or(UNKNOWN, |changes| changes[position]);
        let was_never_seen = changes.is_some() && change == UNKNOWN;
        if has_changed(change)
            || was_never_seen
            || (*outside == 128 && f64::from(change) >= clip.params.still_threshold)
        {
            *outside = 0;
        }
    }
    model.learn(frame, &inside, &outside, &clip.shadows())
}

/// The tables after all rounds; `None` when there is nothing to learn from.
pub(super) fn learned(clip: &mut Clip<'_>, chosen: &[usize]) -> Result<Option<Learned>, SegmentError> {
    let object = match &clip.object {
        Some(object) => object_colours(clip, object)?,
        None => None,
    };
    let mut first = first_model(clip, chosen)?;
    if !first.is_usable() {
        return Ok(None);
    }
    let tables = first.tables(object.as_ref());
    clip.object_table.clone_from(&tables.object);
    let mut learned = Learned { skin: first.tables(None).colour, tables };
    for round in 0..clip.params.training_rounds {
        let mut model = next_model(clip, chosen, &learned)?;
        // What lies far from any hand stays background, whatever the masks took in since.
        model.background.merge(&first.background);
        if model.is_usable() {
            learned.tables = model.tables(object.as_ref());
        }
        if round == 0 {
            clip.align(&learned.tables.colour, chosen)?;
            // The clip's shadows are known now: what is darker is no background.
            first = first_model(clip, chosen)?;
        }
    }
    // Sleeves are known by now: they are no background.
    clip.hide_again(&learned.tables.colour)?;
    Ok(Some(learned))
}
