//! What moves with a hand between two near frames: flow minus the background's motion, outside the arms.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual},
    imgproc,
};

use super::{
    SelectError,
    scene::{Hand, Sample, Scene, sample},
};
use crate::{
    geometry::{Pixel, Side},
    landmarks::keypoint,
    vision::{BackgroundMotion, Flow, FlowQuality, background_motion_from, binary, box_blurred, dense_flow},
};

/// Frames between the two pictures of a moment.
const STRIDE: usize = 4;
/// How far from a fingertip a held thing may reach, palm widths.
const REACH: f64 = 3.0;
/// Least motion of the hand against the background, work pixels.
const LEAST: f64 = 1.5;
/// Grey levels by which the flow must explain a pixel better than the background's motion does: plain ground
/// beside a moving arm inherits the arm's flow.
const GAIN: i16 = 4;

/// A hand that moves, and what moves with it, on one frame.
pub(super) struct Moment {
    /// Index of the frame.
    pub index: usize,
    pub hand: Hand,
    /// Work pixels that tell something.
    pub seen: Vec<bool>,
    /// Those that move with the hand.
    pub moving: Vec<bool>,
    /// CV_8UC3, RGB.
    pub view: Mat,
}

/// Places that move with the hand, stay with the background, or tell nothing.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Motion {
    Unknown,
    Still,
    WithHand,
}

/// The moments of frame `index`, one a moving hand: against a frame before and a frame after it.
pub(super) fn moments(scene: &Scene<'_>, index: usize) -> Result<Vec<Moment>, SelectError> {
    let input = &scene.input;
    let others = [index.checked_sub(STRIDE), Some(index + STRIDE)];
    let others: Vec<usize> =
        others.into_iter().flatten().filter(|other| *other < input.frames.frame_count()).collect();
    let shared = |other: usize| {
        Side::BOTH
            .iter()
            .any(|side| input.landmarks[index][*side].is_some() && input.landmarks[other][*side].is_some())
    };
    if !others.iter().any(|other| shared(*other)) {
        return Ok(Vec::new());
    }
    let now = sample(input, index, &scene.scale)?;
    let mut found: Vec<Moment> = Vec::new();
    let mut motions: Vec<(Side, Vec<Motion>)> = Vec::new();
    for other in others {
        let then = sample(input, other, &scene.scale)?;
        let pair = Pair::new(&now, &then)?;
        for hand in &now.hands {
            let Some(later) = then.hands.iter().find(|later| later.side == hand.side) else { continue };
            motions.extend(pair.motions(hand, later)?.map(|motions| (hand.side, motions)));
        }
    }
    for hand in &now.hands {
        let of_hand: Vec<&Vec<Motion>> =
            motions.iter().filter(|(side, _)| *side == hand.side).map(|m| &m.1).collect();
        let Some(first) = of_hand.first() else { continue };
        let all = |at: usize| of_hand.iter().map(move |motions| motions[at]);
        let seen = (0..first.len()).map(|at| all(at).any(|m| m != Motion::Unknown)).collect();
        let moving = (0..first.len())
            .map(|at| all(at).any(|m| m == Motion::WithHand) && all(at).all(|m| m != Motion::Still))
            .collect();
        let view = now.view.colour.try_clone()?;
        found.push(Moment { index, hand: hand.clone(), seen, moving, view });
    }
    Ok(found)
}

/// Two near frames, how the background moved between them and how everything else did.
struct Pair<'a> {
    now: &'a Sample,
    background: BackgroundMotion,
    flow: Flow,
    /// By how many grey levels the flow explains each pixel better than the background's motion does.
    gain: Vec<i16>,
    /// Whether the background's motion leads to a place that both frames show.
    open: Vec<bool>,
}

impl<'a> Pair<'a> {
    fn new(now: &'a Sample, then: &Sample) -> opencv::Result<Self> {
        let (before, after) = (&now.view.gray, &then.view.gray);
        let background =
            background_motion_from(before, after, Some(&now.arm), 300)?.unwrap_or(BackgroundMotion::still());
        let flow = dense_flow(before, after, FlowQuality::Medium)?;
        let by_flow = flow.pull(after)?;
        let warped = |picture: &Mat, border: i32| -> opencv::Result<Mat> {
            let mut out = Mat::default();
            let flags = imgproc::INTER_LINEAR | imgproc::WARP_INVERSE_MAP;
            let none = opencv::core::Scalar::all(0.0);
            imgproc::warp_perspective(
                picture,
                &mut out,
                &background.to_mat()?,
                before.size()?,
                flags,
                border,
                none,
            )?;
            Ok(out)
        };
        let by_background = warped(after, opencv::core::BORDER_REPLICATE)?;
        let errors = |predicted: &Mat| -> opencv::Result<Mat> {
            let mut error = Mat::default();
            opencv::core::absdiff(before, predicted, &mut error)?;
            box_blurred(&error, 3)
        };
        let (flow_error, background_error) = (errors(&by_flow)?, errors(&by_background)?);
        let pairs = background_error.data_bytes()?.iter().zip(flow_error.data_bytes()?);
        let gain = pairs.map(|(background, flow)| i16::from(*background) - i16::from(*flow)).collect();
        // Ground that the arm covers or bares in between tells nothing.
        let free = |sample: &Sample| binary::eroded(&sample.view.valid, 2);
        let (mine, theirs) = (free(now)?, warped(&free(then)?, opencv::core::BORDER_CONSTANT)?);
        let open =
            mine.data_bytes()?.iter().zip(theirs.data_bytes()?).map(|(a, b)| *a != 0 && *b > 250).collect();
        Ok(Self { now, background, flow, gain, open })
    }

    /// How each place moves against `hand`, which is at `later` on the other frame; `None` when the hand rests
    /// or jumps.
    fn motions(&self, hand: &Hand, later: &Hand) -> opencv::Result<Option<Vec<Motion>>> {
        let (mut x, mut y) = (0.0, 0.0);
        for (from, to) in hand.keypoints.iter().zip(&later.keypoints) {
            let expected = self.background.apply(*from);
            x += (to.x - expected.x) / hand.keypoints.len() as f64;
            y += (to.y - expected.y) / hand.keypoints.len() as f64;
        }
        let speed = x.hypot(y);
        if speed < LEAST || speed > 2.0 * hand.palm_width {
            return Ok(None);
        }
        let tips: Vec<Pixel> = keypoint::TIPS.iter().map(|k| hand.keypoints[*k]).collect();
        let columns = self.now.view.gray.cols() as usize;
        let motion = |at: usize| {
            if !self.open[at] {
                return Motion::Unknown;
            }
            let p = Pixel::new((at % columns) as f64, (at / columns) as f64);
            if self.gain[at] < GAIN || !tips.iter().any(|tip| tip.distance(p) < REACH * hand.palm_width) {
                return Motion::Still;
            }
            let (moved, expected) = (self.flow.vectors()[at], self.background.apply(p));
            let (dx, dy) =
                (f64::from(moved[0]) - (expected.x - p.x), f64::from(moved[1]) - (expected.y - p.y));
            let along = dx.hypot(dy) > (0.4 * speed).max(1.2) && (dx - x).hypot(dy - y) < 0.6 * speed + 0.7;
            if along { Motion::WithHand } else { Motion::Still }
        };
        Ok(Some((0..self.open.len()).map(motion).collect()))
    }
}
