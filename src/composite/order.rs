//! Which of hand and object lies in front, per side and frame.

use opencv::{
    core::{CV_8UC1, Mat, Point, Scalar, Vector},
    imgproc,
};
use serde::{Deserialize, Serialize};

pub use super::decision::LayerDecision;
use crate::{
    clip::FrameIndex,
    geometry::{PerSide, Pixel, Side},
    image::Mask,
    landmarks::{KEYPOINT_COUNT, keypoint},
    session::{LayerOrder, LayerOrderRange},
};

/// What the source frame says about one hand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SideEvidence {
    /// Pixels of the object's full shape on which the hand is seen.
    pub hand_over_object: f64,
    /// Pixels of the hand's region on which the object is seen.
    pub object_over_hand: f64,
    /// Whether the hand touches the object, where that is known.
    pub contact: Option<bool>,
}

/// How the order follows the evidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OrderParams {
    /// Frames on either side over which evidence is gathered (default: 4).
    pub window: usize,
    /// Share of hand-over-object evidence above which the robot comes to the front (default: 0.6).
    pub to_front: f64,
    /// Share below which it goes behind the object (default: 0.4).
    pub to_back: f64,
    /// Pixels of evidence in the window below which the last order holds (default: 60).
    pub least_pixels: f64,
    /// Frames over which a change fades (default: 3).
    pub fade: usize,
}

impl Default for OrderParams {
    fn default() -> Self {
        Self { window: 4, to_front: 0.6, to_back: 0.4, least_pixels: 60.0, fade: 3 }
    }
}

/// Looks at one frame: `arm` is that side's visible mask, `visible` the object's visible mask,
/// `shape` the object's full shape (see [`super::placed_shape`]), `hand` the side's keypoints in pixels.
///
/// # Errors
/// When OpenCV fails.
pub fn evidence(
    arm: &Mask,
    visible: &Mask,
    shape: &Mask,
    hand: Option<&[Pixel; KEYPOINT_COUNT]>,
    contact: Option<bool>,
) -> opencv::Result<SideEvidence> {
    let Some(hand) = hand else {
        let hand_over_object = arm.intersection_area(shape) as f64;
        return Ok(SideEvidence { hand_over_object, object_over_hand: 0.0, contact });
    };
    let region = hand_region(hand, arm)?;
    let hand_over_object = region.intersection(arm).intersection_area(shape) as f64;
    let object_over_hand = region.minus(arm).intersection_area(visible) as f64;
    Ok(SideEvidence { hand_over_object, object_over_hand, contact })
}

/// Where a hand is, hidden or not: palm and bones, a fifth of the palm's width thick.
fn hand_region(hand: &[Pixel; KEYPOINT_COUNT], like: &Mask) -> opencv::Result<Mask> {
    let (rows, cols) = (like.size().height as i32, like.size().width as i32);
    let white = Scalar::all(255.0);
    let mut region = Mat::new_rows_cols_with_default(rows, cols, CV_8UC1, Scalar::all(0.0))?;
    let limit = 4.0 * like.size().diagonal();
    let point = |p: Pixel| {
        let finite = |v: f64| if v.is_finite() { v.clamp(-limit, limit).round() as i32 } else { 0 };
        Point::new(finite(p.x), finite(p.y))
    };
    let palm: Vector<Point> = [0, 1, 5, 9, 13, 17].into_iter().map(|i| point(hand[i])).collect();
    imgproc::fill_poly_def(&mut region, &palm, white)?;
    let palm_width = hand[5].distance(hand[17]);
    let thickness = if palm_width.is_finite() { (0.22 * palm_width).clamp(2.0, 60.0) as i32 } else { 2 };
    for (child, parent) in keypoint::PARENT.into_iter().enumerate().skip(1) {
        let (from, to) = (point(hand[parent]), point(hand[child]));
        imgproc::line(&mut region, from, to, white, thickness, imgproc::LINE_8, 0)?;
    }
    Mask::from_mat(&region)
}

/// The order on every frame of a clip, from the evidence on every frame.
///
/// Evidence is gathered over a window with triangular weights; a state changes only beyond
/// `to_front` or `to_back` and otherwise holds (hysteresis). Frames before the first evidence take its
/// state; without any evidence the robot is in front, as a hand above a table is. The near parts are
/// drawn over the object where the rest of the hand is behind, unless the hand is known not to
/// touch it. `forced` ranges win, later ones over earlier ones.
pub fn decide(
    evidence: &[PerSide<SideEvidence>],
    forced: &[LayerOrderRange],
    params: &OrderParams,
) -> Vec<LayerDecision> {
    let mut decisions = vec![LayerDecision::default(); evidence.len()];
    for side in Side::BOTH {
        let series: Vec<SideEvidence> = evidence.iter().map(|frame| frame[side]).collect();
        let front = front_states(&series, params);
        let near: Vec<bool> =
            front.iter().zip(&series).map(|(front, e)| !front && e.contact != Some(false)).collect();
        let (front, near) = (faded(&front, params.fade), faded(&near, params.fade));
        for (i, decision) in decisions.iter_mut().enumerate() {
            (decision.in_front[side], decision.near[side]) = (front[i], near[i]);
        }
    }
    for (i, decision) in decisions.iter_mut().enumerate() {
        for range in forced.iter().filter(|r| (r.first..=r.last).contains(&FrameIndex(i as u32))) {
            force(decision, range);
        }
    }
    decisions
}

