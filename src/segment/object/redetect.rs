//! Finding the object again after it was lost: colour says where, texture and outline say which way up.

use nalgebra::Matrix3;
use opencv::{
    core::{BORDER_REFLECT, Mat, MatTraitConst, MatTraitConstManual, Point},
    imgproc,
};

use super::{
    evidence::{Colours, Evidence},
    keyframe::{Keyframe, apply},
    step::State,
    view::{Roi, Scene, View},
};
use crate::{
    clip::FrameIndex,
    segment::SegmentError,
    vision::{AlignChannel, AlignPrior, Alignment, ColourModel, Plane, align},
};

/// Side of the object in pixels at which places are looked for.
const SEARCH_RADIUS: f64 = 5.0;
/// Places tried at most.
const PLACES: usize = 6;
/// Orientations tried at every place.
const TURNS: usize = 12;
/// Agreement of texture and outline that a find needs.
const LEAST_AGREEMENT: f64 = 0.6;

/// Looks for the keyframe of `state` on frame `index`, wherever in `view` it can have got to; the transform of keyframe pixels to the view's.
pub(super) fn redetect(
    scene: &Scene<'_>,
    state: &State,
    view: &View,
    index: FrameIndex,
) -> Result<Option<Matrix3<f64>>, SegmentError> {
    let Some(now) = Searched::new(scene, state, view)? else { return Ok(None) };
    let Some(then) = Searched::new(scene, state, &state.witness)? else { return Ok(None) };
    let key = &state.key;
    let mut best: Option<(f64, Matrix3<f64>)> = None;
    for place in places(key, &now.likely)? {
        if !within_reach(scene, state, index, place) {
            continue;
        }
        let own = (place.0 - key.centre.0).hypot(place.1 - key.centre.1) < 0.7 * key.radius;
        for turn in 0..TURNS {
            let start = turned(key, place, turn as f64 * std::f64::consts::TAU / TURNS as f64);
            let found = now.align(key, &start);
            let rating = found.agreement * found.seen;
            let b = key.bounds(&found.transform);
            let inside =
                b.0 > 1.0 && b.1 > 1.0 && b.2 < view.width as f64 - 1.0 && b.3 < view.height as f64 - 1.0;
            let fits = found.agreement > LEAST_AGREEMENT && found.seen > 0.6 && inside;
            if !fits || best.as_ref().is_some_and(|(other, _)| rating <= *other) {
                continue;
            }
            // What fitted as well when the object was elsewhere is not the object.
            let before = then.align(key, &found.transform);
            if own || before.agreement * before.seen < 0.85 * rating {
                best = Some((rating, found.transform));
            }
        }
    }
    Ok(best.map(|(_, transform)| transform))
}

/// Whether the object can be at `place`: not far from where it went missing, or
/// beside a hand that held it.
fn within_reach(scene: &Scene<'_>, state: &State, index: FrameIndex, place: (f64, f64)) -> bool {
    let radius = state.key.radius;
    let last = apply(&state.transform, state.key.centre.0, state.key.centre.1);
    let reach = (3.0 + 0.1 * f64::from(state.missing)).min(6.0) * radius;
    let near_hand = scene
        .grip(index)
        .iter()
        .any(|(tip, palm)| (tip.x - place.0).hypot(tip.y - place.1) < palm + 2.0 * radius);
    state.held > 0.5 && near_hand || (last.0 - place.0).hypot(last.1 - place.1) < reach
}

/// A view prepared for the search.
struct Searched {
    /// How likely a pixel shows the object by colour and no arm.
    likely: Plane,
    /// The same, softened like a keyframe's outline.
    soft: Plane,
    gray: Plane,
    trust: Plane,
}

impl Searched {
    fn new(scene: &Scene<'_>, state: &State, view: &View) -> Result<Option<Self>, SegmentError> {
        let whole = Roi { x: 0, y: 0, width: view.width, height: view.height };
        let Some(around) = ColourModel::learn(view.lab.iter().step_by(3).map(|lab| (*lab, 1.0))) else {
            return Ok(None);
        };
        let colours = Colours { object: state.colours.object.clone(), around };
        let evidence = Evidence::read(view, &whole, &colours, scene.arm_colours.as_ref());
        let free = evidence.free_of_arm(&whole);
        let mut likely = evidence.object_probability(&whole);
        for (value, free) in likely.data.iter_mut().zip(&free.data) {
            *value *= free;
        }
        let soft = likely.blurred(1.5)?;
        Ok(Some(Self { likely, soft, gray: view.gray_plane.blurred(1.2)?, trust: free.blurred(1.0)? }))
    }

