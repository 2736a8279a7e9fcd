//! Arm masks without a learned model: landmarks, the clip's own colours, change against the
//! background, GrabCut; self-trained per clip (hand, forearm, sleeve).

mod carry;
mod colour;
mod cut;
mod dropout;
mod finish;
mod gaps;
mod learn;
mod params;
mod plate;
mod shape;
mod sleeve;
mod work_frame;

use std::collections::BTreeMap;

use opencv::core::{Mat, MatTrait, MatTraitConst};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::{cut::Evidence, plate::Plate, shape::HandShape, work_frame::WorkFrame};
use super::{MaskTrack, RleMask, SegmentError};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::{PerSide, Side},
    landmarks::{HandLandmarks, LandmarkTrack},
    progress::Watch,
    vision::{self, WorkScale, binary},
};

pub use params::ArmParams;

/// Everything of the human that must vanish, on every frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmTrack {
    /// Both arms: hand, forearm, sleeve.
    pub union: MaskTrack,
    /// The union split by side, one a frame; pixels that no known hand claims are in neither.
    pub sides: PerSide<Vec<RleMask>>,
}

/// Masks of both arms on every frame, from hand landmarks (full-size pixels).
///
/// `human` masks are taken as they are, teach the colour models and anchor their neighbours.
/// Without any landmark and any human mask, every frame is empty and flagged as lost.
///
/// # Errors
/// When an input does not fit the clip, a frame cannot be read, OpenCV fails or `watch` cancels.
pub fn track_arms(
    frames: &dyn FrameSource,
    landmarks: &LandmarkTrack,
    human: &BTreeMap<FrameIndex, RleMask>,
    params: &ArmParams,
    watch: &dyn Watch,
) -> Result<ArmTrack, SegmentError> {
    vision::single_threaded();
    let mut clip = Clip::new(frames, landmarks, human, params, watch)?;
    let chosen = learn::training_frames(&clip);
    let masks = match learn::learned_table(&mut clip, &chosen)? {
        Some(table) => all_masks(&clip, &table)?,
        None => (0..clip.count()).map(|_| WorkMasks::default()).collect(),
    };
    finish::finished(&clip, masks)
}

/// What a frame's masks are at work scale.
#[derive(Clone, Debug, Default)]
struct WorkMasks {
    /// Cut on this frame from its own landmarks.
    own: Option<RleMask>,
    /// Carried here from other frames, by side.
    carried: PerSide<Option<RleMask>>,
    /// How far the carried masks have come, frames.
    distance: usize,
}

fn all_masks(clip: &Clip<'_>, table: &[u8]) -> Result<Vec<WorkMasks>, SegmentError> {
    let done = std::sync::atomic::AtomicUsize::new(0);
    let own = (0..clip.count())
        .into_par_iter()
        .map(|index| {
            clip.watch.check()?;
            let mask = clip.own_mask(index, table)?;
            let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
            clip.watch.advance(done, 2 * clip.count());
            Ok(mask)
        })
        .collect::<Result<Vec<_>, SegmentError>>()?;
    dropout::bridged(clip, table, own)
}

/// One clip with all that stays fixed while its masks are made.
struct Clip<'a> {
    frames: &'a dyn FrameSource,
    human: &'a BTreeMap<FrameIndex, RleMask>,
    params: &'a ArmParams,
    watch: &'a dyn Watch,
    scale: WorkScale,
    /// Hands of each frame with how far their forearms may reach, work pixels.
    hands: Vec<Vec<(HandShape, f64)>>,
    sides: Vec<PerSide<Option<HandShape>>>,
    /// Hands seen at once, at most.
    most_hands: usize,
    palm_width: f64,
    plate: Option<Plate>,
}

impl<'a> Clip<'a> {
    fn new(
        frames: &'a dyn FrameSource,
        landmarks: &LandmarkTrack,
        human: &'a BTreeMap<FrameIndex, RleMask>,
        params: &'a ArmParams,
        watch: &'a dyn Watch,
    ) -> Result<Self, SegmentError> {
        let (count, size) = (frames.frame_count(), frames.size());
        let mismatch = |what, found, found_size| SegmentError::Mismatch {
            what,
            found,
            found_size,
            expected: count,
            expected_size: size,
        };
        if landmarks.len() != count {
            return Err(mismatch("the landmark track", landmarks.len(), size));
        }
        if let Some(mask) = human.values().find(|mask| mask.size() != size) {
            return Err(mismatch("a human arm mask", human.len(), mask.size()));
        }
        let scale = WorkScale::fit(size, params.work_size);
        let sides: Vec<PerSide<Option<HandShape>>> =
            landmarks.iter().map(|frame| distinct_hands(frame, &scale)).collect();
        let reach = Reach::of(&sides, &scale);
        let hands: Vec<Vec<(HandShape, f64)>> = sides
            .iter()
            .map(|frame| {
                frame.iter().filter_map(|(_, hand)| hand.clone()).map(|h| (h, reach.pixels)).collect()
            })
            .collect();
        let most_hands = hands.iter().map(Vec::len).max().unwrap_or(0);
        let palm_width = reach.palm_width;
        let plate = None;
        Ok(Self { frames, human, params, watch, scale, hands, sides, most_hands, palm_width, plate })
    }

    fn count(&self) -> usize {
        self.frames.frame_count()
    }

    /// The human mask of a frame at work scale.
    fn human_mask(&self, index: usize) -> Option<opencv::Result<Mat>> {
        let mask = self.human.get(&FrameIndex(index as u32))?;
        Some(mask.decode().to_mat().and_then(|mask| self.scale.shrink_mask(&mask)))
    }

