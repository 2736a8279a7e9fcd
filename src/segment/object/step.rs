//! One step of a sweep: from the object's place on one frame to its place and mask on the next.

use std::sync::Arc;

use nalgebra::Matrix3;

use super::{
    evidence::{Colours, Evidence, learn_surroundings},
    keyframe::{Keyframe, apply, with_growth_within},
    motion::{LocalFlow, fit_similarity},
    recognise::{Known, recognise},
    redetect::redetect,
    refine::refine,
    shape::{bounds_of, fill_holes, iou, keep_components, signed_distance},
    view::{Roi, Scene, View, arm},
};
use crate::{
    clip::FrameIndex,
    segment::SegmentError,
    vision::{ColourModel, EdgeWeights, Plane, tv_cut},
};

/// Visible share from which the object counts as whole.
const WHOLE: f64 = 0.98;
/// Most that a partly hidden object grows or shrinks between two frames, as a logarithm.
const MOST_GROWTH: f64 = 0.015;

/// Where the object is on one frame, and what has been learned so far.
#[derive(Clone)]
pub(crate) struct State {
    pub view: Arc<View>,
    pub key: Arc<Keyframe>,
    /// Keyframe pixels to this frame's, work scale.
    pub transform: Matrix3<f64>,
    /// The visible part, 0 or 1 a work pixel.
    pub shape: Vec<u8>,
    pub colours: Colours,
    /// How much the object moves with the hand, 0 (with the background) to 1.
    pub held: f64,
    /// Share of the shape that no arm covers.
    pub visible: f64,
    /// Steps since the keyframe.
    pub age: u32,
    /// Area of the shape on the annotated frame, work pixels.
    pub root_area: f64,
    /// Steps for which the object should have been seen but was not.
    pub missing: u32,
    /// The view the keyframe was cut from.
    pub witness: Arc<View>,
    pub measures: Measures,
}

/// How well a step went.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Measures {
    /// Share of texture and outline samples that agree after alignment.
    pub agreement: f64,
    /// IoU of the cut with the visible part of the carried shape.
    pub overlap: f64,
    /// Bhattacharyya distance of the cut's colours to the model's.
    pub colour: f64,
    /// Area of the cut over the carried shape's visible area.
    pub area_ratio: f64,
    /// Area of the whole carried shape over the root area.
    pub growth: f64,
}

impl State {
    /// The state on an annotated frame; `None` when `shape` is empty or has no surroundings.
    pub fn seed(view: Arc<View>, shape: Vec<u8>) -> Result<Option<Self>, SegmentError> {
        let Some(key) = Keyframe::new(&view, &shape)? else { return Ok(None) };
        let roi = Roi::around(key.bounds(&Matrix3::identity()), surround(&key), view.width, view.height);
        let cropped = roi.crop(&shape, view.width);
        let distance = signed_distance(&cropped, roi.width, roi.height)?;
        let lab = roi.crop(&view.lab, view.width);
        let interior = |least: f32| {
            let samples = lab.iter().zip(&distance.data).filter(move |(_, d)| **d > least);
            ColourModel::learn(samples.map(|(lab, _)| (*lab, 1.0)))
        };
        let object = interior(1.0).or_else(|| interior(0.0));
        let around = learn_surroundings(&view, &roi, &distance, 2.0, surround(&key) as f32);
        let (Some(object), Some(around)) = (object, around) else { return Ok(None) };
        let root_area = key.area;
        let measures = Measures { agreement: 1.0, overlap: 1.0, colour: 0.0, area_ratio: 1.0, growth: 1.0 };
        Ok(Some(Self {
            witness: Arc::clone(&view),
            view,
            key: Arc::new(key),
            transform: Matrix3::identity(),
            shape,
            colours: Colours { object, around },
            held: 0.0,
            visible: 1.0,
            age: 0,
            root_area,
            missing: 0,
            measures,
        }))
    }
}

/// Width of the ring around the object that counts as its surroundings, work pixels.
fn surround(key: &Keyframe) -> f64 {
    (0.9 * key.radius).clamp(12.0, 60.0)
}

