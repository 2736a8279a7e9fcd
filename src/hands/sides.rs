//! Whose hand is it: tracklets to left and right.

use super::{
    detection::{Detection, distance},
    tracklet::Tracklet,
};
use crate::{
    geometry::{PerSide, Side, Size},
    landmarks::LandmarkTrack,
};

/// One hand's detections by frame.
pub(super) type SideDetections = Vec<Option<Detection>>;

/// What later stages see of the hands of both sides, frame by frame.
pub(super) fn landmarks_of(sides: PerSide<SideDetections>) -> LandmarkTrack {
    let pairs = sides.left.into_iter().zip(sides.right);
    pairs
        .map(|(left, right)| PerSide {
            left: left.map(Detection::into_landmarks),
            right: right.map(Detection::into_landmarks),
        })
        .collect()
}

/// A tracklet with fewer detections than this needs to be sure of itself.
const SHORT: usize = 4;
const SURE: f64 = 0.85;
/// Detections below which a hand is seen for a moment only …
const PASSING: usize = 10;
/// … if nothing else of its side is seen for so many frames before and after.
const ALONE: usize = 30;
/// Share of a tracklet that may collide with another one of the same side.
const TOLERATED_OVERLAP: f64 = 0.25;
/// Evidence a detection, beyond which a much smaller hand is not moved to the other side.
const STUBBORN: f64 = 0.6;
/// Share of the other hand's size and score above which two hands of one label are taken for a pair.
const PAIR: f64 = 0.4;
/// A hand seen again within so many frames …
const SOON: usize = 12;
/// … no farther away than this, in hand extents, is the same hand, whatever it is called now.
const NEARBY: f64 = 0.8;
/// Detections and evidence a detection from which a tracklet is not talked out of its side.
const LONG: usize = 15;
const CERTAIN: f64 = 0.35;

/// A tracklet with its side.
struct Placed {
    side: Side,
    evidence: f64,
    tracklet: Tracklet,
}

/// Gives every tracklet to a side, or to nobody, longest and surest first, so that no frame has two
/// hands of one side.
///
/// Two hands seen together are a left and a right one. Where the estimator calls both the same, the one
/// with less evidence for it takes the other side, even if it was placed first.
pub(super) fn assign(tracklets: Vec<Tracklet>, frames: usize, size: Size) -> PerSide<SideDetections> {
    let mut ranked: Vec<(f64, Tracklet)> =
        joined(tracklets, size).into_iter().filter(is_credible).map(|t| (weight(&t), t)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.entries[0].0.cmp(&b.1.entries[0].0)));
    let mut placed: Vec<Placed> = Vec::new();
    for (_, tracklet) in ranked {
        let evidence = evidence_for_right(&tracklet, size);
        let preferred = if evidence >= 0.0 { Side::Right } else { Side::Left };
        if is_free(&placed, &tracklet, preferred, None) {
            placed.push(Placed { side: preferred, evidence, tracklet });
        } else if is_free(&placed, &tracklet, preferred.other(), None) {
            let rival = rival(&placed, &tracklet, preferred);
            let pair =
                rival.is_some_and(|at| mean_weight(&tracklet) > PAIR * mean_weight(&placed[at].tracklet));
            let yields = rival.filter(|&at| {
                let weaker = placed[at].evidence.abs() < evidence.abs();
                pair && weaker && is_free(&placed, &placed[at].tracklet, preferred.other(), Some(at))
            });
            if let Some(at) = yields {
                placed[at].side = preferred.other();
                placed.push(Placed { side: preferred, evidence, tracklet });
            } else if pair || evidence.abs() < STUBBORN {
                placed.push(Placed { side: preferred.other(), evidence, tracklet });
            }
        }
    }
    filled(without_passing(placed, frames), frames)
}

/// Without what is seen for a moment, and nothing else of its side for long before and after: of a third of a second
/// nobody learns anything, and most such hands are none (a sleeve, the other hand seen as a second one).
fn without_passing(placed: Vec<Placed>, frames: usize) -> Vec<Placed> {
    let span = |placed: &Placed| {
        let entries = &placed.tracklet.entries;
        (entries[0].0, entries[entries.len() - 1].0)
    };
    let is_passing = |at: usize| {
        let (start, end) = span(&placed[at]);
        let has_company = placed.iter().enumerate().any(|(other, near)| {
            let (first, last) = span(near);
            other != at && near.side == placed[at].side && first <= end + ALONE && start <= last + ALONE
        });
        placed[at].tracklet.entries.len() < PASSING && !has_company
    };
    if frames < 2 * ALONE {
        return placed;
    }
    let passing: Vec<bool> = (0..placed.len()).map(is_passing).collect();
    placed.into_iter().zip(passing).filter(|(_, passing)| !passing).map(|(placed, _)| placed).collect()
}

