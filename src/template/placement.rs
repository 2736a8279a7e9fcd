//! Where the object's full shape lies on every frame.
//!
//! From the clean frame one sweep runs to each end of the clip. Flow and the last motion predict;
//! direct alignment against the clean frame itself, never against the frame before, measures: the
//! texture where the object is visible, and the mask's border where no arm hides it.

use std::sync::Arc;

use nalgebra::Matrix3;
use opencv::core::MatTraitConstManual;

use super::{TemplateError, TemplateParams};
use crate::{
    clip::FrameIndex,
    segment::{
        MaskFlag, MaskTrack,
        object::{Keyframe, LocalFlow, Roi, Scene, View, apply, arm, fit_similarity, signed_distance},
    },
    vision::{AlignChannel, AlignPrior, Alignment, Plane, align},
};

/// Where the object lies on one frame, work scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Located {
    /// Clean-frame pixels to this frame's.
    pub transform: Matrix3<f64>,
    /// How well the frame itself determines the transform, 0 (only predicted) to 1.
    pub evidence: f64,
    /// Share of the full shape that the mask shows.
    pub visible: f64,
    /// Where prediction alone would have put it.
    pub predicted: Matrix3<f64>,
}

/// A frame with its object mask, work scale.
struct Seen {
    view: View,
    mask: Vec<u8>,
    trusted: bool,
}

impl Seen {
    fn load(scene: &Scene<'_>, object: &MaskTrack, index: FrameIndex) -> Result<Self, TemplateError> {
        let frame = object.frame(index);
        let mask = scene.scale.shrink_mask(&frame.mask.decode().to_mat()?)?;
        let mask = mask.data_bytes()?.iter().map(|v| u8::from(*v != 0)).collect();
        let doubtful = frame.flags.iter().any(|flag| {
            matches!(flag, MaskFlag::Lost | MaskFlag::LowOverlap | MaskFlag::ColourDrift | MaskFlag::AreaJump)
        });
        Ok(Self { view: scene.view(index)?, mask, trusted: !doubtful && frame.score > 0.1 })
    }
}

/// Locates the object on every frame, from the clean frame `clean` and its full `shape` outwards.
pub(crate) fn locate(
    scene: &Scene<'_>,
    object: &MaskTrack,
    clean: FrameIndex,
    shape: &[u8],
    params: &TemplateParams,
) -> Result<Vec<Located>, TemplateError> {
    let start = Seen::load(scene, object, clean)?;
    let count = object.frames.len();
    let here = clean.as_usize();
    let identity = Matrix3::identity();
    let own = Located { transform: identity, evidence: 1.0, visible: 1.0, predicted: identity };
    let Some(key) = Keyframe::new(&start.view, shape)? else { return Ok(vec![own; count]) };
    let start = Arc::new(start);
    let after: Vec<usize> = (here + 1..count).collect();
    let before: Vec<usize> = (0..here).rev().collect();
    let run = |targets: &[usize]| sweep(scene, object, &key, &start, targets, params);
    let (after, before) = rayon::join(|| run(&after), || run(&before));
    let mut located = before?;
    located.reverse();
    located.push(own);
    located.extend(after?);
    Ok(located)
}

fn sweep(
    scene: &Scene<'_>,
    object: &MaskTrack,
    key: &Keyframe,
    start: &Arc<Seen>,
    targets: &[usize],
    params: &TemplateParams,
) -> Result<Vec<Located>, TemplateError> {
    let mut previous = Arc::clone(start);
    let mut transform = Matrix3::identity();
    let mut held = 0.0;
    let mut located: Vec<Located> = Vec::with_capacity(targets.len());
    for target in targets {
        scene.watch.check()?;
        let seen = Arc::new(Seen::load(scene, object, FrameIndex(*target as u32))?);
        let (step, now_held) = motion(key, &previous, &seen, &transform, held)?;
        held = now_held;
        let predicted = step * transform;
        let mut found = measure(key, &seen, &predicted, params)?;
        if found.evidence > 0.35 && located.last().is_some_and(|last| last.evidence < 0.2) {
            spread_correction(&mut located, key, &found);
        }
        if !found.transform.iter().all(|v| v.is_finite()) {
            found.transform = predicted;
            found.evidence = 0.0;
        }
        transform = found.transform;
        located.push(found);
        previous = seen;
    }
    Ok(located)
}