    fn change(&self, index: usize, frame: &WorkFrame) -> opencv::Result<Option<Mat>> {
        self.plate.as_ref().map(|plate| plate.change(index, frame)).transpose()
    }

    fn evidence<'e>(
        &'e self,
        index: usize,
        posterior: &'e Mat,
        change: Option<&'e Mat>,
        prior: Option<&'e Mat>,
    ) -> Evidence<'e> {
        Evidence { hands: &self.hands[index], posterior, change, prior, palm_width: self.palm_width }
    }

    /// The mask that a frame's own landmarks give; `None` without any.
    fn own_mask(&self, index: usize, table: &[u8]) -> Result<Option<RleMask>, SegmentError> {
        if let Some(mask) = self.human_mask(index) {
            return Ok(Some(encode(&mask?)?));
        }
        if self.hands[index].is_empty() {
            return Ok(None);
        }
        let (frame, _) = WorkFrame::read(self.frames, FrameIndex(index as u32), &self.scale)?;
        let change = self.change(index, &frame)?;
        let posterior = frame.posterior(table)?;
        let evidence = self.evidence(index, &posterior, change.as_ref(), None);
        Ok(Some(encode(&cut::cut_frame(&frame, &evidence, self.params)?)?))
    }

    /// Aligns the background now that `table` tells roughly where arms are.
    fn align(&mut self, table: &[u8]) -> Result<(), SegmentError> {
        self.plate = Some(Plate::build(self, table)?);
        Ok(())
    }

    /// A cheap guess at what is not background: [`plate::HIDDEN`] in hand hulls and on likely colours
    /// in reach of a hand, [`plate::DOUBTFUL`] wherever else an arm could be, 0 elsewhere.
    fn hidden(&self, index: usize, frame: &WorkFrame, table: &[u8]) -> opencv::Result<Mat> {
        let mut near = binary::empty(frame.grey.rows(), frame.grey.cols())?;
        let mut hulls = near.try_clone()?;
        if self.hands[index].len() < self.most_hands {
            // The estimator missed a hand: it may be anywhere.
            near.set_to(&opencv::core::Scalar::all(255.0), &opencv::core::no_array())?;
        }
        for (hand, reach) in &self.hands[index] {
            hand.draw_cone(&mut near, 80.0, *reach)?;
            hand.draw_hull(&mut hulls, 0.2)?;
        }
        let grade = |near: u8, posterior: u8| match (near != 0, posterior > 127) {
            (true, true) => plate::HIDDEN,
            (true, false) => plate::DOUBTFUL,
            _ => 0,
        };
        let graded = binary::map2(&near, &frame.posterior(table)?, grade)?;
        binary::map2(&hulls, &graded, |hull, grade| if hull != 0 { plate::HIDDEN } else { grade })
    }
}

/// The hands of a frame; of one hand found twice, the surer.
fn distinct_hands(frame: &PerSide<Option<HandLandmarks>>, scale: &WorkScale) -> PerSide<Option<HandShape>> {
    let mut hands = PerSide::from_fn(|side| HandShape::new(frame[side].as_ref()?, scale));
    if let (Some(left), Some(right)) = (&hands.left, &hands.right)
        && left.is_same_as(right)
    {
        let confidence = |side: Side| frame[side].as_ref().map_or(0.0, |hand| hand.confidence);
        let doubtful =
            if confidence(Side::Left) < confidence(Side::Right) { Side::Left } else { Side::Right };
        hands[doubtful] = None;
    }
    hands
}

/// How far forearms may reach from the wrist, over the whole clip.
struct Reach {
    pixels: f64,
    palm_width: f64,
}

impl Reach {
    /// First-person arms leave the picture: no limit. Where the border lies farther than a forearm
    /// can reach, the person is seen from outside and only the forearm is wanted: about 1.6 hand lengths.
    fn of(sides: &[PerSide<Option<HandShape>>], scale: &WorkScale) -> Self {
        let all: Vec<&HandShape> =
            sides.iter().flat_map(|frame| Side::BOTH.iter().filter_map(|s| frame[*s].as_ref())).collect();
        let (width, height) = (f64::from(scale.work.width), f64::from(scale.work.height));
        let median = |mut values: Vec<f64>, share: f64| {
            values.sort_unstable_by(f64::total_cmp);
            values.get((share * values.len() as f64) as usize).copied()
        };
        let palm_width = median(all.iter().map(|h| h.palm_width).collect(), 0.5).unwrap_or(0.1 * width);
        let length = median(all.iter().map(|h| h.length).collect(), 0.8).unwrap_or(0.2 * width);
        let border = median(all.iter().map(|h| h.distance_to_border(width, height)).collect(), 0.5);
        let outside_view = border.is_some_and(|border| border > 4.0 * length);
        Self { pixels: if outside_view { 1.6 * length } else { scale.work.diagonal() }, palm_width }
    }
}

/// Runs of consecutive frames that one thread walks through, reading each frame once.
fn runs(count: usize) -> Vec<std::ops::Range<usize>> {
    (0..count).step_by(RUN).map(|start| start..(start + RUN).min(count)).collect()
}

/// Frames a run: results do not depend on it, memory and balance do.
const RUN: usize = 16;

fn encode(mask: &Mat) -> opencv::Result<RleMask> {
    Ok(RleMask::encode(&crate::image::Mask::from_mat(mask)?))
}

fn decode(mask: &RleMask) -> opencv::Result<Mat> {
    mask.decode().to_mat()
}
