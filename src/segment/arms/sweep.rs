//! Carries what is known of arms through time: where landmarks drop out, where a forearm is lost for a while, and
//! where a hand rests that no estimator ever saw.
//!
//! A sweep walks the clip once in one direction. Every pixel holds its support: for how many frames the place that
//! flowed here has been arm. Support outlasts frames that do not see the arm, as long as colour and change still
//! fit; what was arm by mistake for a frame or two has none.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual};

use super::{
    Clip, decode, encode,
    plate::UNKNOWN,
    scratch::{Layer, Towards},
};
use crate::{
    segment::{RleMask, SegmentError},
    vision::binary,
};

/// Support that a frame's own mask adds; a frame that merely looks alike takes one off again.
const GAIN: u8 = 10;
/// Support that a place must have to be arm without being seen as one: four frames' worth.
const LEAST_SUPPORT: u8 = 4 * GAIN;
/// Support at most: about seven seconds may be bridged.
const MOST_SUPPORT: u8 = 250;
/// P(arm) from which a place that flowed here is still arm.
const STILL_LIKELY: u8 = 90;
/// A place that an arm may have moved into.
const ENTERED: u8 = 255;
/// A place that looks like the background behind it.
const STILL: u8 = 1;
/// Lab distance from the background from which something else is there now.
const CHANGED: u8 = 20;
/// P(arm) from which an arm grows into what moves in beside it.
const SURELY: u8 = 200;

/// What a sweep says of one frame.
#[derive(Clone, Debug)]
pub(super) struct Swept {
    /// Arm as the frames walked through know it.
    pub carried: Option<RleMask>,
    /// Own pixels that have been arm for too short a time to be believed.
    pub young: RleMask,
}

/// The carried masks of all frames in one direction, and where a frame's own mask has no support.
pub(super) fn swept(
    clip: &Clip<'_>,
    own: &[Option<RleMask>],
    towards: Towards,
) -> Result<Vec<Swept>, SegmentError> {
    let order: Vec<usize> = match towards {
        Towards::Before => (0..clip.count()).collect(),
        Towards::After => (0..clip.count()).rev().collect(),
    };
    let (rows, cols) = (clip.scale.work.height as i32, clip.scale.work.width as i32);
    let mut support = binary::empty(rows, cols)?;
    let nothing = Swept { carried: None, young: RleMask::empty(clip.scale.work) };
    let mut out = vec![nothing; clip.count()];
    for (step, index) in order.into_iter().enumerate() {
        clip.watch.check()?;
        let arrived = if step == 0 || binary::area(&support)? == 0 {
            binary::empty(rows, cols)?
        } else {
            clip.scratch.pulled(index, towards, &support)?
        };
        let likely = clip.scratch.get(index, Layer::Likely)?;
        let mask = own[index].as_ref().map(decode).transpose()?;
        let grounds = grounds(clip, index, &likely)?;
        support = next_support(&arrived, [&likely, &grounds], mask.as_ref())?;
        let carried = supported(&arrived, &support, [&likely, &grounds], clip.palm_width)?;
        let carried = if binary::area(&carried)? == 0 { None } else { Some(encode(&carried)?) };
        let young = match &mask {
            Some(mask) => binary::map2(mask, &support, |mask, s| if s < LEAST_SUPPORT { mask } else { 0 })?,
            None => binary::empty(rows, cols)?,
        };
        out[index] = Swept { carried, young: encode(&young)? };
    }
    Ok(out)
}

/// Where an arm may have moved in ([`ENTERED`]): surely its colour, and not what was there before. Without the
/// second, whatever has the skin's colour beside an arm would grow onto it frame by frame. And where nothing has
/// changed ([`STILL`]).
fn grounds(clip: &Clip<'_>, index: usize, likely: &Mat) -> Result<Mat, SegmentError> {
    if clip.plate.is_none() {
        return Ok(binary::empty(likely.rows(), likely.cols())?);
    }
    let change = clip.scratch.get(index, Layer::Change)?;
    let ground = |p: u8, change: u8| match change {
        UNKNOWN => 0,
        change if change > CHANGED && p > SURELY => ENTERED,
        change if f64::from(change) < clip.params.still_threshold => STILL,
        _ => 0,
    };
    Ok(binary::map2(likely, &change, ground)?)
}

