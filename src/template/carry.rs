//! How the object moves between two frames: by its own flow, else with the hand, else with the scene.

use nalgebra::Matrix3;

use super::{TemplateError, path::Step, placement::Seen};
use crate::{
    geometry::{PerSide, Pixel},
    landmarks::HandLandmarks,
    segment::object::{
        Keyframe, LocalFlow, Roi, Similarity, apply, arm, fit_similarity, signed_distance, similarity,
    },
    vision::WorkScale,
};

/// Whether the object goes with the hand, 0 (with the scene) to 1, as seen so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Carried {
    held: f64,
}

/// The hands' keypoints on both frames, where known.
pub(super) struct Hands<'a> {
    pub scale: &'a WorkScale,
    pub before: Option<&'a PerSide<Option<HandLandmarks>>>,
    pub after: Option<&'a PerSide<Option<HandLandmarks>>>,
}

/// Keypoints that stay together while a hand holds something: the palm's and the fingertips.
const GRIP: [usize; 8] = [0, 1, 5, 9, 13, 17, 4, 8];

impl Hands<'_> {
    /// The motion of the hand whose fingertips are nearest to `place`.
    fn motion(&self, place: (f64, f64), reach: f64) -> Option<Matrix3<f64>> {
        let (before, after) = (self.before?, self.after?);
        let work = |hand: &HandLandmarks| GRIP.map(|k| self.scale.to_work(hand.keypoints[k]));
        let pairs = before.iter().filter_map(|(side, hand)| {
            let (earlier, later) = (hand.as_ref()?, after[side].as_ref()?);
            let (from, to) = (work(earlier), work(later));
            let gap = from.iter().map(|p| (p.x - place.0).hypot(p.y - place.1)).fold(f64::MAX, f64::min);
            Some((gap, from, to, growth(earlier, later)))
        });
        let (gap, from, to, growth) = pairs.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (gap < reach).then(|| rescaled(&between(&from, &to), place, growth))
    }
}

/// By how much a hand came nearer: the change of pixels a metre between its keypoints and the
/// estimator's metric ones, which no bending or turning of the hand feigns; 1 where it gives none.
fn growth(before: &HandLandmarks, after: &HandLandmarks) -> f64 {
    let resolution = |hand: &HandLandmarks| {
        let world = hand.world.as_ref()?;
        let n = world.len() as f64;
        let (wx, wy) =
            (world.iter().map(|p| p.x).sum::<f64>() / n, world.iter().map(|p| p.y).sum::<f64>() / n);
        let kx = hand.keypoints.iter().map(|p| p.x).sum::<f64>() / n;
        let ky = hand.keypoints.iter().map(|p| p.y).sum::<f64>() / n;
        let (mut along, mut across, mut square) = (0.0, 0.0, 0.0);
        for (w, k) in world.iter().zip(&hand.keypoints) {
            let (ax, ay, bx, by) = (w.x - wx, w.y - wy, k.x - kx, k.y - ky);
            along += ax * bx + ay * by;
            across += ax * by - ay * bx;
            square += ax * ax + ay * ay;
        }
        (square > 1e-9).then(|| f64::hypot(along, across) / square)
    };
    match (resolution(before), resolution(after)) {
        (Some(before), Some(after)) if before > 0.0 => (after / before).clamp(0.95, 1.05),
        _ => 1.0,
    }
}

/// A similarity with another scale that moves `place` as before.
fn rescaled(transform: &Matrix3<f64>, place: (f64, f64), scale: f64) -> Matrix3<f64> {
    let rigid = rigid(transform, place);
    let to = apply(&rigid, place.0, place.1);
    let about = Matrix3::new(scale, 0.0, to.0 - scale * to.0, 0.0, scale, to.1 - scale * to.1, 0.0, 0.0, 1.0);
    about * rigid
}

/// The similarity of least squares between two sets of points (Umeyama 1991, two dimensions).
fn between(from: &[Pixel], to: &[Pixel]) -> Matrix3<f64> {
    let n = from.len().max(1) as f64;
    let mean = |points: &[Pixel]| {
        (points.iter().map(|p| p.x).sum::<f64>() / n, points.iter().map(|p| p.y).sum::<f64>() / n)
    };
    let (f, t) = (mean(from), mean(to));
    let (mut along, mut across, mut square) = (0.0, 0.0, 1e-9);
    for (a, b) in from.iter().zip(to) {
        let (ax, ay, bx, by) = (a.x - f.0, a.y - f.1, b.x - t.0, b.y - t.1);
        along += ax * bx + ay * by;
        across += ax * by - ay * bx;
        square += ax * ax + ay * ay;
    }
    let (c, s) = (along / square, across / square);
    Matrix3::new(c, -s, t.0 - c * f.0 + s * f.1, s, c, t.1 - s * f.0 - c * f.1, 0.0, 0.0, 1.0)
}

