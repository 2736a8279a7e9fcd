//! How much a frame differs from the background behind it, moving head included.

use nalgebra::Matrix3;
use opencv::{
    core::{CV_8UC3, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar},
    imgproc,
};
use rayon::prelude::*;

use super::work_frame::WorkFrame;
use crate::{
    clip::{FrameIndex, FrameSource},
    progress::Watch,
    segment::{RleMask, SegmentError},
    vision::{BackgroundMotion, WorkScale, background_motion, binary},
};

/// Samples that one plate is the median of.
const SAMPLES: usize = 9;
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
    /// Where arms were found so far, grown.
    hidden: Mat,
}

impl Plate {
    /// Aligns the clip at work scale. `arms` are the first masks at work scale, where there are any.
    pub fn build(
        frames: &dyn FrameSource,
        scale: &WorkScale,
        arms: &(dyn Fn(usize) -> Option<RleMask> + Sync),
        watch: &dyn Watch,
    ) -> Result<Self, SegmentError> {
        let count = frames.frame_count();
        let steps: Vec<Option<BackgroundMotion>> = (1..count)
            .into_par_iter()
            .map(|index| {
                watch.check()?;
                let (now, _) = WorkFrame::read(frames, FrameIndex(index as u32), scale)?;
                let (before, _) = WorkFrame::read(frames, FrameIndex(index as u32 - 1), scale)?;
                let exclude = arms(index).map(|mask| mask.decode().to_mat()).transpose()?;
                Ok(background_motion(&now.grey, &before.grey, exclude.as_ref())?)
            })
            .collect::<Result<_, SegmentError>>()?;
        let mut placed = vec![(0, Matrix3::identity())];
        for step in steps {
            let (run, to_first) = placed[placed.len() - 1];
            placed.push(match step {
                Some(motion) => (run, to_first * motion.homography),
                None => (run + 1, Matrix3::identity()),
            });
        }
        let stride = count.div_ceil(KEYFRAMES).max(1);
        let keyframes = (0..count)
            .step_by(stride)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|index| {
                let (frame, _) = WorkFrame::read(frames, FrameIndex(index as u32), scale)?;
                let hidden = match arms(index) {
                    Some(mask) => binary::dilated(&mask.decode().to_mat()?, 5)?,
                    None => binary::empty(frame.grey.rows(), frame.grey.cols())?,
                };
                Ok(Keyframe { index, lab: frame.lab, hidden })
            })
            .collect::<Result<Vec<_>, SegmentError>>()?;
        Ok(Self { placed, keyframes })
    }

    /// Lab distance of `frame` from the median of aligned key frames, CV_8UC1; zero where no key
    /// frame saw the background.
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
            let mut count = 0;
            for (lab, hidden) in &labs {
                if hidden[position] == 0 {
                    for channel in 0..3 {
                        seen[channel][count] = lab[position][channel];
                    }
                    count += 1;
                }
            }
            if count < 2 {
                continue;
            }
            let mut squared = 0.0;
            for channel in 0..3 {
                let values = &mut seen[channel][..count];
                values.sort_unstable();
                let median = f32::from(values[count / 2]);
                squared += (f32::from(pixels[position][channel]) - median).powi(2);
            }
            *value = squared.sqrt().min(255.0) as u8;
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
