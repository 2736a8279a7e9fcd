//! Where exactly the object lies on a view, from several guesses of how it moved.

use nalgebra::Matrix3;

use super::{
    evidence::Evidence,
    keyframe::{Keyframe, apply, similarity, turned_about},
    step::{Prediction, State},
    view::{Roi, View},
};
use crate::{
    segment::SegmentError,
    vision::{AlignChannel, AlignPrior, Alignment, Plane, align},
};

/// By how much another start has to explain the view better than the likeliest.
const MARGIN: f64 = 0.03;
/// Share of the expected shape that has to be seen for its moments to be the object's.
const MOST: f64 = 0.7;
/// Turns tried where most of the object may be hidden, rad.
const TURNS: [f64; 4] = [-0.24, -0.12, 0.12, 0.24];

/// Aligns the keyframe's texture and outline to the view, from the likeliest start; another start
/// wins where it explains the view clearly better. The transform and the alignment's agreement.
pub(super) fn refine(
    state: &State,
    view: &View,
    roi: &Roi,
    evidence: &Evidence,
    free: &Plane,
    prediction: &Prediction,
) -> Result<(Matrix3<f64>, f64), SegmentError> {
    let gray = roi.crop_plane(&view.gray_plane).blurred(0.8)?;
    let probability = evidence.object_probability(roi).blurred(1.5)?;
    let trust = free.blurred(1.0)?;
    let shift = Matrix3::new(1.0, 0.0, roi.x as f64, 0.0, 1.0, roi.y as f64, 0.0, 0.0, 1.0);
    let back = Matrix3::new(1.0, 0.0, -(roi.x as f64), 0.0, 1.0, -(roi.y as f64), 0.0, 0.0, 1.0);
    let key = &state.key;
    let channels = channels(key, &gray, &probability, &trust);
    let fit = |start: &Matrix3<f64>, prior: &AlignPrior| {
        align(&channels, &(back * start), key.centre, key.radius, prior, 12)
    };
    let explained = explained_part(&probability, free);
    let rate = |found: &Alignment| -> opencv::Result<f64> {
        let placed = key.place(&(shift * found.transform), roi)?;
        let covered: f32 = explained.data.iter().zip(&placed.data).map(|(e, p)| e * p).sum();
        let all: f32 = explained.data.iter().sum();
        let coverage = f64::from(covered / all.max(1.0));
        Ok(found.agreement * (0.6 + 0.4 * found.seen) + 0.4 * coverage)
    };
    let moving = moving_prior(state.visible);
    let mut found = fit(&prediction.likely, if prediction.resting { &STILL } else { &moving });
    let mut rating = rate(&found)?;
    let mut tried = vec![prediction.likely];
    for start in starts(state, roi, prediction, &explained, found.agreement > 0.9)? {
        if tried.iter().any(|other| key.near(other, &start, 1.5)) {
            continue;
        }
        let again = fit(&start, &moving);
        let other = rate(&again)?;
        if other > rating + MARGIN {
            (found, rating) = (again, other);
        }
        tried.push(start);
    }
    Ok((shift * found.transform, found.agreement))
}

fn channels<'a>(
    key: &'a Keyframe,
    gray: &'a Plane,
    probability: &'a Plane,
    trust: &'a Plane,
) -> [AlignChannel<'a>; 2] {
    let texture = AlignChannel {
        points: &key.texture,
        target: gray,
        trust: Some(trust),
        scale: 16.0,
        strength: 50.0,
        photometric: true,
    };
    let outline = AlignChannel {
        points: &key.outline,
        target: probability,
        trust: Some(trust),
        scale: 0.35,
        strength: 40.0,
        photometric: false,
    };
    [texture, outline]
}

/// How far an object that lies still may seem to move against the scene.
const STILL: AlignPrior =
    AlignPrior { shift: 0.02, scale: 0.003, rotation: 0.004, affine: 0.001, perspective: 0.0 };