/// The object's motion from `previous` to `seen`, and how much it goes with the hand.
fn motion(
    key: &Keyframe,
    previous: &Seen,
    seen: &Seen,
    transform: &Matrix3<f64>,
    mut held: f64,
) -> Result<(Matrix3<f64>, f64), TemplateError> {
    let (width, height) = (previous.view.width, previous.view.height);
    let margin = (0.7 * key.radius).clamp(24.0, 80.0);
    let roi = Roi::around(key.bounds(transform), margin, width, height);
    let flow = LocalFlow::between(&previous.view, &seen.view, roi)?;
    let mask = roi.crop(&previous.mask, width);
    let classes = roi.crop(&previous.view.arms, width);
    let inner = signed_distance(&mask, roi.width, roi.height)?;
    let placed = key.place(transform, &roi)?;
    let own = fit_similarity(&flow.matches(|at| inner.data[at] > 1.0, 1500));
    let enough = inner.data.iter().filter(|d| **d > 1.0).count() as f64 > 0.08 * key.area;
    let hand = fit_similarity(&flow.matches(|at| classes[at] >= arm::MASK && mask[at] == 0, 800));
    let away = |at: usize| placed.data[at] < 0.05 && mask[at] == 0 && classes[at] == arm::NONE;
    let background = fit_similarity(&flow.matches(away, 1200));
    let centre = apply(transform, key.centre.0, key.centre.1);
    let shift = |m: &Matrix3<f64>| apply(m, centre.0, centre.1);
    let gap = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
    if let (true, Some(own), Some(background), Some(hand)) = (enough, &own, &background, &hand) {
        let moved = shift(&own.transform);
        let to_background = gap(moved, shift(&background.transform));
        let to_hand = gap(moved, shift(&hand.transform));
        if to_background > 0.8 && to_hand < to_background {
            held += 0.35 * (1.0 - held);
        } else if to_hand > 0.8 && to_background < 0.5 * to_hand {
            held *= 0.65;
        }
    }
    let hand = hand.filter(|fit| fit.agreement > 0.3);
    let carrier = if held > 0.5 { hand.or(background) } else { background.or(hand) };
    let step = match (own, carrier) {
        (Some(own), _) if enough && own.agreement > 0.3 => own.transform,
        (_, Some(carrier)) => carrier.transform,
        (Some(own), None) => own.transform,
        (None, None) => Matrix3::identity(),
    };
    Ok((step, held))
}

