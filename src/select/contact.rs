//! What moves with a hand: flow minus the background's motion, near the fingertips, not arm.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual},
    imgproc,
};

use super::{SelectError, SelectInput, SelectParams};
use crate::{
    clip::FrameIndex,
    geometry::{Pixel, Side},
    landmarks::{HandLandmarks, keypoint},
    vision::{
        BackgroundMotion, Flow, FlowQuality, WorkScale, background_motion, binary, box_blurred, dense_flow,
    },
};

/// A frame at work scale.
pub(super) struct Look {
    pub lab: Mat,
    pub grey: Mat,
    /// Arm mask, slightly grown.
    pub arm: Mat,
}

/// Something that moved with a hand on a frame.
pub(super) struct Moment {
    pub index: usize,
    /// Its pixels at work scale.
    pub blob: Mat,
    /// Strength of the evidence, 0 to 1.
    pub score: f64,
    pub palm_width: f64,
}

pub(super) fn look(input: &SelectInput<'_>, index: usize, scale: &WorkScale) -> Result<Look, SelectError> {
    let picture = input.frames.frame(FrameIndex(index as u32))?;
    let small = scale.shrink(&picture.to_mat()?)?;
    let (mut lab, mut grey) = (Mat::default(), Mat::default());
    imgproc::cvt_color(&small, &mut lab, imgproc::COLOR_RGB2Lab, 0)?;
    imgproc::cvt_color(&small, &mut grey, imgproc::COLOR_RGB2GRAY, 0)?;
    let arm = input.arms.frames[index].mask.decode().to_mat()?;
    let arm = binary::dilated(&scale.shrink_mask(&arm)?, 1)?;
    Ok(Look { lab, grey, arm })
}

/// A hand at work scale: fingertips, palm width and how it moved against the background.
struct MovingHand {
    tips: Vec<Pixel>,
    palm_width: f64,
    motion: [f64; 2],
}

fn moving_hand(
    now: &HandLandmarks,
    then: &HandLandmarks,
    background: &BackgroundMotion,
    scale: &WorkScale,
) -> MovingHand {
    let points = now.keypoints.map(|p| scale.to_work(p));
    let later = then.keypoints.map(|p| scale.to_work(p));
    let (mut dx, mut dy) = (0.0, 0.0);
    for (from, to) in points.iter().zip(&later) {
        let expected = background.apply(*from);
        dx += (to.x - expected.x) / points.len() as f64;
        dy += (to.y - expected.y) / points.len() as f64;
    }
    let palm = points[0].distance(points[9]);
    let palm_width = points[5].distance(points[17]).max(0.6 * palm).max(4.0);
    let mut tips: Vec<Pixel> = keypoint::TIPS.iter().map(|i| points[*i]).collect();
    tips.push(Pixel::new(0.5 * (points[4].x + points[8].x), 0.5 * (points[4].y + points[8].y)));
    MovingHand { tips, palm_width, motion: [dx, dy] }
}

/// The strongest thing moving with each hand between `index` and `index + stride`.
pub(super) fn moments_at(
    input: &SelectInput<'_>,
    index: usize,
    scale: &WorkScale,
    params: &SelectParams,
) -> Result<Vec<Moment>, SelectError> {
    let later = index + params.stride.max(1);
    let mut found = Vec::new();
    if later >= input.frames.frame_count() {
        return Ok(found);
    }
    let hands: Vec<(&HandLandmarks, &HandLandmarks)> = Side::BOTH
        .iter()
        .filter_map(|side| {
            Some((input.landmarks[index][*side].as_ref()?, input.landmarks[later][*side].as_ref()?))
        })
        .collect();
    if hands.is_empty() {
        return Ok(found);
    }
    let (now, then) = (look(input, index, scale)?, look(input, later, scale)?);
    let background =
        background_motion(&now.grey, &then.grey, Some(&now.arm))?.unwrap_or(BackgroundMotion::still());
    let flow = dense_flow(&now.grey, &then.grey, FlowQuality::Medium)?;
    let gain = explanation_gain(&now, &then, &flow, &background)?;
    for (hand, hand_later) in hands {
        let hand = moving_hand(hand, hand_later, &background, scale);
        if let Some(moment) = moved_with(index, &now, &flow, &background, &gain, &hand, params)? {
            found.push(moment);
        }
    }
    Ok(found)
}