/// How far a moving object may be from where flow says it is.
fn moving_prior(visible: f64) -> AlignPrior {
    // What little is seen of a hidden object cannot tell its shape from its place.
    let whole = ((visible - 0.5) / 0.4).clamp(0.0, 1.0);
    AlignPrior {
        shift: 0.12,
        scale: 0.008 + 0.017 * whole,
        rotation: 0.02 + 0.02 * whole,
        affine: 0.005 + 0.03 * whole,
        perspective: 0.002 + 0.008 * whole,
    }
}

/// Starts beside the likeliest: other motions unless that one is `sure`, the whole object by its
/// moments, and turns about what is seen while much is hidden.
fn starts(
    state: &State,
    roi: &Roi,
    prediction: &Prediction,
    explained: &Plane,
    sure: bool,
) -> Result<Vec<Matrix3<f64>>, SegmentError> {
    let (key, likely) = (&state.key, &prediction.likely);
    let mut starts = if sure { Vec::new() } else { prediction.others.clone() };
    starts.extend(by_moments(key, explained, likely, roi));
    if state.visible < 0.8 {
        let pivot = match middle_of(explained, &key.place(likely, roi)?) {
            Some(middle) => (middle.0 + roi.x as f64, middle.1 + roi.y as f64),
            None => apply(likely, key.centre.0, key.centre.1),
        };
        starts.extend(TURNS.map(|angle| turned_about(pivot, angle) * likely));
    }
    Ok(starts)
}

/// Where the view shows the object for sure: what a placement has to explain.
fn explained_part(probability: &Plane, free: &Plane) -> Plane {
    let sure = |(p, f): (&f32, &f32)| ((p * f - 0.6) / 0.3).clamp(0.0, 1.0);
    let data = probability.data.iter().zip(&free.data).map(sure).collect();
    Plane { width: probability.width, height: probability.height, data }
}

/// The weighted middle of what of the placed shape is seen.
fn middle_of(seen: &Plane, placed: &Plane) -> Option<(f64, f64)> {
    let both = seen.data.iter().zip(&placed.data).map(|(s, p)| s * p).collect();
    let both = Plane { width: seen.width, height: seen.height, data: both };
    both.moments().filter(|m| m.weight > 20.0).map(|m| m.centre)
}

/// The similarity that takes the keyframe's shape to what is seen by centre, spread and main axis;
/// right where the whole object is seen. `None` where too little is seen.
fn by_moments(key: &Keyframe, seen: &Plane, likely: &Matrix3<f64>, roi: &Roi) -> Option<Matrix3<f64>> {
    // What is hidden would count as shrunk.
    let linear = likely[(0, 0)] * likely[(1, 1)] - likely[(0, 1)] * likely[(1, 0)];
    let (now, own) = (seen.moments()?, key.shape.moments()?);
    if now.weight < MOST * linear.abs() * own.weight {
        return None;
    }
    let scale = (now.spread() / own.spread().max(1e-6)).sqrt();
    let expected_scale = likely[(0, 0)].hypot(likely[(1, 0)]).max(1e-6);
    let form = now.elongation() / own.elongation();
    // Another size or form at once is something else that has the object's colours.
    if !(0.8..1.25).contains(&(scale / expected_scale)) || !(0.7..1.4).contains(&form) {
        return None;
    }
    // An axis has no direction: the one nearer to the prediction's.
    let expected = likely[(1, 0)].atan2(likely[(0, 0)]);
    let elongated = own.elongation() > 1.3 && now.elongation() > 1.3;
    let turn = if elongated {
        let turn = now.axis() - own.axis();
        let half = std::f64::consts::PI;
        turn + half * ((expected - turn) / half).round()
    } else {
        expected
    };
    let from = (own.centre.0 + key.roi.x as f64, own.centre.1 + key.roi.y as f64);
    let to = (now.centre.0 + roi.x as f64, now.centre.1 + roi.y as f64);
    Some(similarity(scale, turn, from, to))
}