    fn align(&self, key: &Keyframe, start: &Matrix3<f64>) -> Alignment {
        let texture = AlignChannel {
            points: &key.texture,
            target: &self.gray,
            trust: Some(&self.trust),
            scale: 18.0,
            strength: 50.0,
            photometric: true,
        };
        let outline = AlignChannel {
            points: &key.outline,
            target: &self.soft,
            trust: Some(&self.trust),
            scale: 0.35,
            strength: 50.0,
            photometric: false,
        };
        let prior = AlignPrior { shift: 0.5, scale: 0.1, rotation: 0.3, affine: 0.0, perspective: 0.0 };
        align(&[texture, outline], start, key.centre, key.radius, &prior, 12)
    }
}

/// The keyframe moved to `place` and turned by `angle` about its centre.
fn turned(key: &Keyframe, place: (f64, f64), angle: f64) -> Matrix3<f64> {
    let (sin, cos) = angle.sin_cos();
    let (cx, cy) = key.centre;
    Matrix3::new(
        cos,
        -sin,
        place.0 - cos * cx + sin * cy,
        sin,
        cos,
        place.1 - sin * cx - cos * cy,
        0.0,
        0.0,
        1.0,
    )
}

/// Peaks of (likelihood inside a disc of the object's area) − (likelihood in a ring around it).
fn places(key: &Keyframe, likely: &Plane) -> Result<Vec<(f64, f64)>, SegmentError> {
    let factor = (SEARCH_RADIUS / key.radius).min(1.0);
    let mut small = Mat::default();
    let size = opencv::core::Size::new(
        ((likely.width as f64 * factor).round() as i32).max(8),
        ((likely.height as f64 * factor).round() as i32).max(8),
    );
    imgproc::resize(&likely.to_mat()?, &mut small, size, 0.0, 0.0, imgproc::INTER_AREA)?;
    let radius = key.radius * factor;
    let side = (2.0 * (1.7 * radius).ceil() + 1.0) as usize;
    let middle = (side / 2) as f64;
    let distance = |x: usize, y: usize| (x as f64 - middle).hypot(y as f64 - middle);
    let disc = Plane::from_fn(side, side, |x, y| f32::from(u8::from(distance(x, y) <= radius)));
    let ring = Plane::from_fn(side, side, |x, y| {
        let d = distance(x, y);
        f32::from(u8::from(d > 1.25 * radius && d <= 1.7 * radius))
    });
    let (inside, outside): (f32, f32) = (disc.data.iter().sum(), ring.data.iter().sum());
    let kernel = Plane::from_fn(side, side, |x, y| disc.at(x, y) / inside - ring.at(x, y) / outside.max(1.0));
    let mut response = Mat::default();
    imgproc::filter_2d(
        &small,
        &mut response,
        -1,
        &kernel.to_mat()?,
        Point::new(-1, -1),
        0.0,
        BORDER_REFLECT,
    )?;
    let (cols, rows) = (response.cols() as usize, response.rows() as usize);
    let mut values = response.data_typed::<f32>()?.to_vec();
    let mut places = Vec::new();
    while places.len() < PLACES {
        let peak = values.iter().enumerate().rev().max_by(|a, b| a.1.total_cmp(b.1));
        let Some((at, _)) = peak.filter(|(_, value)| **value > 0.12) else { break };
        let (x, y) = ((at % cols) as f64, (at / cols) as f64);
        places.push(((x + 0.5) / factor - 0.5, (y + 0.5) / factor - 0.5));
        for row in 0..rows {
            for col in 0..cols {
                if (col as f64 - x).hypot(row as f64 - y) < radius {
                    values[row * cols + col] = f32::MIN;
                }
            }
        }
    }
    Ok(places)
}
