//! Arm masks without a learned model: landmarks, the clip's own colours, change against the
//! background, GrabCut; self-trained per clip (hand, forearm, sleeve).

mod colour;
mod cut;
mod edges;
mod finish;
mod learn;
mod params;
mod plate;
mod recurrence;
mod scratch;
mod shade;
mod shape;
mod sleeve;
mod stray;
mod sweep;
mod texture;
mod unseen;
mod work_frame;

use std::{collections::BTreeMap, path::Path};

use opencv::{
    core::{Mat, MatTrait, MatTraitConst},
    imgproc,
};
use rayon::prelude::*;

use self::{
    cut::Evidence,
    learn::Learned,
    plate::Plate,
    scratch::{Layer, Scratch, Towards},
    shape::{FROM_BELOW, HandShape},
    sweep::Swept,
    work_frame::WorkFrame,
};
use super::{RleMask, SegmentError};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::{PerSide, PixelBox, Side},
    landmarks::{HandLandmarks, LandmarkTrack},
    progress::Watch,
    vision::{self, FlowQuality, WorkScale, binary, dense_flow},
};

pub use super::ArmTrack;
pub use params::ArmParams;

/// The object that is handled, where it is known beforehand: its colours are not the arm's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandledObject {
    /// The frame on which the box holds.
    pub frame: FrameIndex,
    /// A box around it, full-size pixels.
    pub bounds: PixelBox,
}

/// What arms are found from.
#[derive(Clone, Copy)]
pub struct ArmInputs<'a> {
    /// The clip.
    pub frames: &'a dyn FrameSource,
    /// Landmarks of both hands, full-size pixels.
    pub landmarks: &'a LandmarkTrack,
    /// Masks drawn by a person: taken as they are, they teach the colour models and anchor their neighbours.
    pub human: &'a BTreeMap<FrameIndex, RleMask>,
    /// The object that is handled, if it is known.
    pub object: Option<HandledObject>,
    /// A folder for a scratch file without a name (about half a megabyte a frame), gone afterwards.
    pub scratch: &'a Path,
}

impl std::fmt::Debug for ArmInputs<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let frames = (self.frames.frame_count(), self.frames.size());
        f.debug_struct("ArmInputs")
            .field("frames", &frames)
            .field("object", &self.object)
            .finish_non_exhaustive()
    }
}

/// Masks of both arms on every frame.
///
/// Without any landmark and any human mask, every frame is empty and flagged as lost.
///
/// # Errors
/// When an input does not fit the clip, a frame cannot be read, the scratch file or OpenCV fails, or `watch`
/// cancels.
pub fn track_arms(
    inputs: &ArmInputs<'_>,
    params: &ArmParams,
    watch: &dyn Watch,
) -> Result<ArmTrack, SegmentError> {
    vision::single_threaded();
    let mut clip = Clip::new(inputs, params, watch)?;
    let chosen = learn::training_frames(&clip);
    if chosen.is_empty() {
        return finish::finished(&clip, &vec![WorkMask::default(); clip.count()]);
    }
    clip.keep_frames()?;
    let masks = match learn::learned(&mut clip, &chosen)? {
        Some(learned) => all_masks(&clip, &learned)?,
        None => vec![WorkMask::default(); clip.count()],
    };
    finish::finished(&clip, &masks)
}

/// A frame's mask at work scale.
#[derive(Clone, Debug, Default)]
struct WorkMask {
    /// All of it; `None` where there is nothing.
    mask: Option<RleMask>,
    /// Whether the frame's own landmarks (or a person) speak for it.
    seen: bool,
}

