//! The clip at work scale: sampled views of the background, hands, and how the camera moved.

use nalgebra::Matrix3;
use opencv::{
    core::{Mat, MatTraitConstManual},
    imgproc,
};
use rayon::prelude::*;

use super::{SelectError, SelectInput, SelectParams};
use crate::{
    clip::FrameIndex,
    geometry::{Pixel, Side},
    landmarks::HandLandmarks,
    progress::Watch,
    vision::{BackgroundMotion, CameraPath, View, WorkScale, background_motion_from, binary},
};

/// A hand on a frame, work pixels.
#[derive(Clone, Debug)]
pub(super) struct Hand {
    pub side: Side,
    pub keypoints: Vec<Pixel>,
    /// Across the knuckles, or what the hand's length tells of it when it is seen edge-on.
    pub palm_width: f64,
}

impl Hand {
    pub fn new(side: Side, hand: &HandLandmarks, scale: &WorkScale) -> Self {
        let keypoints: Vec<Pixel> = hand.keypoints.iter().map(|p| scale.to_work(*p)).collect();
        let palm = keypoints[0].distance(keypoints[9]);
        let palm_width = keypoints[5].distance(keypoints[17]).max(0.6 * palm).max(4.0);
        Self { side, keypoints, palm_width }
    }
}

/// A frame kept at work scale.
#[derive(Debug)]
pub(super) struct Sample {
    pub index: usize,
    /// Valid where no arm is.
    pub view: View,
    /// CV_8UC1: the arm mask, slightly grown.
    pub arm: Mat,
    pub hands: Vec<Hand>,
}

/// Samples spread over the clip, in order, and the camera's path between them.
pub(super) struct Scene<'a> {
    pub input: SelectInput<'a>,
    pub scale: WorkScale,
    /// Taken from frames that are links of the camera's path.
    pub samples: Vec<Sample>,
    path: CameraPath,
}

/// Frames between links of the camera's path.
const LINK: usize = 3;
/// Links made one after the other on one thread.
const RUN: usize = 16;
/// Corners that the camera's motion is measured by.
const CORNERS: i32 = 200;
/// Mean difference, grey levels, up to which two pictures without corners show one view.
const SAME_VIEW: f64 = 12.0;

impl<'a> Scene<'a> {
    pub fn new(
        input: SelectInput<'a>,
        params: &SelectParams,
        watch: &dyn Watch,
    ) -> Result<Self, SelectError> {
        let count = input.frames.frame_count();
        let work = WorkScale::fit(input.frames.size(), params.work_size);
        let links = count.div_ceil(LINK);
        let each = links.div_ceil(params.samples.max(2)).max(1);
        let runs: Vec<usize> = (0..links).step_by(RUN).collect();
        let parts = runs
            .par_iter()
            .map(|first| {
                watch.check()?;
                let mut scene = Part::default();
                let mut before: Option<Sample> = None;
                for link in first.saturating_sub(1)..(first + RUN).min(links) {
                    let sample = sample(&input, link * LINK, &work)?;
                    if let Some(before) = &before {
                        scene.steps.push(step(before, &sample)?);
                    }
                    if let Some(before) = before.replace(sample)
                        && (before.index / LINK).is_multiple_of(each)
                        && before.index / LINK >= *first
                    {
                        scene.samples.push(before);
                    }
                }
                scene.samples.extend(before.filter(|last| (last.index / LINK).is_multiple_of(each)));
                Ok(scene)
            })
            .collect::<Result<Vec<Part>, SelectError>>()?;
        let (mut steps, mut samples) = (Vec::new(), Vec::new());
        for part in parts {
            steps.extend(part.steps);
            samples.extend(part.samples);
        }
        let path = CameraPath::from_steps(&steps);
        Ok(Self { input, scale: work, samples, path })
    }

    /// Takes work pixels of frame `from` to frame `to`, both samples; `None` across a cut.
    pub fn camera(&self, from: usize, to: usize) -> Option<Matrix3<f64>> {
        self.path.between(from / LINK, to / LINK)
    }
}

#[derive(Default)]
struct Part {
    steps: Vec<Option<Matrix3<f64>>>,
    samples: Vec<Sample>,
}

/// Reads frame `index` at work scale.
pub(super) fn sample(
    input: &SelectInput<'_>,
    index: usize,
    scale: &WorkScale,
) -> Result<Sample, SelectError> {
    let picture = scale.shrink(&input.frames.frame(FrameIndex(index as u32))?.to_mat()?)?;
    let arm = scale.shrink_mask(&input.arms.frames[index].mask.decode().to_mat()?)?;
    let arm = binary::dilated(&arm, 1)?;
    let view = View::new(WorkScale { full: scale.work, work: scale.work }, &picture, &arm)?;
    let hands = Side::BOTH
        .iter()
        .filter_map(|side| Some(Hand::new(*side, input.landmarks[index][*side].as_ref()?, scale)))
        .collect();
    Ok(Sample { index, view, arm, hands })
}

/// The background's motion to the next link; a view without corners that looks the same stands still.
fn step(from: &Sample, to: &Sample) -> opencv::Result<Option<Matrix3<f64>>> {
    let found = background_motion_from(&from.view.gray, &to.view.gray, Some(&from.arm), CORNERS)?;
    if let Some(motion) = found {
        return Ok(Some(motion.homography));
    }
    let (mut sum, mut count) = (0.0, 0_u32);
    let (a, b) = (from.view.gray.data_bytes()?, to.view.gray.data_bytes()?);
    for ((a, b), (v, w)) in
        a.iter().zip(b).zip(from.view.valid.data_bytes()?.iter().zip(to.view.valid.data_bytes()?))
    {
        if *v != 0 && *w != 0 {
            sum += f64::from(a.abs_diff(*b));
            count += 1;
        }
    }
    Ok((sum < SAME_VIEW * f64::from(count)).then(Matrix3::identity))
}

/// Where `p` lies under `map`.
pub(super) fn mapped(map: &Matrix3<f64>, p: Pixel) -> Pixel {
    BackgroundMotion::known(*map).apply(p)
}

/// RGB to Lab, both CV_8UC3.
pub(super) fn to_lab(rgb: &Mat) -> opencv::Result<Mat> {
    let mut lab = Mat::default();
    imgproc::cvt_color_def(rgb, &mut lab, imgproc::COLOR_RGB2Lab)?;
    Ok(lab)
}