/// The motions the object may have made from `previous` to `seen`, the likeliest first, where it lies
/// at `transform` on `previous`.
pub(super) fn step(
    key: &Keyframe,
    previous: &Seen,
    seen: &Seen,
    transform: &Matrix3<f64>,
    hands: &Hands<'_>,
    carried: &mut Carried,
) -> Result<Vec<Step>, TemplateError> {
    let (width, height) = (previous.view.width, previous.view.height);
    let margin = (0.7 * key.radius).clamp(24.0, 80.0);
    let roi = Roi::around(key.bounds(transform), margin, width, height);
    let flow = LocalFlow::between(&previous.view, &seen.view, roi)?;
    let mask = roi.crop(&previous.mask, width);
    let classes = roi.crop(&previous.view.arms, width);
    let inner = signed_distance(&mask, roi.width, roi.height)?;
    let placed = key.place(transform, &roi)?;
    let own = fit_similarity(&flow.matches(|at| inner.data[at] > 1.0 && placed.data[at] > 0.5, 1500));
    let share = inner.data.iter().filter(|d| **d > 1.0).count() as f64 / key.area;
    let hand = fit_similarity(&flow.matches(|at| classes[at] >= arm::MASK && mask[at] == 0, 800));
    let hand = hand.filter(|fit| fit.agreement > 0.3);
    let away = |at: usize| placed.data[at] < 0.05 && mask[at] == 0 && classes[at] == arm::NONE;
    let background = fit_similarity(&flow.matches(away, 1200));
    let centre = apply(transform, key.centre.0, key.centre.1);
    let grip = hands.motion(centre, 2.0 * key.radius);
    let hand = match (hand, grip) {
        (Some(hand), Some(grip)) => {
            let growth = grip[(0, 0)].hypot(grip[(1, 0)]);
            Some(rescaled(&((hand.transform + grip) * 0.5), centre, growth))
        }
        (hand, grip) => hand.map(|fit| rigid(&fit.transform, centre)).or(grip),
    };
    let at = |m: &Matrix3<f64>| apply(m, centre.0, centre.1);
    let gap = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
    let own = own.filter(|own| share > 0.08 && own.agreement > 0.3);
    if let (Some(own), Some(background), Some(hand)) = (&own, &background, &hand) {
        let moved = at(&own.transform);
        let (to_background, to_hand) = (gap(moved, at(&background.transform)), gap(moved, at(hand)));
        if to_background > 0.8 && to_hand < to_background {
            carried.held += 0.35 * (1.0 - carried.held);
        } else if to_hand > 0.8 && to_background < 0.5 * to_hand {
            carried.held *= 0.65;
        }
    }
    let first = choose(own, share, hand, background, carried.held, centre);
    let resting = background.is_some_and(|fit| fit.agreement > 0.5) && carried.held < 0.5;
    let still = background.map(|fit| Step { transform: fit.transform, shift: 1.0, form: 0.01 });
    let with_hand =
        hand.map(|transform| Step { transform, shift: 1.0 + 0.1 * gap(at(&transform), centre), form: 0.01 });
    // What nobody has been seen to move is taken to rest until another motion explains the frame better.
    let order = if resting { [still, Some(first), with_hand] } else { [Some(first), still, with_hand] };
    Ok(order.into_iter().flatten().collect())
}

/// Weighs the motions found into one step.
fn choose(
    own: Option<Similarity>,
    share: f64,
    hand: Option<Matrix3<f64>>,
    background: Option<Similarity>,
    held: f64,
    centre: (f64, f64),
) -> Step {
    let at = |m: &Matrix3<f64>| apply(m, centre.0, centre.1);
    let gap = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
    let length = |m: &Matrix3<f64>| gap(at(m), centre);
    let still = background.map(|fit| fit.transform);
    if let Some(own) = own {
        // An object that moves as the scene does stands still in it.
        if let Some(still) = still
            && gap(at(&own.transform), at(&still)) < 0.35
            && background.is_some_and(|fit| fit.agreement > 0.5)
        {
            return Step { transform: still, shift: 1.0, form: 0.01 };
        }
        let doubt = 1.5 - share.min(1.0);
        let shift = (1.0 + 0.1 * length(&own.transform)) * doubt;
        let transform = if share > 0.6 { own.transform } else { rigid(&own.transform, centre) };
        return Step { transform, shift, form: 0.012 * doubt };
    }
    let carrier = if held > 0.5 { hand.or(still) } else { still.or(hand) };
    match carrier {
        Some(transform) if held > 0.5 => {
            Step { transform, shift: 1.5 + 0.2 * length(&transform), form: 0.015 }
        }
        Some(transform) => Step { transform, shift: 1.0, form: 0.01 },
        None => Step { transform: Matrix3::identity(), shift: 3.0, form: 0.02 },
    }
}

/// A similarity without its scale, that moves `place` as the similarity does: what little is seen of
/// an object, or a hand that turns, says nothing sure about size.
fn rigid(transform: &Matrix3<f64>, place: (f64, f64)) -> Matrix3<f64> {
    let to = apply(transform, place.0, place.1);
    similarity(1.0, transform[(1, 0)].atan2(transform[(0, 0)]), place, to)
}
