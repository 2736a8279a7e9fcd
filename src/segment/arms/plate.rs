//! How much a frame differs from the background behind it, moving head included.

use nalgebra::Matrix3;
use opencv::{
    core::{CV_8UC3, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar},
    imgproc,
};
use rayon::prelude::*;

use super::{
    Clip,
    learn::OBJECT,
    recurrence::{SUSPECT, Sample, recurring},
    runs,
    scratch::Layer,
    shade::{ProvenShadows, Shade, Shadows},
    texture::{Likeness, Texture},
    work_frame::WorkFrame,
};
use crate::{
    geometry::{PerSide, Pixel},
    segment::SegmentError,
    vision::{BackgroundMotion, LabHistogram, background_motion_from, binary},
};

/// Samples that one plate is the median of.
const SAMPLES: usize = 9;
/// In a sample: an arm is there.
pub(super) const HIDDEN: u8 = 255;
/// In a sample: an arm could be there, so the sample cannot prove that a pixel is background.
pub(super) const DOUBTFUL: u8 = 128;
/// The smallest change reported where only doubtful samples exist: evidence for neither side.
pub(super) const NEUTRAL: u8 = 15;
/// The change where the background was never seen.
pub(super) const UNKNOWN: u8 = 255;
/// The change reported for the background in shadow: none.
pub(super) const SHADOW: u8 = 0;
/// Features from which the motion from frame to frame is found, at most.
const FEATURES: i32 = 250;
/// Key frames over the whole clip.
const KEYFRAMES: usize = 40;

/// Frames that share one plate: drawn once where the middle one sees it, then moved along.
const PLATE_RUN: usize = 8;

/// Frames at work scale spread over the clip, with the homography of every frame to the first.
pub(super) struct Plate {
    /// From each frame to the first of its unbroken run, and the run's number.
    placed: Vec<(usize, Matrix3<f64>)>,
    keyframes: Vec<Keyframe>,
    /// What is known of the clip's shadows.
    shadows: Shadows,
}

struct Keyframe {
    index: usize,
    lab: Mat,
    /// [`HIDDEN`], [`SUSPECT`], [`DOUBTFUL`] or 0.
    hidden: Mat,
    /// Where its hands are; `None` when one may have been missed.
    wrists: Option<PerSide<Option<Pixel>>>,
}

/// The background as one frame sees it.
struct Drawn {
    index: usize,
    lab: Mat,
    /// 0 where known for certain, [`DOUBTFUL`] or [`HIDDEN`] (unknown) elsewhere.
    doubt: Mat,
}

impl Plate {
    /// Aligns the clip at work scale; `table` is the colour model so far.
    pub fn build(clip: &Clip<'_>, table: &[u8]) -> Result<Self, SegmentError> {
        let stride = clip.count().div_ceil(KEYFRAMES).max(1);
        let parts = runs(clip.count())
            .into_par_iter()
            .map(|run| align_run(clip, table, run, stride))
            .collect::<Result<Vec<_>, SegmentError>>()?;
        let mut placed: Vec<(usize, Matrix3<f64>)> = Vec::with_capacity(clip.count());
        let mut keyframes = Vec::new();
        for part in parts {
            for step in part.steps {
                placed.push(match (placed.last(), step) {
                    (Some((run, to_first)), Some(motion)) => (*run, to_first * motion.homography),
                    (Some((run, _)), None) => (run + 1, Matrix3::identity()),
                    (None, _) => (0, Matrix3::identity()),
                });
            }
            keyframes.extend(part.keyframes);
        }
        Ok(Self { placed, keyframes, shadows: Shadows::default() })
    }

    /// The background's motion from one frame to another of the same unbroken run.
    pub fn between(&self, from: usize, to: usize) -> Option<Matrix3<f64>> {
        let ((run, from), (other_run, to)) = (self.placed.get(from)?, self.placed.get(to)?);
        if run != other_run {
            return None;
        }
        Some(to.try_inverse()? * from)
    }

    /// Decides anew where arms are in the key frames.
    pub fn hide_again(&mut self, clip: &Clip<'_>, table: &[u8]) -> Result<(), SegmentError> {
        self.keyframes.par_iter_mut().try_for_each(|key| {
            clip.watch.check()?;
            key.hidden = hidden(clip, key.index, &clip.scratch.frame(key.index)?, table)?;
            Ok(())
        })
    }

    /// What is known of the clip's shadows.
    pub fn shadows(&self) -> Shadows {
        self.shadows
    }

    /// Learns what the clip's shadows look like; whether that is news.
    pub fn learn_shadows(&mut self, proven: &ProvenShadows) -> bool {
        let learned = proven.learned().unwrap_or_default();
        std::mem::replace(&mut self.shadows, learned) != learned
    }