/// Aligns the clean view to a frame, coarse to fine.
fn measure(
    key: &Keyframe,
    seen: &Seen,
    predicted: &Matrix3<f64>,
    params: &TemplateParams,
) -> Result<Located, TemplateError> {
    let (width, height) = (seen.view.width, seen.view.height);
    let margin = (0.5 * key.radius).max(24.0);
    let mut roi = Roi::around(key.bounds(predicted), margin, width, height);
    if let Some(b) = crate::segment::object::bounds_of(&seen.mask, width) {
        let mask = Roi::around(b, margin, width, height);
        roi = roi.union(&mask);
    }
    let mask_bytes = roi.crop(&seen.mask, width);
    let area = mask_bytes.iter().filter(|v| **v != 0).count() as f64;
    let visible = (area / area_of(key, predicted)).min(1.0);
    let fallback = Located { transform: *predicted, evidence: 0.0, visible, predicted: *predicted };
    if !seen.trusted || area < 40.0 {
        return Ok(Located { visible: if area < 40.0 { 0.0 } else { visible }, ..fallback });
    }
    let classes = roi.crop(&seen.view.arms, width);
    let plane = |data: Vec<f32>| Plane { width: roi.width, height: roi.height, data };
    let mask = plane(mask_bytes.iter().map(|v| f32::from(*v)).collect());
    // An arm, where the mask does not show the object, hides what lies below and the border there.
    let hidden = |at: usize| classes[at] >= arm::MASK && mask_bytes[at] == 0;
    let clear = plane((0..roi.area()).map(|at| f32::from(u8::from(!hidden(at)))).collect()).blurred(2.5)?;
    let border_trust = plane(clear.data.iter().map(|v| ((v - 0.9) / 0.1).clamp(0.0, 1.0)).collect());
    let texture_trust = mask.blurred(1.0)?;
    let soft_mask = mask.blurred(1.5)?;
    let wide_mask = mask.blurred(4.0)?;
    let gray = roi.crop_plane(&seen.view.gray_plane).blurred(0.8)?;
    let shift = |x: f64, y: f64| Matrix3::new(1.0, 0.0, x, 0.0, 1.0, y, 0.0, 0.0, 1.0);
    let into = shift(-(roi.x as f64), -(roi.y as f64));
    let outline = |target| AlignChannel {
        points: &key.outline,
        target,
        trust: Some(&border_trust),
        scale: 0.35,
        strength: 60.0,
        photometric: false,
    };
    let texture = AlignChannel {
        points: &key.texture,
        target: &gray,
        trust: Some(&texture_trust),
        scale: 14.0,
        strength: 60.0,
        photometric: true,
    };
    let affine = if params.affine { 1.0 } else { 0.0 };
    let loose =
        AlignPrior { shift: 0.4, scale: 0.05, rotation: 0.1, affine: 0.05 * affine, perspective: 0.0 };
    let tight =
        AlignPrior { shift: 0.12, scale: 0.03, rotation: 0.05, affine: 0.06 * affine, perspective: 0.0 };
    let (start, centre, radius) = (into * predicted, key.centre, key.radius);
    let fine = |start: &Matrix3<f64>| {
        align(&[texture_ref(&texture), outline(&soft_mask)], start, centre, radius, &tight, 12)
    };
    // The outline alone helps when prediction was off, or when the object shows another side and its
    // texture no longer fits: take whichever explains the visible part best.
    let coarse = align(&[outline(&wide_mask)], &start, centre, radius, &loose, 8);
    let outlined = align(&[outline(&soft_mask)], &coarse.transform, centre, radius, &tight, 8);
    let rate = |candidate: &Alignment| -> opencv::Result<(f64, f64)> {
        let placed = key.place(&(shift(roi.x as f64, roi.y as f64) * candidate.transform), &roi)?;
        let overlap = visible_overlap(&placed, &mask, &clear);
        Ok((overlap, overlap + 0.3 * candidate.agreement * candidate.seen))
    };
    let mut best: Option<((f64, f64), Alignment)> = None;
    let mut consider = |candidate: Alignment| -> opencv::Result<f64> {
        let rating = rate(&candidate)?;
        if best.as_ref().is_none_or(|(other, _)| rating.1 > other.1 + 0.01) {
            best = Some((rating, candidate));
        }
        Ok(best.as_ref().map_or(0.0, |(rating, _)| rating.0))
    };
    consider(fine(&start))?;
    consider(fine(&coarse.transform))?;
    if consider(outlined)? < 0.86 {
        let placed = key.place(predicted, &roi)?;
        let moved = by_moments(&placed, &mask, &clear) * start;
        let outlined = align(&[outline(&wide_mask)], &moved, centre, radius, &loose, 8);
        consider(align(&[outline(&soft_mask)], &outlined.transform, centre, radius, &tight, 8))?;
        consider(fine(&outlined.transform))?;
    }
    let Some((_, found)) = best else { return Ok(fallback) };
    let back = shift(roi.x as f64, roi.y as f64);
    let transform = back * found.transform;
    let ramp = |value: f64, low: f64, high: f64| ((value - low) / (high - low)).clamp(0.0, 1.0);
    let evidence = ramp(found.agreement, 0.35, 0.75) * ramp(visible, 0.05, 0.4);
    let visible = (area / area_of(key, &transform)).min(1.0);
    Ok(Located { transform, evidence, visible, predicted: *predicted })
}

