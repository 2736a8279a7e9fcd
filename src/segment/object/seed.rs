//! From a prompt to the object's visible shape on the prompt's own frame.

use opencv::core::{Mat, MatTraitConstManual};

use super::{
    guess,
    params::PromptKind,
    rating,
    shape::{byte_mat, fill_holes, keep_components, signed_distance},
    view::{Roi, Scene, View, arm},
};
use crate::{
    clip::FrameIndex,
    geometry::{Pixel, PixelBox},
    segment::SegmentError,
    vision::{ColourModel, EdgeWeights, Plane, grab_cut, log_odds, tv_cut},
};

/// The visible shape that `kind` asks for, one byte a pixel of the work picture; `None` when there
/// is nothing there.
pub(crate) fn seed_shape(
    scene: &Scene<'_>,
    view: &View,
    frame: FrameIndex,
    kind: &PromptKind,
) -> Result<Option<Vec<u8>>, SegmentError> {
    let shape = match kind {
        PromptKind::Mask { mask, .. } => {
            let shrunk = scene.scale.shrink_mask(&mask.decode().to_mat()?)?;
            shrunk.data_bytes()?.iter().map(|v| u8::from(*v != 0)).collect()
        }
        PromptKind::Box(bounds) => from_box(scene, view, frame, bounds)?,
        PromptKind::Points { positive, negative } => from_points(scene, view, positive, negative)?,
    };
    Ok(shape.contains(&1).then_some(shape))
}

/// What is known before any colour: where the object may be and where it hardly is.
pub(super) struct Hints {
    pub roi: Roi,
    /// 0 impossible, 1 certain, 2 unlikely, 3 likely: GrabCut's seed values.
    seeds: Vec<u8>,
    /// Log-odds of place alone.
    place: Vec<f32>,
    /// Where a component must reach to be kept.
    anchor: Vec<bool>,
    /// The box in the rectangle's pixels `(x0, y0, x1, y1)`, where there is one.
    pub bounds: Option<(f64, f64, f64, f64)>,
    /// First guesses of the shape, 0 or 1.
    guesses: Vec<Vec<u8>>,
    /// Pixels that move otherwise than the background, where that says anything, 0 or 1.
    pub moving: Option<Vec<u8>>,
}

impl Hints {
    fn new(roi: Roi) -> Self {
        let (seeds, place, anchor, guesses) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { roi, seeds, place, anchor, bounds: None, guesses, moving: None }
    }
}

fn from_box(
    scene: &Scene<'_>,
    view: &View,
    frame: FrameIndex,
    bounds: &PixelBox,
) -> Result<Vec<u8>, SegmentError> {
    let low = scene.scale.to_work(Pixel::new(bounds.x0, bounds.y0));
    let high = scene.scale.to_work(Pixel::new(bounds.x1, bounds.y1));
    let (width, height) = (high.x - low.x, high.y - low.y);
    let margin = (0.35 * width.max(height)).max(14.0);
    let roi = Roi::around((low.x, low.y, high.x, high.y), margin, view.width, view.height);
    let classes = roi.crop(&view.arms, view.width);
    let mut hints = Hints::new(roi);
    for (at, class) in classes.iter().enumerate() {
        let x = (at % roi.width + roi.x) as f64;
        let y = (at / roi.width + roi.y) as f64;
        let u = 2.0 * (x - low.x + 0.5) / width.max(1.0) - 1.0;
        let v = 2.0 * (y - low.y + 0.5) / height.max(1.0) - 1.0;
        // A box drawn by hand may be a pixel or two too tight.
        let slack = 2.0 + 0.02 * width.max(height);
        let beyond = (low.x - x).max(x - high.x).max(low.y - y).max(y - high.y);
        let inside = beyond <= 0.0;
        let middle = u.abs().max(v.abs()) < 0.6;
        let seed = if beyond > slack {
            grab_cut::SEED_BACKGROUND
        } else if !inside || *class == arm::SKELETON {
            grab_cut::SEED_PROBABLY_BACKGROUND
        } else {
            grab_cut::SEED_PROBABLY_FOREGROUND
        };
        hints.seeds.push(seed);
        let corner = (u * u + v * v) as f32;
        let place = if beyond > slack {
            -20.0
        } else if !inside {
            -2.0
        } else {
            0.4 - 0.4 * corner
        };
        hints.place.push(place);
        hints.anchor.push(inside && middle);
    }
    let (left, top) = (roi.x as f64, roi.y as f64);
    let inner = (low.x - left, low.y - top, high.x - left, high.y - top);
    hints.bounds = Some(inner);
    hints.guesses = guess::inside_box(&roi, inner);
    hints.moving = guess::moving(scene, view, frame, &roi, inner)?;
    hints.guesses.extend(hints.moving.clone());
    cut_from_hints(scene, view, &hints)
}