fn all_masks(clip: &Clip<'_>, learned: &Learned) -> Result<Vec<WorkMask>, SegmentError> {
    let done = std::sync::atomic::AtomicUsize::new(0);
    let step = || {
        let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        clip.watch.advance(done, 3 * clip.count());
    };
    let own = (0..clip.count())
        .into_par_iter()
        .map(|index| {
            clip.watch.check()?;
            let mask = clip.own_mask(index, learned)?;
            step();
            Ok(mask)
        })
        .collect::<Result<Vec<_>, SegmentError>>()?;
    let (forward, backward) = rayon::join(
        || sweep::swept(clip, &own, Towards::Before),
        || sweep::swept(clip, &own, Towards::After),
    );
    let (forward, backward) = (forward?, backward?);
    (0..clip.count())
        .into_par_iter()
        .map(|index| {
            clip.watch.check()?;
            let masks =
                clip.joined(index, learned, own[index].as_ref(), [&forward[index], &backward[index]])?;
            step();
            Ok(masks)
        })
        .collect()
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
    /// Whether arms leave the picture, as in first-person views.
    leaves_picture: bool,
    plate: Option<Plate>,
    object: Option<HandledObject>,
    /// P(object | Lab cell) against skeletons, 0 to 255, once its colours are learned.
    object_table: Option<Vec<u8>>,
    scratch: Scratch,
}

impl<'a> Clip<'a> {
    fn new(
        inputs: &ArmInputs<'a>,
        params: &'a ArmParams,
        watch: &'a dyn Watch,
    ) -> Result<Self, SegmentError> {
        let ArmInputs { frames, landmarks, human, object, scratch } = *inputs;
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
        Ok(Self {
            frames,
            human,
            params,
            watch,
            scale,
            hands,
            sides,
            most_hands,
            palm_width: reach.palm_width,
            leaves_picture: !reach.outside_view,
            plate: None,
            object,
            object_table: None,
            scratch: Scratch::create(scratch, scale.work)?,
        })
    }

    fn count(&self) -> usize {
        self.frames.frame_count()
    }

    /// The human mask of a frame at work scale.
    fn human_mask(&self, index: usize) -> Option<opencv::Result<Mat>> {
        let mask = self.human.get(&FrameIndex(index as u32))?;
        Some(mask.decode().to_mat().and_then(|mask| self.scale.shrink_mask(&mask)))
    }

    /// Shrinks every frame once, and finds the flow to both neighbours.
    fn keep_frames(&self) -> Result<(), SegmentError> {
        let keep = |run: &std::ops::Range<usize>| {
            for index in run.clone() {
                self.watch.check()?;
                let frame = WorkFrame::read(self.frames, FrameIndex(index as u32), &self.scale)?;
                self.scratch.put_frame(index, &frame)?;
            }
            Ok(())
        };
        let parts = runs(self.count());
        parts.par_iter().map(keep).collect::<Result<(), SegmentError>>()?;
        let flow = |run: &std::ops::Range<usize>| {
            let first = run.start.saturating_sub(1);
            let mut before = self.scratch.grey(first)?;
            for index in first + 1..run.end {
                self.watch.check()?;
                let grey = self.scratch.grey(index)?;
                let back = dense_flow(&grey, &before, FlowQuality::Fast)?;
                self.scratch.put_flow(index, Towards::Before, &back)?;
                let forth = dense_flow(&before, &grey, FlowQuality::Fast)?;
                self.scratch.put_flow(index - 1, Towards::After, &forth)?;
                before = grey;
            }
            Ok(())
        };
        parts.par_iter().map(flow).collect()
    }