    /// The change of the `wanted` frames of `run` (no more than [`PLATE_RUN`] frames in a row), kept in the scratch file.
    /// Returns what proves shadows there.
    pub fn put_changes(
        &self,
        clip: &Clip<'_>,
        run: std::ops::Range<usize>,
        wanted: &(dyn Fn(usize) -> bool + Sync),
    ) -> Result<ProvenShadows, SegmentError> {
        let mut drawn: Option<Drawn> = None;
        let mut proven = ProvenShadows::default();
        for index in run.clone().filter(|index| wanted(*index)) {
            clip.watch.check()?;
            let unbroken = drawn.as_ref().is_some_and(|d| self.placed[d.index].0 == self.placed[index].0);
            if !unbroken {
                let last = run.clone().rev().find(|i| self.placed[*i].0 == self.placed[index].0);
                drawn = Some(self.drawn(usize::midpoint(index, last.unwrap_or(index)), clip)?);
            }
            let frame = clip.scratch.frame(index)?;
            let change = match &drawn {
                Some(drawn) => change(&frame, &self.moved(drawn, index)?, &self.shadows, &mut proven)?,
                None => binary::map2(&frame.grey, &frame.grey, |_, _| UNKNOWN)?,
            };
            clip.scratch.put(index, Layer::Change, &change)?;
        }
        Ok(proven)
    }

    /// The plate of one frame on the grid of another of the same unbroken run.
    fn moved(&self, drawn: &Drawn, index: usize) -> opencv::Result<Drawn> {
        let to = self.placed[drawn.index].1.try_inverse().unwrap_or_else(Matrix3::identity);
        let homography = to * self.placed[index].1;
        let motion = BackgroundMotion::known(homography);
        let (lab, doubt) = warped(&drawn.lab, &drawn.doubt, &motion)?;
        Ok(Drawn { index, lab, doubt })
    }

    /// The median of aligned key frames on the grid of frame `index`.
    fn drawn(&self, index: usize, clip: &Clip<'_>) -> opencv::Result<Drawn> {
        let samples = self.samples(index)?;
        let (rows, cols) = (clip.scale.work.height as i32, clip.scale.work.width as i32);
        let labs = samples
            .iter()
            .map(|s| Ok((s.lab.data_bytes()?.as_chunks::<3>().0, s.hidden.data_bytes()?)))
            .collect::<opencv::Result<Vec<_>>>()?;
        let recurring = recurring(&samples, clip.palm_width)?;
        let mut lab = Mat::new_rows_cols_with_default(rows, cols, CV_8UC3, Scalar::all(0.0))?;
        let mut doubt = binary::empty(rows, cols)?;
        let pixels = lab.data_bytes_mut()?.as_chunks_mut::<3>().0;
        for (position, (pixel, doubt)) in pixels.iter_mut().zip(doubt.data_bytes_mut()?).enumerate() {
            let mut seen = [[0_u8; SAMPLES]; 3];
            let (mut count, mut certain) = (0, 0);
            for (lab, hidden) in &labs {
                if hidden[position] < SUSPECT {
                    for channel in 0..3 {
                        seen[channel][count] = lab[position][channel];
                    }
                    count += 1;
                    certain += usize::from(hidden[position] == 0);
                }
            }
            let witnessed = recurring.get(position).and_then(|sample| labs.get(*sample));
            if let Some((lab, _)) = witnessed.filter(|_| certain < 2) {
                *pixel = lab[position];
                continue;
            }
            if count < 2 {
                *doubt = HIDDEN;
                continue;
            }
            *doubt = if certain < 2 { DOUBTFUL } else { 0 };
            *pixel = [0, 1, 2].map(|channel| {
                let values = &mut seen[channel][..count];
                values.sort_unstable();
                values[count / 2]
            });
        }
        let mut drawn = Drawn { index, lab, doubt };
        self.leave_out_object(&mut drawn, clip)?;
        Ok(drawn)
    }