/// Tracklets that go on with one another made one: a hand that was out of sight for a moment stays the same hand,
/// even where the estimator mistakes it for the other one, and all of it tells its side.
///
/// Two long ones that are both sure of opposite sides are two hands.
fn joined(mut tracklets: Vec<Tracklet>, size: Size) -> Vec<Tracklet> {
    tracklets.sort_by_key(|tracklet| tracklet.entries[0].0);
    let mut hands: Vec<Tracklet> = Vec::new();
    for tracklet in tracklets {
        let goes_on = |hand: &Tracklet| {
            let (end, start) = (hand.entries.last()?, tracklet.entries.first()?);
            let soon = start.0 > end.0 && start.0 - end.0 <= SOON;
            let distance = distance(&end.1.keypoints, &start.1.keypoints);
            (soon && distance < NEARBY && !contradict(hand, &tracklet, size)).then_some(distance)
        };
        let nearest = hands.iter().enumerate().filter_map(|(at, hand)| Some((goes_on(hand)?, at)));
        match nearest.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((_, at)) => hands[at].entries.extend(tracklet.entries),
            None => hands.push(tracklet),
        }
    }
    hands
}

fn contradict(a: &Tracklet, b: &Tracklet, size: Size) -> bool {
    let (on_a, on_b) = (evidence_for_right(a, size), evidence_for_right(b, size));
    let long = a.entries.len().min(b.entries.len()) >= LONG;
    long && on_a * on_b < 0.0 && on_a.abs().min(on_b.abs()) > CERTAIN
}

/// Whether `side` has room for `tracklet`, not counting the one placed at `except`.
fn is_free(placed: &[Placed], tracklet: &Tracklet, side: Side, except: Option<usize>) -> bool {
    let others = placed.iter().enumerate().filter(|(at, p)| p.side == side && Some(*at) != except);
    let hits: usize = others.map(|(_, p)| shared_frames(&p.tracklet, tracklet)).sum();
    hits as f64 <= TOLERATED_OVERLAP * tracklet.entries.len() as f64
}

/// The tracklet on `side` that shares most frames with `tracklet`.
fn rival(placed: &[Placed], tracklet: &Tracklet, side: Side) -> Option<usize> {
    let rivals = placed.iter().enumerate().filter(|(_, p)| p.side == side);
    rivals.max_by_key(|(_, p)| shared_frames(&p.tracklet, tracklet)).map(|(at, _)| at)
}

fn shared_frames(a: &Tracklet, b: &Tracklet) -> usize {
    b.entries.iter().filter(|(frame, _)| a.entries.binary_search_by_key(frame, |(f, _)| *f).is_ok()).count()
}

fn filled(placed: Vec<Placed>, frames: usize) -> PerSide<SideDetections> {
    let mut sides = PerSide::from_fn(|_| vec![None; frames]);
    for Placed { side, tracklet, .. } in placed {
        for (frame, detection) in tracklet.entries {
            let slot: &mut Option<Detection> = &mut sides[side][frame];
            if slot.is_none() {
                *slot = Some(detection);
            }
        }
    }
    sides
}

fn mean_weight(tracklet: &Tracklet) -> f64 {
    weight(tracklet) / tracklet.entries.len() as f64
}

fn mean_score(tracklet: &Tracklet) -> f64 {
    tracklet.entries.iter().map(|(_, d)| d.score).sum::<f64>() / tracklet.entries.len() as f64
}

fn is_credible(tracklet: &Tracklet) -> bool {
    tracklet.entries.len() >= SHORT || mean_score(tracklet) > SURE
}

/// Long, sure, large (near) hands come first: bystanders' hands are smaller or seen more briefly.
fn weight(tracklet: &Tracklet) -> f64 {
    tracklet.entries.iter().map(|(_, d)| d.score * d.extent()).sum()
}