/// By how many grey levels the flow explains each pixel better than the background's motion does.
/// Plain ground beside a moving arm inherits the arm's flow; this tells it from a moving thing.
fn explanation_gain(
    now: &Look,
    then: &Look,
    flow: &Flow,
    background: &BackgroundMotion,
) -> opencv::Result<Vec<i16>> {
    let by_flow = flow.pull(&then.grey)?;
    let mut by_background = Mat::default();
    let flags = imgproc::INTER_LINEAR | imgproc::WARP_INVERSE_MAP;
    let border = opencv::core::BORDER_REPLICATE;
    let none = opencv::core::Scalar::all(0.0);
    let size = now.grey.size()?;
    let matrix = background.to_mat()?;
    imgproc::warp_perspective(&then.grey, &mut by_background, &matrix, size, flags, border, none)?;
    let errors = |predicted: &Mat| -> opencv::Result<Mat> {
        let mut error = Mat::default();
        opencv::core::absdiff(&now.grey, predicted, &mut error)?;
        box_blurred(&error, 5)
    };
    let (flow_error, background_error) = (errors(&by_flow)?, errors(&by_background)?);
    let pairs = background_error.data_bytes()?.iter().zip(flow_error.data_bytes()?);
    Ok(pairs.map(|(background, flow)| i16::from(*background) - i16::from(*flow)).collect())
}

fn moved_with(
    index: usize,
    now: &Look,
    flow: &Flow,
    background: &BackgroundMotion,
    gain: &[i16],
    hand: &MovingHand,
    params: &SelectParams,
) -> opencv::Result<Option<Moment>> {
    let speed = hand.motion[0].hypot(hand.motion[1]);
    if speed < 1.5 {
        return Ok(None);
    }
    let cols = now.grey.cols() as usize;
    let arm = now.arm.data_bytes()?;
    let mut votes = binary::empty(now.grey.rows(), now.grey.cols())?;
    for (position, vote) in votes.data_bytes_mut()?.iter_mut().enumerate() {
        let p = Pixel::new((position % cols) as f64, (position / cols) as f64);
        let near = || hand.tips.iter().any(|tip| tip.distance(p) < params.reach * hand.palm_width);
        if arm[position] != 0 || gain[position] < 4 || !near() {
            continue;
        }
        let (moved, expected) = (flow.vectors()[position], background.apply(p));
        let dx = f64::from(moved[0]) - (expected.x - p.x);
        let dy = f64::from(moved[1]) - (expected.y - p.y);
        let with_hand = (dx - hand.motion[0]).hypot(dy - hand.motion[1]) < 0.5 * speed + 0.7;
        if dx.hypot(dy) > (0.4 * speed).max(1.2) && with_hand {
            *vote = 255;
        }
    }
    let votes = binary::opened(&binary::closed(&votes, 2)?, 1)?;
    let (components, labels) = binary::components(&votes)?;
    let smallest = (0.06 * hand.palm_width * hand.palm_width).max(8.0);
    let Some(largest) =
        components.iter().filter(|c| f64::from(c.area) >= smallest).max_by_key(|c| (c.area, -c.label))
    else {
        return Ok(None);
    };
    let keep: Vec<bool> = (0..=components.len()).map(|label| label as i32 == largest.label).collect();
    let blob = binary::by_label(&votes, &labels, &keep)?;
    let relative = f64::from(largest.area) / (hand.palm_width * hand.palm_width);
    let score = (relative / 0.6).min(1.0) * (speed / 4.0).min(1.0);
    Ok(Some(Moment { index, blob, score, palm_width: hand.palm_width }))
}