    /// Where the object that is handled stands in the plate, nothing is known of the background: that it is
    /// taken away is no arm's doing.
    fn leave_out_object(&self, drawn: &mut Drawn, clip: &Clip<'_>) -> opencv::Result<()> {
        let (Some(object), Some(table)) = (&clip.object, &clip.object_table) else { return Ok(()) };
        let (run, to_first) = self.placed[drawn.index];
        let Some((_, from_first)) =
            self.placed.get(object.frame.as_usize()).filter(|(object_run, _)| *object_run == run)
        else {
            return Ok(());
        };
        let Some(from_first) = from_first.try_inverse() else { return Ok(()) };
        let motion = BackgroundMotion::known(from_first * to_first);
        let cols = drawn.lab.cols() as usize;
        let pixels = drawn.lab.data_bytes()?.as_chunks::<3>().0;
        for (position, doubt) in drawn.doubt.data_bytes_mut()?.iter_mut().enumerate() {
            let here = Pixel::new((position % cols) as f64, (position / cols) as f64);
            if LabHistogram::look_up(table, pixels[position]) > OBJECT
                && object.bounds.contains(clip.scale.to_full(motion.apply(here)))
            {
                *doubt = HIDDEN;
            }
        }
        Ok(())
    }

    /// Key frames of the same run drawn on the grid of frame `index`, with what is not to be used.
    fn samples(&self, index: usize) -> opencv::Result<Vec<Sample>> {
        let (run, to_first) = self.placed[index];
        let near: Vec<&Keyframe> = self
            .keyframes
            .iter()
            .filter(|key| self.placed[key.index].0 == run && key.index != index)
            .collect();
        // Where a hand was missed, less is certain, but it may have been elsewhere.
        let (known, missed): (Vec<&Keyframe>, Vec<&Keyframe>) =
            near.into_iter().partition(|key| key.wrists.is_some());
        let mut chosen = spread(&known, SAMPLES - missed.len().min(SAMPLES / 3));
        chosen.extend(spread(&missed, SAMPLES - chosen.len()));
        chosen.sort_unstable_by_key(|key| key.index);
        let mut samples = Vec::new();
        for key in chosen {
            let Some(inverse) = self.placed[key.index].1.try_inverse() else { continue };
            let motion = BackgroundMotion::known(inverse * to_first);
            let (lab, hidden) = warped(&key.lab, &key.hidden, &motion)?;
            let back = motion.homography.try_inverse().unwrap_or_else(Matrix3::identity);
            let back = BackgroundMotion::known(back);
            let wrists = key
                .wrists
                .as_ref()
                .map(|wrists| PerSide::from_fn(|side| wrists[side].map(|wrist| back.apply(wrist))));
            samples.push(Sample { index: key.index, lab, hidden, wrists });
        }
        Ok(samples)
    }
}

impl Clip<'_> {
    /// Aligns the background now that `table` tells roughly where arms are, and compares the `chosen` frames to it.
    pub(super) fn align(&mut self, table: &[u8], chosen: &[usize]) -> Result<(), SegmentError> {
        self.plate = Some(Plate::build(self, table)?);
        let wanted = |index: usize| chosen.binary_search(&index).is_ok();
        let proven = self.put_changes(&wanted)?;
        if let Some(plate) = &mut self.plate
            && plate.learn_shadows(&proven)
        {
            self.put_changes(&wanted)?;
        }
        Ok(())
    }

    /// Draws the background anew, now that `table` tells better where arms are, and compares all frames to it.
    pub(super) fn hide_again(&mut self, table: &[u8]) -> Result<(), SegmentError> {
        if let Some(mut plate) = self.plate.take() {
            plate.hide_again(self, table)?;
            self.plate = Some(plate);
        }
        self.put_changes(&|_| true)?;
        Ok(())
    }

    /// What is known of the clip's shadows so far.
    pub(super) fn shadows(&self) -> Shadows {
        self.plate.as_ref().map(Plate::shadows).unwrap_or_default()
    }

    fn put_changes(&self, wanted: &(dyn Fn(usize) -> bool + Sync)) -> Result<ProvenShadows, SegmentError> {
        let Some(plate) = &self.plate else { return Ok(ProvenShadows::default()) };
        let put = |run: &usize| {
            plate.put_changes(self, run * PLATE_RUN..((run + 1) * PLATE_RUN).min(self.count()), wanted)
        };
        let all: Vec<usize> = (0..self.count().div_ceil(PLATE_RUN)).collect();
        let proven = all.par_iter().map(put).collect::<Result<Vec<_>, SegmentError>>()?;
        Ok(proven.iter().fold(ProvenShadows::default(), |mut sum, proven| {
            sum.merge(proven);
            sum
        }))
    }
}

/// At most `most` of `from`, evenly spread.
fn spread<'k>(from: &[&'k Keyframe], most: usize) -> Vec<&'k Keyframe> {
    if most == 0 {
        return Vec::new();
    }
    let stride = from.len().div_ceil(most).max(1);
    from.iter().copied().skip(stride / 2).step_by(stride).take(most).collect()
}