/// Mean evidence a detection: positive for a right hand, negative for a left one, about −1 to 1.
///
/// The estimator's label leads where it is sure. Where it wavers, the picture decides: in first-person video
/// an arm comes from below, the right one from the right of its hand, which is mostly on the right itself.
/// Where arms come from above, the person faces the camera and it is the other way round.
fn evidence_for_right(tracklet: &Tracklet, size: Size) -> f64 {
    let half = 0.5 * f64::from(size.width);
    let total: f64 = tracklet
        .entries
        .iter()
        .map(|(_, d)| {
            let label = 2.0 * (d.score - 0.5).max(0.05) * if d.side == Side::Right { 1.0 } else { -1.0 };
            let place = ((d.bounds().centre().x - half) / half).clamp(-1.0, 1.0);
            let [wrist, knuckle] = [d.keypoints[0], d.keypoints[9]];
            let length = wrist.distance(knuckle).max(1.0);
            let from_below = (3.0 * (wrist.y - knuckle.y) / length).clamp(-1.0, 1.0);
            let from_right = (wrist.x - knuckle.x) / length;
            // A wavering label says little, a sure one much.
            0.45 * label * label.abs().sqrt() + from_below * (0.24 * place + 0.36 * from_right)
        })
        .sum();
    total / tracklet.entries.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pixel;

    fn tracklet(frames: std::ops::Range<usize>, x: f64, side: Side, score: f64) -> Tracklet {
        let keypoints =
            std::array::from_fn(|k| Pixel::new(x + 6.0 * (k % 5) as f64, 300.0 - 60.0 * (k / 5) as f64));
        let detection = Detection { side, score, keypoints, world: None };
        Tracklet { entries: frames.map(|f| (f, detection.clone())).collect() }
    }

    #[test]
    fn a_second_hand_with_the_same_label_goes_to_the_free_side() {
        let tracklets =
            vec![tracklet(0..30, 450.0, Side::Right, 0.95), tracklet(0..30, 100.0, Side::Right, 0.6)];
        let sides = assign(tracklets, 30, Size::new(640, 480));
        assert!(sides.right.iter().flatten().all(|d| d.keypoints[0].x > 400.0));
        assert!(sides.left.iter().flatten().count() == 30);
    }

    #[test]
    fn of_two_hands_with_one_sure_label_the_less_likely_one_changes_sides() {
        // Both are called left; the one on the right of the picture was seen longer and placed first.
        let tracklets =
            vec![tracklet(0..40, 450.0, Side::Left, 0.95), tracklet(10..40, 100.0, Side::Left, 0.95)];
        let sides = assign(tracklets, 40, Size::new(640, 480));
        assert!(sides.right.iter().flatten().all(|d| d.keypoints[0].x > 400.0));
        assert_eq!(sides.right.iter().flatten().count(), 40);
        assert_eq!(sides.left.iter().flatten().count(), 30);
    }

    #[test]
    fn a_third_hand_belongs_to_nobody() {
        let tracklets = vec![
            tracklet(0..30, 450.0, Side::Right, 0.95),
            tracklet(0..30, 100.0, Side::Left, 0.95),
            tracklet(5..15, 300.0, Side::Left, 0.7),
        ];
        let sides = assign(tracklets, 30, Size::new(640, 480));
        let xs = sides.iter().flat_map(|(_, s)| s.iter().flatten().map(|d| d.keypoints[0].x));
        assert!(xs.into_iter().all(|x| x != 300.0));
    }

    #[test]
    fn a_second_hand_seen_for_a_moment_is_none_and_one_that_flickers_stays() {
        let steady = || tracklet(0..120, 450.0, Side::Right, 0.95);
        let passing = tracklet(57..63, 100.0, Side::Left, 0.95);
        let sides = assign(vec![steady(), passing.clone()], 120, Size::new(640, 480));
        assert_eq!(sides.left.iter().flatten().count(), 0);
        assert_eq!(sides.right.iter().flatten().count(), 120);
        let again = tracklet(80..86, 150.0, Side::Left, 0.95);
        let sides = assign(vec![steady(), passing, again], 120, Size::new(640, 480));
        assert_eq!(sides.left.iter().flatten().count(), 12);
    }

    #[test]
    fn an_arm_from_the_lower_left_outweighs_a_wavering_label() {
        // Wrist below and left of the knuckles, on the left of the picture, called right with little trust.
        let mut one = tracklet(0..30, 100.0, Side::Right, 0.7);
        for (_, detection) in &mut one.entries {
            detection.keypoints[0] = Pixel::new(80.0, 300.0);
            detection.keypoints[9] = Pixel::new(150.0, 230.0);
        }
        let sides = assign(vec![one.clone()], 30, Size::new(640, 480));
        assert_eq!(sides.left.iter().flatten().count(), 30);
        for (_, detection) in &mut one.entries {
            detection.score = 0.98;
        }
        let sides = assign(vec![one], 30, Size::new(640, 480));
        assert_eq!(sides.right.iter().flatten().count(), 30);
    }

    #[test]
    fn a_hand_lost_for_a_moment_stays_itself_under_another_name() {
        let tracklets = vec![
            tracklet(0..30, 450.0, Side::Right, 0.95),
            tracklet(36..44, 460.0, Side::Left, 0.98),
            tracklet(50..70, 470.0, Side::Right, 0.95),
        ];
        let sides = assign(tracklets, 70, Size::new(640, 480));
        assert_eq!(sides.right.iter().flatten().count(), 58);
        assert!(sides.left.iter().all(Option::is_none));
    }

    #[test]
    fn wavering_labels_within_a_tracklet_do_not_swap_sides() {
        let mut one = tracklet(0..30, 450.0, Side::Right, 0.9);
        for (frame, detection) in &mut one.entries {
            if *frame % 4 == 0 {
                detection.side = Side::Left;
            }
        }
        let sides = assign(vec![one], 30, Size::new(640, 480));
        assert_eq!(sides.right.iter().flatten().count(), 30);
    }
}