    fn evidence<'e>(
        &'e self,
        index: usize,
        [colour, likely, skin]: [&'e Mat; 3],
        change: Option<&'e Mat>,
        object: Option<&'e Mat>,
    ) -> Evidence<'e> {
        Evidence {
            hands: &self.hands[index],
            colour,
            likely,
            change,
            prior: None,
            object,
            skin,
            leaves_picture: self.leaves_picture,
            palm_width: self.palm_width,
        }
    }

    /// The mask that a frame's own landmarks and arms at its border give; `None` without any. Keeps the
    /// frame's likelihoods.
    fn own_mask(&self, index: usize, learned: &Learned) -> Result<Option<RleMask>, SegmentError> {
        let frame = self.scratch.frame(index)?;
        let change = self.kept_change(index)?;
        let colour = frame.posterior(&learned.tables.colour)?;
        let likely = learned.tables.likely(&colour, change.as_ref())?;
        self.scratch.put(index, Layer::Colour, &colour)?;
        self.scratch.put(index, Layer::Likely, &likely)?;
        if let Some(mask) = self.human_mask(index) {
            return Ok(Some(encode(&mask?)?));
        }
        let (object, skin) = (learned.object(&frame)?, frame.posterior(&learned.skin)?);
        let evidence = self.evidence(index, [&colour, &likely, &skin], change.as_ref(), object.as_ref());
        let mut mask = if self.hands[index].is_empty() {
            binary::empty(frame.grey.rows(), frame.grey.cols())?
        } else {
            cut::cut_frame(&frame, &evidence, self.params)?
        };
        if self.leaves_picture {
            let strays = stray::at_border(&likely, self.palm_width)?;
            mask = binary::map2(&mask, &strays, |a, b| a | b)?;
            let unseen = unseen::arms(&evidence, &mask, &unseen::moving(self, index)?)?;
            mask = binary::map2(&mask, &unseen, |a, b| a | b)?;
        }
        Ok(if binary::area(&mask)? == 0 { None } else { Some(encode(&mask)?) })
    }

    fn kept_change(&self, index: usize) -> Result<Option<Mat>, SegmentError> {
        self.plate.as_ref().map(|_| self.scratch.get(index, Layer::Change)).transpose()
    }

    /// A frame's own mask less what nobody confirms, with what its neighbours know, cut anew where that is much.
    fn joined(
        &self,
        index: usize,
        learned: &Learned,
        own: Option<&RleMask>,
        [forward, backward]: [&Swept; 2],
    ) -> Result<WorkMask, SegmentError> {
        if self.human.contains_key(&FrameIndex(index as u32)) {
            return Ok(WorkMask { mask: own.cloned(), seen: true });
        }
        let seen = !self.hands[index].is_empty();
        let (rows, cols) = (self.scale.work.height as i32, self.scale.work.width as i32);
        let own = own.map_or_else(|| binary::empty(rows, cols), decode)?;
        let young = binary::map2(&decode(&forward.young)?, &decode(&backward.young)?, |a, b| a & b)?;
        let young = binary::opened(&binary::map2(&young, &own, |a, b| a & b)?, 1)?;
        let believed = if 2 * binary::area(&young)? > binary::area(&own)? {
            own
        } else {
            binary::map2(&own, &young, |own, young| own & !young)?
        };
        let mut carried = binary::empty(rows, cols)?;
        for mask in [&forward.carried, &backward.carried].into_iter().flatten() {
            carried = binary::map2(&carried, &decode(mask)?, |a, b| a | b)?;
        }
        let all = binary::map2(&believed, &carried, |a, b| a | b)?;
        // Slivers along the outline are no news.
        let news = binary::map2(&all, &believed, |all, believed| all & !believed)?;
        let added = binary::area(&binary::opened(&news, 2)?)?;
        let least = (0.1 * self.palm_width * self.palm_width).max(12.0) as usize;
        let mask = if added < least { believed } else { self.cut_again(index, learned, &all)? };
        let mask = if self.leaves_picture { self.attached(index, &mask)? } else { mask };
        Ok(WorkMask { mask: if binary::area(&mask)? == 0 { None } else { Some(encode(&mask)?) }, seen })
    }

    /// The components of `mask` that belong to a hand of the frame or enter over the picture's border: in
    /// first-person views nothing else is an arm.
    fn attached(&self, index: usize, mask: &Mat) -> opencv::Result<Mat> {
        let (rows, cols) = (mask.rows(), mask.cols());
        let mut anchors = binary::empty(rows, cols)?;
        for (hand, _) in &self.hands[index] {
            hand.draw_core(&mut anchors, 0.2)?;
        }
        // Half of a line on the border lies outside; a few rows may be missing where the flow leads there.
        let thickness = 2 * (0.25 * self.palm_width).round().clamp(3.0, 12.0) as i32;
        let frame = opencv::core::Rect::new(0, 0, cols, rows);
        let white = opencv::core::Scalar::all(255.0);
        imgproc::rectangle(&mut anchors, frame, white, thickness, imgproc::LINE_8, 0)?;
        binary::touching(mask, &anchors)
    }

    /// The mask that a frame's landmarks and its neighbours' knowledge (`prior`) give together.
    fn cut_again(&self, index: usize, learned: &Learned, prior: &Mat) -> Result<Mat, SegmentError> {
        let frame = self.scratch.frame(index)?;
        let change = self.kept_change(index)?;
        let (colour, likely) =
            (self.scratch.get(index, Layer::Colour)?, self.scratch.get(index, Layer::Likely)?);
        let (object, skin) = (learned.object(&frame)?, frame.posterior(&learned.skin)?);
        let evidence = self.evidence(index, [&colour, &likely, &skin], change.as_ref(), object.as_ref());
        let cut = cut::cut_frame(&frame, &Evidence { prior: Some(prior), ..evidence }, self.params)?;
        let kept = binary::iou(&cut, prior)? > 0.5;
        Ok(if kept { cut } else { prior.try_clone()? })
    }

    /// A cheap guess at what is not background: [`plate::HIDDEN`] in hand hulls and on unseen arms,
    /// [`recurrence::SUSPECT`] on likely colours in reach of a hand, [`plate::DOUBTFUL`] wherever else an arm
    /// could be, 0 elsewhere.
    fn hidden(&self, index: usize, frame: &WorkFrame, table: &[u8]) -> opencv::Result<Mat> {
        let mut near = binary::empty(frame.grey.rows(), frame.grey.cols())?;
        let mut hulls = near.try_clone()?;
        if self.hands[index].len() < self.most_hands {
            // The estimator missed a hand: it may be anywhere.
            near.set_to(&opencv::core::Scalar::all(255.0), &opencv::core::no_array())?;
        }
        let mut expected = hulls.try_clone()?;
        for (hand, reach) in &self.hands[index] {
            hand.draw_cone(&mut near, 80.0, *reach)?;
            if self.leaves_picture {
                hand.draw_below(&mut near, FROM_BELOW, *reach)?;
            }
            hand.draw_cone(&mut expected, 40.0, *reach)?;
            hand.draw_hull(&mut hulls, 0.2)?;
        }
        let near =
            binary::map2(&near, &expected, |near, expected| if expected != 0 { 255 } else { near / 2 })?;
        // In `near`: 255 where a forearm is to be expected, less elsewhere in reach.
        let grade = |near: u8, posterior: u8| match near {
            255 if posterior > 127 => recurrence::SUSPECT,
            0 => 0,
            _ if posterior > HIDING => recurrence::SUSPECT,
            _ => plate::DOUBTFUL,
        };
        let likely = frame.posterior(table)?;
        let graded = binary::map2(&near, &likely, grade)?;
        let graded = if self.leaves_picture {
            // A hand that the estimator never sees must not become background.
            let strays = stray::at_border(&likely, self.palm_width)?;
            binary::map2(&graded, &strays, |grade, stray| if stray != 0 { plate::HIDDEN } else { grade })?
        } else {
            graded
        };
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
    outside_view: bool,
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
        let pixels = if outside_view { 1.6 * length } else { scale.work.diagonal() };
        Self { pixels, palm_width, outside_view }
    }
}