fn from_points(
    scene: &Scene<'_>,
    view: &View,
    positive: &[Pixel],
    negative: &[Pixel],
) -> Result<Vec<u8>, SegmentError> {
    let positive: Vec<Pixel> = positive.iter().map(|p| scene.scale.to_work(*p)).collect();
    let negative: Vec<Pixel> = negative.iter().map(|p| scene.scale.to_work(*p)).collect();
    let reach = 0.16 * (view.width as f64).hypot(view.height as f64);
    let (mut x0, mut y0, mut x1, mut y1) = (f64::MAX, f64::MAX, f64::MIN, f64::MIN);
    for p in &positive {
        (x0, y0, x1, y1) = (x0.min(p.x), y0.min(p.y), x1.max(p.x), y1.max(p.y));
    }
    let roi = Roi::around((x0, y0, x1, y1), 1.6 * reach, view.width, view.height);
    let classes = roi.crop(&view.arms, view.width);
    let nearest =
        |points: &[Pixel], p: Pixel| points.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
    let mut hints = Hints::new(roi);
    for (at, class) in classes.iter().enumerate() {
        let p = Pixel::new((at % roi.width + roi.x) as f64, (at / roi.width + roi.y) as f64);
        let (on, off) = (nearest(&positive, p), nearest(&negative, p));
        let seed = if off < 4.0 && off < on || on > reach {
            grab_cut::SEED_BACKGROUND
        } else if on < 4.0 {
            grab_cut::SEED_FOREGROUND
        } else if *class == arm::SKELETON || off < on || on > 0.35 * reach {
            grab_cut::SEED_PROBABLY_BACKGROUND
        } else {
            grab_cut::SEED_PROBABLY_FOREGROUND
        };
        hints.seeds.push(seed);
        let place = match seed {
            grab_cut::SEED_BACKGROUND => -20.0,
            grab_cut::SEED_FOREGROUND => 20.0,
            _ => (1.0 - 2.0 * on / reach) as f32,
        };
        hints.place.push(place);
        hints.anchor.push(on < 4.0);
    }
    hints.guesses = vec![hints.seeds.iter().map(|seed| seed & 1).collect()];
    cut_from_hints(scene, view, &hints)
}

/// Several first guesses of the shape inside a box, each grown into a full cut; the best one wins.
fn cut_from_hints(scene: &Scene<'_>, view: &View, hints: &Hints) -> Result<Vec<u8>, SegmentError> {
    let mut best: Option<(f64, Vec<u8>)> = None;
    for guess in &hints.guesses {
        let shape = grow(scene, view, hints, guess)?;
        let score = rating::rate(view, hints, &shape)?;
        if best.as_ref().is_none_or(|(other, _)| score > *other) {
            best = Some((score, shape));
        }
    }
    let shape = best.map_or_else(Vec::new, |(_, shape)| shape);
    let (width, roi) = (hints.roi.width, &hints.roi);
    let mut full = vec![0; view.width * view.height];
    for (at, value) in shape.iter().enumerate() {
        full[(at / width + roi.y) * view.width + at % width + roi.x] = *value;
    }
    Ok(full)
}