fn force(decision: &mut LayerDecision, range: &LayerOrderRange) {
    for side in Side::BOTH {
        match range.order {
            LayerOrder::Auto => {}
            LayerOrder::RobotInFront => decision.in_front[side] = 1.0,
            LayerOrder::ObjectInFront => {
                (decision.in_front[side], decision.near[side]) = (0.0, 1.0);
            }
        }
        if let Some(thumb) = range.thumb {
            decision.near[side] = if thumb { 1.0 } else { 0.0 };
        }
    }
}

fn front_states(series: &[SideEvidence], params: &OrderParams) -> Vec<bool> {
    let reach = params.window as isize;
    let mut states: Vec<Option<bool>> = Vec::with_capacity(series.len());
    let mut state = None;
    for centre in 0..series.len() as isize {
        let (mut hand, mut object) = (0.0, 0.0);
        for offset in -reach..=reach {
            let at = usize::try_from(centre + offset).ok().and_then(|at| series.get(at));
            if let Some(e) = at {
                let weight = 1.0 - offset.unsigned_abs() as f64 / (reach + 1) as f64;
                hand += weight * e.hand_over_object;
                object += weight * e.object_over_hand;
            }
        }
        if hand + object >= params.least_pixels {
            let share = hand / (hand + object);
            if share >= params.to_front {
                state = Some(true);
            } else if share <= params.to_back {
                state = Some(false);
            } else if state.is_none() {
                state = Some(share >= 0.5);
            }
        }
        states.push(state);
    }
    let first = states.iter().flatten().next().copied().unwrap_or(true);
    states.into_iter().map(|state| state.unwrap_or(first)).collect()
}

/// 0 or 1, with ramps of `fade` frames centred on each change.
fn faded(states: &[bool], fade: usize) -> Vec<f32> {
    let reach = (fade / 2) as isize;
    let last = states.len() as isize - 1;
    let value = |at: isize| if states[at.clamp(0, last) as usize] { 1.0_f32 } else { 0.0 };
    (0..states.len() as isize)
        .map(|centre| {
            let sum: f32 = (-reach..=reach).map(|offset| value(centre + offset)).sum();
            sum / (2 * reach + 1) as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Size;

    fn frame(hand: f64, object: f64) -> PerSide<SideEvidence> {
        let right = SideEvidence { hand_over_object: hand, object_over_hand: object, contact: None };
        PerSide { left: SideEvidence::default(), right }
    }

    #[test]
    fn a_flickering_minority_of_frames_does_not_flip_the_order() {
        let mut frames = vec![frame(400.0, 20.0); 30];
        frames[12] = frame(10.0, 300.0);
        let decisions = decide(&frames, &[], &OrderParams::default());
        assert!(decisions.iter().all(|d| d.in_front.right == 1.0));
    }

    #[test]
    fn the_order_follows_a_lasting_change_and_the_thumb_comes_over_the_object() {
        let mut frames = vec![frame(400.0, 20.0); 20];
        frames.extend(vec![frame(50.0, 600.0); 20]);
        let decisions = decide(&frames, &[], &OrderParams::default());
        assert_eq!((decisions[5].in_front.right, decisions[5].near.right), (1.0, 0.0));
        assert_eq!((decisions[35].in_front.right, decisions[35].near.right), (0.0, 1.0));
    }

    #[test]
    fn the_operator_wins_over_a_range() {
        let range = LayerOrderRange {
            first: FrameIndex(3),
            last: FrameIndex(5),
            order: LayerOrder::ObjectInFront,
            thumb: Some(false),
        };
        let decisions = decide(&vec![frame(400.0, 0.0); 10], &[range], &OrderParams::default());
        assert_eq!((decisions[4].in_front.right, decisions[4].near.right), (0.0, 0.0));
        assert_eq!(decisions[6].in_front.right, 1.0);
    }

    #[test]
    fn an_object_seen_inside_the_palm_lies_in_front_of_the_hand() {
        let size = Size::new(120, 100);
        let mut hand = [Pixel::new(60.0, 90.0); KEYPOINT_COUNT];
        for (finger, base) in keypoint::BASES.into_iter().enumerate() {
            for joint in 0..4 {
                hand[base + joint] = Pixel::new(30.0 + 15.0 * finger as f64, 60.0 - 12.0 * joint as f64);
            }
        }
        let object = Mask::from_fn(size, |x, y| (35..85).contains(&x) && (50..85).contains(&y));
        let arm = Mask::from_fn(size, |x, y| (25..95).contains(&x) && y > 10).minus(&object);
        let found = evidence(&arm, &object, &object, Some(&hand), None).unwrap();
        assert!(found.object_over_hand > 200.0 && found.hand_over_object == 0.0, "{found:?}");
    }
}