/// Advances `state` to `view`.
pub(crate) fn advance(
    scene: &Scene<'_>,
    state: &State,
    view: Arc<View>,
    index: FrameIndex,
) -> Result<State, SegmentError> {
    let mut prediction = predict(state, &view)?;
    // A search costs as much as several frames: not on every one.
    if state.missing >= 2
        && state.missing.is_multiple_of(3)
        && let Some(found) = redetect(scene, state, &view, index)?
    {
        prediction = Prediction { likely: found, others: Vec::new(), resting: false, ..prediction };
    }
    let margin = surround(&state.key).max(20.0);
    let around = |start: &Matrix3<f64>| Roi::around(state.key.bounds(start), margin, view.width, view.height);
    let roi =
        prediction.others.iter().fold(around(&prediction.likely), |roi, other| roi.union(&around(other)));
    let mut evidence = Evidence::read(&view, &roi, &state.colours, scene.arm_colours.as_ref());
    let free = evidence.free_of_arm(&roi);
    let (transform, agreement) = refine(state, &view, &roi, &evidence, &free, &prediction)?;
    let placed = state.key.place(&transform, &roi)?;
    let placed_bytes: Vec<u8> = placed.data.iter().map(|v| u8::from(*v > 0.5)).collect();
    let distance = signed_distance(&placed_bytes, roi.width, roi.height)?;
    // How much of it is seen is left to the colours: the motion of what is nearly hidden must not lean on a likeness.
    let known = Known { key: &state.key, witness: &state.witness, transform: &transform, placed: &placed };
    recognise(&known, &view, &roi, scene.arm_colours.as_ref(), &mut evidence)?;
    let cut = cut(scene, &view, &roi, &evidence, &distance, agreement)?;
    let expected: Vec<u8> =
        placed_bytes.iter().zip(&free.data).map(|(p, f)| u8::from(*p != 0 && *f > 0.5)).collect();
    let count = |bytes: &[u8]| bytes.iter().filter(|v| **v != 0).count() as f64;
    let (whole, exposed, found) = (count(&placed_bytes), count(&expected), count(&cut));
    let lab = roi.crop(&view.lab, view.width);
    let depth = signed_distance(&cut, roi.width, roi.height)?;
    // Pixels on the border are mixtures: they teach nothing.
    let inside = lab.iter().zip(&depth.data).filter(|(_, d)| **d > 1.0).map(|(lab, _)| (*lab, 1.0));
    let seen_colours = ColourModel::learn(inside);
    let measures = Measures {
        agreement,
        overlap: iou(&cut, &expected),
        colour: seen_colours.as_ref().map_or(1.0, |c| c.distance(&state.colours.object)),
        area_ratio: found / exposed.max(1.0),
        growth: whole / state.root_area.max(1.0),
    };
    let visible = exposed / whole.max(1.0);
    let sought = visible > 0.6 && exposed > 25.0;
    // Off the picture, or nearly.
    let gone = whole < 0.3 * state.key.area;
    let lost = gone || sought && measures.overlap < 0.25;
    let missing = if lost {
        state.missing + 1
    } else if sought {
        0
    } else {
        state.missing
    };
    let mut shape = vec![0; view.width * view.height];
    // What is cut out where the object is not is something else.
    let cut = if missing >= 2 { vec![0; cut.len()] } else { cut };
    for (at, value) in cut.iter().enumerate() {
        shape[(at / roi.width + roi.y) * view.width + at % roi.width + roi.x] = *value;
    }
    let mut next = State {
        view,
        transform,
        shape,
        held: prediction.held,
        visible,
        missing,
        age: state.age + 1,
        measures,
        ..state.clone()
    };
    if next.missing == 0 {
        learn(&mut next, &roi, &distance, seen_colours)?;
    }
    Ok(next)
}

/// Where the object may be.
pub(super) struct Prediction {
    /// The likeliest transform: by the flow of what is visible, else by what the object goes with.
    pub likely: Matrix3<f64>,
    /// Others: with the scene, with the hand.
    pub others: Vec<Matrix3<f64>>,
    held: f64,
    /// Whether the likeliest is to lie still in the scene.
    pub resting: bool,
}

/// Predicts the transform from flow.
fn predict(state: &State, view: &View) -> Result<Prediction, SegmentError> {
    let previous = &state.view;
    let margin = (0.8 * state.key.radius).clamp(28.0, 90.0);
    let roi = Roi::around(state.key.bounds(&state.transform), margin, view.width, view.height);
    let flow = LocalFlow::between(previous, view, roi)?;
    let shape = roi.crop(&state.shape, previous.width);
    let classes = roi.crop(&previous.arms, previous.width);
    let placed = state.key.place(&state.transform, &roi)?;
    let inner = signed_distance(&shape, roi.width, roi.height)?;
    let object = fit_similarity(&flow.matches(|at| inner.data[at] > 1.0, 1500));
    let enough = inner.data.iter().filter(|d| **d > 1.0).count() as f64 > 0.12 * state.key.area;
    let hand = fit_similarity(&flow.matches(|at| classes[at] >= arm::MASK && shape[at] == 0, 800));
    let away = |at: usize| placed.data[at] < 0.05 && shape[at] == 0 && classes[at] == arm::NONE;
    let background = fit_similarity(&flow.matches(away, 1200));
    let centre = apply(&state.transform, state.key.centre.0, state.key.centre.1);
    let shift = |transform: &Matrix3<f64>| apply(transform, centre.0, centre.1);
    let gap = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
    let mut held = state.held;
    if let (true, Some(object), Some(background), Some(hand)) = (enough, &object, &background, &hand) {
        let own = shift(&object.transform);
        let (to_background, to_hand) =
            (gap(own, shift(&background.transform)), gap(own, shift(&hand.transform)));
        if to_background > 0.8 && to_hand < to_background {
            held += 0.35 * (1.0 - held);
        } else if to_hand > 0.8 && to_background < 0.5 * to_hand {
            held *= 0.65;
        }
    }
    let hand = hand.filter(|fit| fit.agreement > 0.3);
    let carrier = if held > 0.5 { hand.or(background) } else { background.or(hand) };
    // What nobody has been seen to move is taken to lie where it was while a hand passes before it.
    let resting = held < 0.5 && state.visible < 0.9 && background.is_some_and(|fit| fit.agreement > 0.5);
    let own = if resting { object.filter(|_| enough) } else { background };
    let others = [own, hand].into_iter().flatten().map(|fit| fit.transform * state.transform);
    let others = others.collect();
    let step = match (object, carrier) {
        (_, Some(carrier)) if resting => carrier.transform,
        (Some(object), _) if enough => own_step(&object.transform, centre, state.visible),
        (_, Some(carrier)) => carrier.transform,
        (Some(object), None) => object.transform,
        (None, None) => Matrix3::identity(),
    };
    Ok(Prediction { likely: step * state.transform, others, held, resting })
}