/// Support one frame later: it grows where the frame's own mask agrees, wanes slowly where the place still looks
/// like arm and fast elsewhere, and spreads to the sure arm beside it.
fn next_support(arrived: &Mat, [likely, grounds]: [&Mat; 2], own: Option<&Mat>) -> opencv::Result<Mat> {
    let beside = binary::dilated(arrived, 2)?;
    let mut support = binary::empty(arrived.rows(), arrived.cols())?;
    let (arrived, beside) = (arrived.data_bytes()?, beside.data_bytes()?);
    let (likely, grounds) = (likely.data_bytes()?, grounds.data_bytes()?);
    let own = own.map(MatTraitConstManual::data_bytes).transpose()?;
    for (position, value) in support.data_bytes_mut()?.iter_mut().enumerate() {
        let is_own = own.is_some_and(|own| own[position] != 0);
        *value = match likely[position] {
            _ if is_own => arrived[position].saturating_add(GAIN).min(MOST_SUPPORT),
            _ if grounds[position] == ENTERED => {
                arrived[position].saturating_sub(1).max(beside[position].saturating_sub(5))
            }
            p if p > STILL_LIKELY && grounds[position] == STILL => arrived[position].saturating_sub(8),
            p if p > SURELY => arrived[position].saturating_sub(1),
            p if p > 160 => arrived[position].saturating_sub(2),
            p if p > STILL_LIKELY => arrived[position].saturating_sub(8),
            _ => arrived[position].saturating_sub(15 + arrived[position] / 4),
        };
    }
    Ok(support)
}

/// Supported places as a mask: whole components that look like arm.
fn supported(
    arrived: &Mat,
    support: &Mat,
    [likely, grounds]: [&Mat; 2],
    palm_width: f64,
) -> opencv::Result<Mat> {
    // The frame's own mask must not prove itself: support counts from before it.
    let known =
        binary::map2(
            arrived,
            support,
            |a, s| if a >= LEAST_SUPPORT && s >= LEAST_SUPPORT { 255 } else { 0 },
        )?;
    let grown =
        binary::map2(
            support,
            grounds,
            |s, ground| if s >= LEAST_SUPPORT && ground == ENTERED { 255 } else { 0 },
        )?;
    let mask = binary::opened(&binary::map2(&known, &grown, |a, b| a | b)?, 1)?;
    let (found, labels) = binary::components(&mask)?;
    let mut sums = vec![0_u64; found.len() + 1];
    for (label, p) in labels.iter().zip(likely.data_bytes()?) {
        sums[*label as usize] += u64::from(*p);
    }
    let least = (0.1 * palm_width * palm_width).max(12.0) as i32;
    let keep: Vec<bool> = std::iter::once(false)
        .chain(found.iter().map(|c| c.area >= least && sums[c.label as usize] >= 130 * c.area as u64))
        .collect();
    binary::by_label(&mask, &labels, &keep)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(value: u8) -> Mat {
        let empty = binary::empty(20, 20).unwrap();
        binary::map2(&empty, &empty, |_, _| value).unwrap()
    }

    fn at_centre(support: &Mat) -> u8 {
        support.data_bytes().unwrap()[10 * 20 + 10]
    }

    #[test]
    fn support_outlasts_a_long_gap_where_the_colour_fits_and_no_gap_where_it_does_not() {
        let (own, likely, unlike, ground) = (filled(255), filled(230), filled(20), filled(0));
        let mut seen = filled(0);
        for _ in 0..25 {
            seen = next_support(&seen, [&likely, &ground], Some(&own)).unwrap();
        }
        let after = |frames: usize, likely: &Mat, ground: &Mat| {
            let mut support = seen.clone();
            for _ in 0..frames {
                support = next_support(&support, [likely, ground], None).unwrap();
            }
            at_centre(&support)
        };
        assert!(after(150, &likely, &ground) >= LEAST_SUPPORT);
        assert!(after(8, &unlike, &ground) < LEAST_SUPPORT);
        assert!(after(40, &likely, &filled(STILL)) < LEAST_SUPPORT, "what stands still was background");
    }

    #[test]
    fn a_mistake_of_two_frames_gets_no_support() {
        let (own, likely, ground) = (filled(255), filled(230), filled(0));
        let once = next_support(&filled(0), [&likely, &ground], Some(&own)).unwrap();
        let twice = next_support(&once, [&likely, &ground], Some(&own)).unwrap();
        assert!(at_centre(&twice) < LEAST_SUPPORT);
    }
}
