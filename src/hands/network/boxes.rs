//! What a detector returns, as boxes of hands.

use crate::geometry::{PixelBox, Side};

/// Boxes of both sides that overlap more than this are one hand under two names.
const ONE_HAND: f64 = 0.7;
/// Hands a picture that are looked at: two, and what may turn out not to be one.
const MOST: usize = 4;

/// A hand as the detector sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandBox {
    /// The side it is taken for.
    pub side: Side,
    /// Trust, 0 to 1.
    pub score: f64,
    /// Around the hand, pixels.
    pub bounds: PixelBox,
}

/// The boxes in a detector's output that are trusted by at least `confidence`, the surest first.
///
/// Three layouts: `[1, 6, A]` and `[1, 69, A]` have a column a candidate with centre and size of its box, trust in a left
/// and in a right hand (and keypoints, which are not read: the regressor knows them better); `[1, K, 6]` a row a hand
/// with its box's corners, trust and side.
///
/// # Errors
/// Another layout, or fewer numbers than it says.
pub fn hands_in(values: &[f32], shape: &[usize], confidence: f64) -> Result<Vec<HandBox>, String> {
    let found: Vec<HandBox> = match *shape {
        [1, rows @ (6 | 69), count] if values.len() >= rows * count => {
            (0..count).map(|at| column(|row| f64::from(values[row * count + at]))).collect()
        }
        [1, count, 6] if values.len() >= 6 * count => values.chunks_exact(6).take(count).map(row).collect(),
        _ => return Err(format!("`output0` is {shape:?}, [1, 69, A], [1, 6, A] or [1, K, 6] expected")),
    };
    let usable = |hand: &HandBox| {
        let b = hand.bounds;
        let finite = [b.x0, b.y0, b.x1, b.y1].iter().all(|value| value.is_finite());
        hand.score >= confidence && hand.score <= 1.0 && finite && b.x1 > b.x0 && b.y1 > b.y0
    };
    let mut hands: Vec<HandBox> = found.into_iter().filter(usable).collect();
    hands.sort_by(|a, b| b.score.total_cmp(&a.score));
    Ok(hands)
}

fn column(value: impl Fn(usize) -> f64) -> HandBox {
    let (x, y, half_width, half_height) = (value(0), value(1), 0.5 * value(2), 0.5 * value(3));
    let (left, right) = (value(4), value(5));
    let side = if left > right { Side::Left } else { Side::Right };
    let bounds =
        PixelBox { x0: x - half_width, y0: y - half_height, x1: x + half_width, y1: y + half_height };
    HandBox { side, score: left.max(right), bounds }
}

fn row(values: &[f32]) -> HandBox {
    let [x0, y0, x1, y1, score, class] = std::array::from_fn(|at| f64::from(values[at]));
    let side = if class < 0.5 { Side::Left } else { Side::Right };
    HandBox { side, score, bounds: PixelBox { x0, y0, x1, y1 } }
}

/// `hands`, the surest first, without those that overlap a surer one: of the same side by more than `overlap`, of the
/// other by so much that it must be the same hand. At most four.
pub fn without_doubles(hands: Vec<HandBox>, overlap: f64) -> Vec<HandBox> {
    let mut kept: Vec<HandBox> = Vec::new();
    for hand in hands {
        let is_double = |known: &HandBox| {
            let limit = if known.side == hand.side { overlap } else { ONE_HAND.max(overlap) };
            shared(&known.bounds, &hand.bounds) > limit
        };
        if kept.len() < MOST && !kept.iter().any(is_double) {
            kept.push(hand);
        }
    }
    kept
}

/// Intersection over union.
fn shared(a: &PixelBox, b: &PixelBox) -> f64 {
    let width = (a.x1.min(b.x1) - a.x0.max(b.x0)).max(0.0);
    let height = (a.y1.min(b.y1) - a.y0.max(b.y0)).max(0.0);
    let both = width * height;
    let either = a.width() * a.height() + b.width() * b.height() - both;
    if either > 0.0 { both / either } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hand(side: Side, score: f64, x0: f64) -> HandBox {
        HandBox { side, score, bounds: PixelBox { x0, y0: 0.0, x1: x0 + 100.0, y1: 100.0 } }
    }

    #[test]
    fn columns_hold_centres_and_a_trust_for_each_side() {
        let mut values = vec![0.0; 69 * 2];
        for (row, value) in [50.0, 60.0, 20.0, 40.0, 0.1, 0.8].into_iter().enumerate() {
            values[row * 2 + 1] = value;
        }
        let expected = HandBox {
            side: Side::Right,
            score: f64::from(0.8_f32),
            bounds: PixelBox { x0: 40.0, y0: 40.0, x1: 60.0, y1: 80.0 },
        };
        assert_eq!(hands_in(&values, &[1, 69, 2], 0.3), Ok(vec![expected]));
        // Boxes alone are laid out the same way.
        assert_eq!(hands_in(&values[..12], &[1, 6, 2], 0.3), Ok(vec![expected]));
        assert_eq!(hands_in(&values, &[1, 69, 2], 0.9), Ok(vec![]));
    }

    #[test]
    fn rows_hold_corners_trust_and_side() {
        let values = [1.0, 2.0, 3.0, 4.0, 0.5, 0.0, 5.0, 6.0, 9.0, 9.0, 0.75, 1.0];
        let hands = hands_in(&values, &[1, 2, 6], 0.3).expect("hands");
        assert_eq!(hands.iter().map(|hand| hand.side).collect::<Vec<_>>(), [Side::Right, Side::Left]);
        assert_eq!(hands[1].bounds, PixelBox { x0: 1.0, y0: 2.0, x1: 3.0, y1: 4.0 });
        assert!(hands_in(&values, &[1, 2, 7], 0.3).is_err());
        assert!(hands_in(&values, &[1, 69, 2], 0.3).is_err());
    }

    #[test]
    fn numbers_that_are_no_box_are_left_out() {
        let values = [f32::NAN, 2.0, 3.0, 4.0, 0.5, 0.0, 5.0, 6.0, 4.0, 9.0, 0.75, 1.0];
        assert_eq!(hands_in(&values, &[1, 2, 6], 0.3), Ok(vec![]));
    }

    #[test]
    fn of_boxes_that_overlap_the_surest_of_each_hand_stays() {
        // 100 pixels wide, moved by 20: 80 of 120 are shared, two thirds.
        let same = vec![hand(Side::Right, 0.9, 0.0), hand(Side::Right, 0.8, 20.0)];
        assert_eq!(without_doubles(same.clone(), 0.5), &same[..1]);
        assert_eq!(without_doubles(same, 0.7).len(), 2);
        // Two hands may lie over each other; one hand under two names lies nearly at one place.
        let crossed = vec![hand(Side::Right, 0.9, 0.0), hand(Side::Left, 0.8, 20.0)];
        assert_eq!(without_doubles(crossed, 0.5).len(), 2);
        let renamed = vec![hand(Side::Right, 0.9, 0.0), hand(Side::Left, 0.8, 10.0)];
        assert_eq!(without_doubles(renamed, 0.5).len(), 1);
    }
}