/// The object's own flow as a step. Flow over a part of the object beside a hand that moves over it sees
/// growth where there is none: a held thing comes nearer by no more than a little a frame.
fn own_step(flow: &Matrix3<f64>, centre: (f64, f64), visible: f64) -> Matrix3<f64> {
    if visible < WHOLE { with_growth_within(flow, centre, MOST_GROWTH) } else { *flow }
}

/// Cuts the visible part out of the view: colours, arms, the carried shape, edges.
fn cut(
    scene: &Scene<'_>,
    view: &View,
    roi: &Roi,
    evidence: &Evidence,
    distance: &Plane,
    agreement: f64,
) -> Result<Vec<u8>, SegmentError> {
    let (width, height) = (roi.width, roi.height);
    let rigidity = scene.params.rigidity as f32 * (0.35 + agreement as f32);
    let cost: Vec<f32> = (0..roi.area())
        .map(|at| {
            let d = distance.data[at];
            let carried = rigidity * (d / 1.5).clamp(-2.5, 2.5) - if d < -8.0 { 4.0 } else { 0.0 };
            let object = evidence.object[at] + carried;
            // Object against either of the two others: the stronger rival decides.
            -object.min(-1.5 * evidence.arm[at]).clamp(-4.0, 4.0)
        })
        .collect();
    let lab = roi.crop(&view.lab, view.width);
    let edges = EdgeWeights::from_colours(&lab, width, height, scene.params.smoothness as f32);
    let start = cost.iter().map(|c| if *c < 0.0 { 1.0 } else { 0.0 }).collect();
    let mut u = Plane { width, height, data: start };
    tv_cut(&mut u, &cost, &edges, 80);
    let mut shape: Vec<u8> = u.data.iter().map(|v| u8::from(*v > 0.5)).collect();
    let total = shape.iter().filter(|v| **v != 0).count();
    keep_components(
        &mut shape,
        width,
        height,
        |at| distance.data[at] > 0.0,
        |area, overlap| 2 * overlap >= area && (100 * area >= total || area >= 30),
    )?;
    fill_holes(&mut shape, width, height, total / 60 + 3, |at| evidence.arm[at] < 0.0)?;
    Ok(shape)
}

/// Updates colours and keyframe where the step can be trusted.
fn learn(
    next: &mut State,
    roi: &Roi,
    distance: &Plane,
    seen: Option<ColourModel>,
) -> Result<(), SegmentError> {
    let far = surround(&next.key) as f32;
    if let Some(around) = learn_surroundings(&next.view, roi, distance, 2.5, far) {
        next.colours.around.blend(&around, 0.4);
    }
    let measures = next.measures;
    let sound = measures.overlap > 0.8 && measures.colour < 0.45;
    if let (true, Some(seen)) = (sound && next.visible > 0.5, seen) {
        next.colours.object.blend(&seen, 0.04);
    }
    let changed = measures.overlap < 0.94 || measures.agreement < 0.6 || next.age >= 20;
    // Beside an arm nobody knows where the shape ends: there its size has to stay.
    let touched = beside_arm(&next.view, roi, distance);
    let sizes = if touched { 0.85..1.2 } else { 0.4..2.5 };
    let stays = sizes.contains(&measures.growth) && (0.8..1.25).contains(&measures.area_ratio);
    let inside = bounds_of(&next.shape, next.view.width).is_some_and(|b| {
        b.0 > 1.0 && b.1 > 1.0 && b.2 < next.view.width as f64 - 1.0 && b.3 < next.view.height as f64 - 1.0
    });
    if sound
        && changed
        && stays
        && inside
        && next.visible > 0.985
        && let Some(key) = Keyframe::new(&next.view, &next.shape)?
    {
        next.key = Arc::new(key);
        next.witness = Arc::clone(&next.view);
        next.transform = Matrix3::identity();
        next.age = 0;
    }
    Ok(())
}

/// Whether an arm covers a fair part of a thin ring around the shape.
fn beside_arm(view: &View, roi: &Roi, distance: &Plane) -> bool {
    let classes = roi.crop(&view.arms, view.width);
    let ring = distance.data.iter().zip(&classes).filter(|(d, _)| **d < 0.0 && **d > -4.0);
    let (mut all, mut covered) = (0_u32, 0_u32);
    for (_, class) in ring {
        all += 1;
        covered += u32::from(*class >= arm::MASK);
    }
    20 * covered > all
}