/// Lab distance of `frame` from the background behind it, CV_8UC1, at most 254; [`UNKNOWN`] where fewer than two
/// key frames saw the background, [`SHADOW`] where it is seen in one of `shadows`. Counts in `proven` what shows the
/// background's texture in shadow.
fn change(
    frame: &WorkFrame,
    plate: &Drawn,
    shadows: &Shadows,
    proven: &mut ProvenShadows,
) -> opencv::Result<Mat> {
    let (rows, cols) = (frame.grey.rows(), frame.grey.cols());
    let pixels = frame.pixels()?;
    let backgrounds = plate.lab.data_bytes()?.as_chunks::<3>().0;
    let mut change = binary::empty(rows, cols)?;
    let mut shades = vec![Shade::No; pixels.len()];
    let doubts = plate.doubt.data_bytes()?;
    for (position, value) in change.data_bytes_mut()?.iter_mut().enumerate() {
        if doubts[position] == HIDDEN {
            *value = UNKNOWN;
            continue;
        }
        let (pixel, background) = (pixels[position], backgrounds[position]);
        shades[position] = shadows.shade(pixel, background);
        let squared: i32 =
            (0..3).map(|channel| (i32::from(pixel[channel]) - i32::from(background[channel])).pow(2)).sum();
        let difference = (squared as f32).sqrt().min(254.0) as u8;
        *value = if doubts[position] == DOUBTFUL { difference.max(NEUTRAL) } else { difference };
    }
    let alike = Likeness::of(&frame.lab, &plate.lab)?;
    let cols = cols as usize;
    for (position, (value, shade)) in change.data_bytes_mut()?.iter_mut().zip(shades).enumerate() {
        if shade == Shade::No {
            continue;
        }
        let texture = alike.at(position % cols, position / cols);
        if doubts[position] == 0 {
            proven.add(pixels[position], backgrounds[position], texture);
        }
        if texture == Texture::Same || (texture == Texture::Flat && shade == Shade::Surely) {
            *value = SHADOW;
        }
    }
    Ok(change)
}

/// Where arms are or may be on a frame, with a margin.
fn hidden(clip: &Clip<'_>, index: usize, frame: &WorkFrame, table: &[u8]) -> opencv::Result<Mat> {
    binary::dilated(&clip.hidden(index, frame, table)?, 4)
}

/// What one run of frames adds.
struct Aligned {
    /// The background's motion from each frame to the one before.
    steps: Vec<Option<BackgroundMotion>>,
    keyframes: Vec<Keyframe>,
}

fn align_run(
    clip: &Clip<'_>,
    table: &[u8],
    run: std::ops::Range<usize>,
    stride: usize,
) -> Result<Aligned, SegmentError> {
    let read = |index: usize| clip.scratch.frame(index);
    let mut before = run.start.checked_sub(1).map(read).transpose()?;
    let mut aligned = Aligned { steps: Vec::new(), keyframes: Vec::new() };
    for index in run {
        clip.watch.check()?;
        let frame = read(index)?;
        let hidden = hidden(clip, index, &frame, table)?;
        let step = match &before {
            Some(before) => {
                let arms = binary::map2(&hidden, &hidden, |grade, _| u8::from(grade >= SUSPECT))?;
                background_motion_from(&frame.grey, &before.grey, Some(&arms), FEATURES)?
            }
            None => None,
        };
        aligned.steps.push(step);
        if index % stride == 0 {
            let all_seen = clip.hands[index].len() == clip.most_hands;
            let wrists = all_seen.then(|| {
                PerSide::from_fn(|side| clip.sides[index][side].as_ref().map(super::shape::HandShape::wrist))
            });
            aligned.keyframes.push(Keyframe { index, lab: frame.lab.try_clone()?, hidden, wrists });
        }
        before = Some(frame);
    }
    Ok(aligned)
}

/// A picture and what is not to be used of it, as seen from the frame whose pixels `motion` takes to it;
/// hidden where unseen.
fn warped(lab: &Mat, hidden: &Mat, motion: &BackgroundMotion) -> opencv::Result<(Mat, Mat)> {
    let size = lab.size()?;
    let matrix = motion.to_mat()?;
    let flags = imgproc::INTER_LINEAR | imgproc::WARP_INVERSE_MAP;
    let border = opencv::core::BORDER_CONSTANT;
    let mut warped = Mat::default();
    imgproc::warp_perspective(lab, &mut warped, &matrix, size, flags, border, Scalar::all(0.0))?;
    let mut unseen = Mat::default();
    let nearest = imgproc::INTER_NEAREST | imgproc::WARP_INVERSE_MAP;
    imgproc::warp_perspective(hidden, &mut unseen, &matrix, size, nearest, border, Scalar::all(255.0))?;
    Ok((warped, unseen))
}
