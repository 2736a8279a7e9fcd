//! Landmarks of both hands over a clip, from an external estimator.

use std::collections::VecDeque;

use opencv::{
    core::{Mat, Size as CvSize},
    imgproc::{INTER_AREA, resize},
};
use serde::{Deserialize, Serialize};

use super::{
    HandsError,
    detection::Detection,
    estimator::{EstimatorCommand, EstimatorProcess, Mode, Request},
    outliers::remove_jumps,
    recover::recover,
    sides::{assign, landmarks_of},
    smooth::smooth_keypoints,
    tracklet::link,
};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::Pixel,
    image::Rgb8,
    landmarks::LandmarkTrack,
    progress::Watch,
};

/// How the estimator is used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EstimateParams {
    /// Longer side of the pictures sent, pixels; larger frames are sent smaller (default 960).
    pub picture_side: u32,
    /// Magnified second looks for missed hands, as a share of the clip's frames (default 0.5).
    pub recover_share: f64,
    /// Second looks in a row that may fail before a hand is given up (default 3).
    pub recover_misses: usize,
    /// Half-power frequency of the smoother that every keypoint passes, Hz (default 6).
    pub smoothing_hz: f64,
}

impl Default for EstimateParams {
    fn default() -> Self {
        Self { picture_side: 960, recover_share: 0.5, recover_misses: 3, smoothing_hz: 6.0 }
    }
}

/// What an estimator saw in a clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimation {
    /// Landmarks of both hands, one a frame.
    pub landmarks: LandmarkTrack,
    /// What the estimator calls itself, for example `mediapipe`.
    pub backend: String,
}

/// Runs `estimator` over `frames`: hands followed over time, left and right told apart, jumps
/// removed, missed hands looked for again in magnified crops, keypoints smoothed without lag.
///
/// The result depends on the frames, the parameters and the estimator's answers alone.
///
/// # Errors
/// When the estimator cannot be started, speaks another protocol, dies, misses a time-out or
/// answers nonsense; when a frame cannot be read; when cancelled.
pub fn estimate(
    frames: &dyn FrameSource,
    estimator: &EstimatorCommand,
    params: &EstimateParams,
    watch: &dyn Watch,
) -> Result<Estimation, HandsError> {
    let count = frames.frame_count();
    let mut process = EstimatorProcess::start(estimator, count)?;
    let detections = detect_all(frames, &mut process, params, watch)?;
    let mut sides = assign(link(detections), count, frames.size());
    for side in [&mut sides.left, &mut sides.right] {
        remove_jumps(side);
    }
    let budget = (params.recover_share.clamp(0.0, 10.0) * count as f64) as usize;
    recover(frames, &mut process, &mut sides, params, budget, watch)?;
    for side in [&mut sides.left, &mut sides.right] {
        remove_jumps(side);
        smooth_keypoints(side, params.smoothing_hz);
    }
    let backend = process.name().to_owned();
    Ok(Estimation { landmarks: landmarks_of(sides), backend })
}

/// Every frame once, in order; a frame that repeats the one before shares its answer.
fn detect_all(
    frames: &dyn FrameSource,
    process: &mut EstimatorProcess,
    params: &EstimateParams,
    watch: &dyn Watch,
) -> Result<Vec<Vec<Detection>>, HandsError> {
    let count = frames.frame_count();
    // For each picture in flight the frames it stands for.
    let mut waiting: VecDeque<(usize, f64)> = VecDeque::new();
    let mut found: Vec<Vec<Detection>> = Vec::with_capacity(count);
    let mut previous: Option<Rgb8> = None;
    for index in FrameIndex::all(count) {
        watch.check()?;
        let picture = frames.frame(index)?;
        if previous.as_ref() == Some(&picture) {
            if let Some((repeats, _)) = waiting.back_mut() {
                *repeats += 1;
            } else if let Some(last) = found.last().cloned() {
                found.push(last);
            }
            continue;
        }
        while !process.has_room() {
            take_answer(process, &mut waiting, &mut found)?;
            watch.advance(found.len(), count);
        }
        let (small, scale) = reduced(&picture, params.picture_side)?;
        process.send(Request { frame: index, mode: Mode::Track, picture: small })?;
        waiting.push_back((1, scale));
        previous = Some(picture);
    }
    while process.in_flight() > 0 {
        watch.check()?;
        take_answer(process, &mut waiting, &mut found)?;
        watch.advance(found.len(), count);
    }
    Ok(found)
}

fn take_answer(
    process: &mut EstimatorProcess,
    waiting: &mut VecDeque<(usize, f64)>,
    found: &mut Vec<Vec<Detection>>,
) -> Result<(), HandsError> {
    let mut detections = process.receive()?;
    let Some((repeats, scale)) = waiting.pop_front() else { return Ok(()) };
    for p in detections.iter_mut().flat_map(|d| &mut d.keypoints) {
        // Pixel centres: half a pixel from the edge before and after.
        *p = Pixel::new((p.x + 0.5) * scale - 0.5, (p.y + 0.5) * scale - 0.5);
    }
    found.extend(std::iter::repeat_n(detections, repeats));
    Ok(())
}

/// The picture with its longer side at most `side`, and clip pixels a pixel of it.
fn reduced(picture: &Rgb8, side: u32) -> Result<(Rgb8, f64), HandsError> {
    let size = picture.size();
    let longer = size.width.max(size.height);
    if longer <= side.max(64) {
        return Ok((picture.clone(), 1.0));
    }
    let scale = f64::from(longer) / f64::from(side.max(64));
    let reduced = |pixels: u32| ((f64::from(pixels) / scale).round() as i32).max(1);
    let mut small = Mat::default();
    let target = CvSize::new(reduced(size.width), reduced(size.height));
    resize(&picture.to_mat()?, &mut small, target, 0.0, 0.0, INTER_AREA)?;
    Ok((Rgb8::from_mat(&small)?, scale))
}
