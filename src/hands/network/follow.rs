//! Whose hand a box is: boxes followed over time and given to a side.

use super::boxes::HandBox;
use crate::{
    geometry::{PerSide, Pixel, PixelBox, Size},
    hands::{detection::Detection, outliers::remove_jumps, sides::assign, tracklet::link},
};

/// One side's box and the trust in it, frame by frame.
pub(super) type SideBoxes = Vec<Option<(PixelBox, f64)>>;

/// The boxes of each side. A hand keeps the side that it has most of the time, whatever the detector calls it on a single
/// frame; two hands seen together are a left and a right one; a box that jumps away and back is dropped.
pub(super) fn by_side(found: Vec<Vec<HandBox>>, size: Size) -> PerSide<SideBoxes> {
    let count = found.len();
    let detections = found.iter().map(|hands| hands.iter().map(detection).collect()).collect();
    let mut sides = assign(link(detections), count, size);
    PerSide::from_fn(|side| {
        remove_jumps(&mut sides[side]);
        let boxes = sides[side].iter().map(|hand| hand.as_ref().map(|hand| (hand.bounds(), hand.score)));
        boxes.collect()
    })
}

/// A box as a hand that shows nothing of its fingers: all that tells its side is the detector's word.
fn detection(hand: &HandBox) -> Detection {
    let b = hand.bounds;
    let corners = [(b.x0, b.y0), (b.x1, b.y0), (b.x1, b.y1), (b.x0, b.y1)];
    let centre = b.centre();
    let keypoints = std::array::from_fn(|k| match k {
        // Wrist and knuckle at one place: no direction.
        0 | 9 => centre,
        _ => {
            let (x, y) = corners[k % 4];
            Pixel::new(x, y)
        }
    });
    Detection { side: hand.side, score: hand.score, keypoints, world: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Side;

    fn hand(side: Side, score: f64, x: f64) -> HandBox {
        HandBox { side, score, bounds: PixelBox { x0: x, y0: 100.0, x1: x + 90.0, y1: 200.0 } }
    }

    #[test]
    fn a_hand_that_is_called_by_the_other_name_on_single_frames_keeps_its_side() {
        let frames = (0..40)
            .map(|t| {
                let swapped = t % 7 == 3;
                let of = |side: Side| if swapped { side.other() } else { side };
                let x = f64::from(t);
                vec![hand(of(Side::Right), 0.9, 400.0 - x), hand(of(Side::Left), 0.8, 80.0 + x)]
            })
            .collect();
        let sides = by_side(frames, Size::new(640, 480));
        for t in 0..40 {
            let (right, left) = (sides.right[t].unwrap().0, sides.left[t].unwrap().0);
            assert!(
                (right.x0 - (400.0 - t as f64)).abs() < 1e-9 && (left.x0 - (80.0 + t as f64)).abs() < 1e-9
            );
        }
    }

    #[test]
    fn a_box_elsewhere_for_a_moment_is_dropped() {
        let frames =
            (0..40).map(|t| vec![hand(Side::Right, 0.9, if t == 20 { 20.0 } else { 400.0 })]).collect();
        let sides = by_side(frames, Size::new(640, 480));
        assert!(sides.right[20].is_none() && sides.left.iter().all(Option::is_none));
        assert_eq!(sides.right.iter().flatten().count(), 39);
    }
}