/// GrabCut from a guess, then convex cuts with histograms learned from the cut itself.
fn grow(scene: &Scene<'_>, view: &View, hints: &Hints, guess: &[u8]) -> Result<Vec<u8>, SegmentError> {
    let roi = &hints.roi;
    let (width, height) = (roi.width, roi.height);
    let seeds: Vec<u8> = hints
        .seeds
        .iter()
        .zip(guess)
        .map(|(seed, inside)| match *seed {
            grab_cut::SEED_PROBABLY_FOREGROUND if *inside == 0 => grab_cut::SEED_PROBABLY_BACKGROUND,
            seed => seed,
        })
        .collect();
    let picture = roi.crop_mat(&view.rgb)?;
    let first = grab_cut::grab_cut(&picture, &seed_mat(&seeds, width, height)?, 4, width.max(height) as i32)?;
    let mut shape: Vec<u8> = first.data_bytes()?.iter().map(|v| u8::from(*v != 0)).collect();
    let likely = seeds.iter().filter(|s| **s & 1 == 1).count();
    if (shape.iter().filter(|v| **v != 0).count() as f64) < 0.12 * likely as f64 {
        // GrabCut found nothing that stands out: begin with the guess alone.
        shape = seeds.iter().map(|s| s & 1).collect();
    }
    let guessed = signed_distance(guess, width, height)?;
    let reach = (0.12 * (likely as f32).sqrt()).max(3.0);
    let lab = roi.crop(&view.lab, view.width);
    let classes = roi.crop(&view.arms, view.width);
    let edges = EdgeWeights::from_colours(&lab, width, height, scene.params.smoothness as f32);
    for _ in 0..3 {
        let distance = signed_distance(&shape, width, height)?;
        let learn = |inside: bool| {
            let samples = lab.iter().enumerate().filter_map(|(at, lab)| {
                let d = distance.data[at];
                let fits = if inside { d > 0.6 } else { d < -1.6 && classes[at] != arm::SKELETON };
                fits.then_some((*lab, 1.0))
            });
            ColourModel::learn(samples)
        };
        let (Some(object), Some(around)) = (learn(true), learn(false)) else { break };
        let cost: Vec<f32> = (0..lab.len())
            .map(|at| {
                let (f, b) = (object.likelihood(lab[at]), around.likelihood(lab[at]));
                let place = hints.place[at] + 0.6 * (guessed.data[at] / reach).clamp(-1.5, 1.5);
                let mut logit = log_odds(f, b).clamp(-2.5, 2.5) + place;
                if let Some(arms) = &scene.arm_colours {
                    let skin = log_odds(arms.likelihood(lab[at]), f).clamp(-2.8, 2.8);
                    let covered = match classes[at] {
                        arm::SKELETON => 2.5,
                        arm::MASK => 0.8,
                        arm::NEAR => -1.5,
                        _ => -4.0,
                    } + skin;
                    logit = logit.min(-covered);
                }
                -logit.clamp(-4.0, 4.0)
            })
            .collect();
        let start = shape.iter().map(|v| f32::from(*v)).collect();
        let mut u = Plane { width, height, data: start };
        tv_cut(&mut u, &cost, &edges, 120);
        shape = u.data.iter().map(|v| u8::from(*v > 0.5)).collect();
        tidy(&mut shape, hints)?;
    }
    Ok(shape)
}

fn tidy(shape: &mut [u8], hints: &Hints) -> Result<(), SegmentError> {
    let (width, height) = (hints.roi.width, hints.roi.height);
    let total = shape.iter().filter(|v| **v != 0).count();
    let anchored = shape.iter().zip(&hints.anchor).any(|(v, a)| *v != 0 && *a);
    keep_components(
        shape,
        width,
        height,
        |at| hints.anchor[at],
        |area, overlap| {
            if anchored { overlap > 0 && 20 * area >= total } else { 5 * area >= total }
        },
    )?;
    fill_holes(shape, width, height, total / 40 + 4, |_| true)?;
    Ok(())
}

fn seed_mat(seeds: &[u8], width: usize, height: usize) -> opencv::Result<Mat> {
    use opencv::core::MatTraitManual;
    let mut mat = byte_mat(seeds, width, height)?;
    mat.data_bytes_mut()?.copy_from_slice(seeds);
    Ok(mat)
}