/// P(arm | colour) from which a place in reach of a hand cannot show the background. Lower, and a table of the
/// skin's colour would never be seen.
const HIDING: u8 = 190;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        clip::FramesInMemory,
        geometry::{Pixel, Size},
        image::{Mask, Rgb8},
        landmarks::KEYPOINT_COUNT,
        progress::Unwatched,
        segment::MaskFlag,
    };

    const SIZE: Size = Size { width: 200, height: 160 };
    const FRAMES: usize = 30;

    /// A bare arm that comes from the lower border; it sways.
    fn is_arm(frame: usize, x: f64, y: f64) -> bool {
        let left = 70.0 + 12.0 * (0.25 * frame as f64).sin();
        y > 50.0 && (left..left + 30.0).contains(&x)
    }

    /// A green block in front of the fingers.
    fn is_block(frame: usize, x: f64, y: f64) -> bool {
        let left = 76.0 + 12.0 * (0.25 * frame as f64).sin();
        (30.0..52.0).contains(&y) && (left..left + 18.0).contains(&x)
    }

    fn picture(frame: usize) -> Rgb8 {
        let mut bytes = Vec::with_capacity(3 * SIZE.area());
        for index in 0..SIZE.area() {
            let (x, y) = ((index % 200) as f64, (index / 200) as f64);
            let grain = (40.0 * ((0.9 * x).sin() * (0.7 * y).cos())) as i32;
            let colour = if is_block(frame, x, y) {
                [40, 170, 60]
            } else if is_arm(frame, x, y) {
                [205, 150, 125]
            } else {
                [90, 100, 140].map(|value| (value + grain).clamp(0, 255) as u8)
            };
            bytes.extend(colour);
        }
        Rgb8::from_data(SIZE, bytes).unwrap()
    }

    fn hand(frame: usize) -> HandLandmarks {
        let left = 70.0 + 12.0 * (0.25 * frame as f64).sin();
        let mut keypoints = [Pixel::new(left + 15.0, 70.0); KEYPOINT_COUNT];
        keypoints[0] = Pixel::new(left + 15.0, 95.0);
        for (finger, x) in [(1, 3.0), (5, 6.0), (9, 12.0), (13, 18.0), (17, 24.0)] {
            for joint in 0..4 {
                keypoints[finger + joint] = Pixel::new(left + x, 72.0 - 6.0 * joint as f64);
            }
        }
        HandLandmarks { keypoints, world: None, confidence: 0.9 }
    }

    fn tracked(seen: impl Fn(usize) -> bool) -> ArmTrack {
        let frames = FramesInMemory::new((0..FRAMES).map(picture).collect()).unwrap();
        let landmarks: LandmarkTrack =
            (0..FRAMES).map(|i| PerSide { left: None, right: seen(i).then(|| hand(i)) }).collect();
        let folder = tempfile::tempdir().unwrap();
        let human = BTreeMap::new();
        let inputs = ArmInputs {
            frames: &frames,
            landmarks: &landmarks,
            human: &human,
            object: None,
            scratch: folder.path(),
        };
        track_arms(&inputs, &ArmParams::default(), &Unwatched).unwrap()
    }

    fn shape(frame: usize, inside: impl Fn(usize, f64, f64) -> bool) -> Mask {
        Mask::from_fn(SIZE, |x, y| inside(frame, f64::from(x), f64::from(y)))
    }

    #[test]
    fn an_arm_is_kept_through_frames_without_landmarks_and_leaves_what_it_holds_alone() {
        let track = tracked(|frame| !(8..24).contains(&frame));
        for frame in [3, 12, 16, 20, 27] {
            let mask = track.union.frames[frame].mask.decode();
            let arm = shape(frame, |f, x, y| is_arm(f, x, y) && !is_block(f, x, y));
            assert!(mask.iou(&arm) > 0.85, "frame {frame}: {}", mask.iou(&arm));
            let block = shape(frame, is_block);
            let taken = mask.data().iter().zip(block.data()).filter(|(m, b)| **m != 0 && **b != 0).count();
            assert!(taken < block.area() / 3, "frame {frame}: {taken} of {} taken", block.area());
        }
    }

    #[test]
    fn without_any_landmark_every_mask_is_empty_and_lost() {
        let track = tracked(|_| false);
        assert!(track.union.frames.iter().all(|f| f.mask.is_empty() && f.flags.contains(&MaskFlag::Lost)));
    }
}
