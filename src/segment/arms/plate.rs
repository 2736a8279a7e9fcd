//! How much a frame differs from the background behind it, moving head included.

use nalgebra::Matrix3;
use opencv::{
    core::{CV_8UC3, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar},
    imgproc,
};
use rayon::prelude::*;

use super::{Clip, runs, work_frame::WorkFrame};
use crate::{
    clip::FrameIndex,
    segment::SegmentError,
    vision::{BackgroundMotion, background_motion, binary},
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
/// Key frames over the whole clip.
const KEYFRAMES: usize = 40;

/// Frames at work scale spread over the clip, with the homography of every frame to the first.
pub(super) struct Plate {
    /// From each frame to the first of its unbroken run, and the run's number.
    placed: Vec<(usize, Matrix3<f64>)>,
    keyframes: Vec<Keyframe>,
}

struct Keyframe {
    index: usize,
    lab: Mat,
    /// [`HIDDEN`], [`DOUBTFUL`] or 0.
    hidden: Mat,
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
        Ok(Self { placed, keyframes })
    }

    /// Lab distance of `frame` from the median of aligned key frames, CV_8UC1, at most 254;
    /// [`UNKNOWN`] where fewer than two key frames saw the background.
    pub fn change(&self, index: usize, frame: &WorkFrame) -> opencv::Result<Mat> {
        let samples = self.samples(index)?;
        let (rows, cols) = (frame.grey.rows(), frame.grey.cols());
        let mut change = binary::empty(rows, cols)?;
        let labs = samples
            .iter()
            .map(|(lab, hidden)| Ok((lab.data_bytes()?.as_chunks::<3>().0, hidden.data_bytes()?)))
            .collect::<opencv::Result<Vec<_>>>()?;
        let pixels = frame.pixels()?;
        for (position, value) in change.data_bytes_mut()?.iter_mut().enumerate() {
            let mut seen = [[0_u8; SAMPLES]; 3];
            let (mut count, mut certain) = (0, 0);
            for (lab, hidden) in &labs {
                if hidden[position] != HIDDEN {
                    for channel in 0..3 {
                        seen[channel][count] = lab[position][channel];
                    }
                    count += 1;
                    certain += usize::from(hidden[position] == 0);
                }
            }
            if count < 2 {
                *value = UNKNOWN;
                continue;
            }
            let mut squared = 0.0;
            for channel in 0..3 {
                let values = &mut seen[channel][..count];
                values.sort_unstable();
                let median = f32::from(values[count / 2]);
                squared += (f32::from(pixels[position][channel]) - median).powi(2);
            }
            let difference = squared.sqrt().min(254.0) as u8;
            *value = if certain < 2 { difference.max(NEUTRAL) } else { difference };
        }
        Ok(change)
    }

    /// Key frames of the same run drawn on the grid of frame `index`, with what is not to be used.
    fn samples(&self, index: usize) -> opencv::Result<Vec<(Mat, Mat)>> {
        let (run, to_first) = self.placed[index];
        let near: Vec<&Keyframe> = self
            .keyframes
            .iter()
            .filter(|key| self.placed[key.index].0 == run && key.index != index)
            .collect();
        let stride = near.len().div_ceil(SAMPLES).max(1);
        let mut samples = Vec::new();
        for key in near.iter().skip(stride / 2).step_by(stride).take(SAMPLES) {
            let Some(inverse) = self.placed[key.index].1.try_inverse() else { continue };
            let motion = BackgroundMotion { homography: inverse * to_first, inlier_share: 1.0, inliers: 0 };
            samples.push(warped(key, &motion)?);
        }
        Ok(samples)
    }
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
    let read =
        |index: usize| WorkFrame::read(clip.frames, FrameIndex(index as u32), &clip.scale).map(|(f, _)| f);
    let mut before = run.start.checked_sub(1).map(read).transpose()?;
    let mut aligned = Aligned { steps: Vec::new(), keyframes: Vec::new() };
    for index in run {
        clip.watch.check()?;
        let frame = read(index)?;
        let hidden = binary::dilated(&clip.hidden(index, &frame, table)?, 4)?;
        let step = match &before {
            Some(before) => {
                let arms = binary::map2(&hidden, &hidden, |grade, _| u8::from(grade == HIDDEN))?;
                background_motion(&frame.grey, &before.grey, Some(&arms))?
            }
            None => None,
        };
        aligned.steps.push(step);
        if index % stride == 0 {
            aligned.keyframes.push(Keyframe { index, lab: frame.lab.try_clone()?, hidden });
        }
        before = Some(frame);
    }
    Ok(aligned)
}

/// The key frame as seen from the frame whose pixels `motion` takes to it; hidden where unseen.
fn warped(key: &Keyframe, motion: &BackgroundMotion) -> opencv::Result<(Mat, Mat)> {
    let size = key.lab.size()?;
    let matrix = motion.to_mat()?;
    let flags = imgproc::INTER_LINEAR | imgproc::WARP_INVERSE_MAP;
    let border = opencv::core::BORDER_CONSTANT;
    let mut lab = Mat::new_size_with_default(size, CV_8UC3, Scalar::all(0.0))?;
    imgproc::warp_perspective(&key.lab, &mut lab, &matrix, size, flags, border, Scalar::all(0.0))?;
    let mut hidden = Mat::default();
    let nearest = imgproc::INTER_NEAREST | imgproc::WARP_INVERSE_MAP;
    imgproc::warp_perspective(&key.hidden, &mut hidden, &matrix, size, nearest, border, Scalar::all(255.0))?;
    Ok((lab, hidden))
}