fn texture_ref<'a>(channel: &AlignChannel<'a>) -> AlignChannel<'a> {
    AlignChannel { points: channel.points, target: channel.target, trust: channel.trust, ..*channel }
}

/// IoU of the placed shape and the mask where no arm hides either.
fn visible_overlap(placed: &Plane, mask: &Plane, clear: &Plane) -> f64 {
    let (mut both, mut either) = (0.0, 0.0);
    for ((p, m), c) in placed.data.iter().zip(&mask.data).zip(&clear.data) {
        both += f64::from(p.min(*m) * c);
        either += f64::from(p.max(*m) * c);
    }
    both / f64::max(either, 1.0)
}

/// The shift and, where most is clear, the scale that take the placed shape's visible part to the mask.
fn by_moments(placed: &Plane, mask: &Plane, clear: &Plane) -> Matrix3<f64> {
    let moments = |plane: &Plane| {
        let (mut weight, mut x, mut y) = (1e-9, 0.0, 0.0);
        for (at, (value, clear)) in plane.data.iter().zip(&clear.data).enumerate() {
            let w = f64::from(value * clear);
            weight += w;
            x += w * (at % plane.width) as f64;
            y += w * (at / plane.width) as f64;
        }
        (weight, x / weight, y / weight)
    };
    let ((area, x, y), (area_mask, x_mask, y_mask)) = (moments(placed), moments(mask));
    let whole: f64 = placed.data.iter().map(|v| f64::from(*v)).sum();
    let scale = if area > 0.75 * whole { (area_mask / area).sqrt().clamp(0.75, 1.33) } else { 1.0 };
    Matrix3::new(scale, 0.0, x_mask - scale * x, 0.0, scale, y_mask - scale * y, 0.0, 0.0, 1.0)
}

/// Pixels of the full shape under a transform.
fn area_of(key: &Keyframe, transform: &Matrix3<f64>) -> f64 {
    let linear = transform[(0, 0)] * transform[(1, 1)] - transform[(0, 1)] * transform[(1, 0)];
    (key.area * linear.abs()).max(1.0)
}

/// After a stretch without evidence, what prediction had drifted by is shared out over the stretch.
fn spread_correction(located: &mut [Located], key: &Keyframe, found: &Located) {
    let blind = located.iter().rev().take_while(|l| l.evidence < 0.2).count();
    let at = |m: &Matrix3<f64>| apply(m, key.centre.0, key.centre.1);
    let (wrong, right) = (at(&found.predicted), at(&found.transform));
    let (dx, dy) = (right.0 - wrong.0, right.1 - wrong.1);
    let angle = |m: &Matrix3<f64>| m[(1, 0)].atan2(m[(0, 0)]);
    let turn = angle(&found.transform) - angle(&found.predicted);
    let turn = turn.sin().atan2(turn.cos());
    let start = located.len() - blind;
    for (k, entry) in located[start..].iter_mut().enumerate() {
        let share = (k + 1) as f64 / (blind + 1) as f64;
        let centre = at(&entry.transform);
        let (sin, cos) = (share * turn).sin_cos();
        let (tx, ty) = (centre.0 + share * dx, centre.1 + share * dy);
        let rotate = Matrix3::new(
            cos,
            -sin,
            tx - cos * centre.0 + sin * centre.1,
            sin,
            cos,
            ty - sin * centre.0 - cos * centre.1,
            0.0,
            0.0,
            1.0,
        );
        entry.transform = rotate * entry.transform;
    }
}
