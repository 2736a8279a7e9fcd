//! Where the object's full shape lies on every frame.
//!
//! From the clean frame one sweep runs to each end of the clip. Flow and the last motion predict;
//! direct alignment against the clean frame itself, never against the frame before, measures: the
//! texture where the object is visible, and the mask's border where no arm hides it. What both say
//! about the whole clip is then weighed together (see [`path`]).

use std::sync::Arc;

use nalgebra::{Matrix2, Matrix3, Matrix4, SMatrix, Vector4};
use opencv::core::MatTraitConstManual;

use super::{
    TemplateError, TemplateParams,
    carry::{Carried, Hands, step},
    path::{self, Step},
};
use crate::{
    clip::FrameIndex,
    segment::{
        MaskFlag, MaskTrack,
        object::{Keyframe, Roi, Scene, View, apply, arm},
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
    /// How well the placement explains the frame.
    pub rating: f64,
    /// What the frame says about the centre, size and turn: the inverse covariance of
    /// [`Pose::vector`](super::pose::Pose::vector).
    pub information: Matrix4<f64>,
}

impl Located {
    /// The clean frame itself, which is right by definition.
    fn own() -> Self {
        Self {
            transform: Matrix3::identity(),
            evidence: 1.0,
            visible: 1.0,
            rating: 1.3,
            information: Matrix4::from_diagonal(&Vector4::new(1e4, 1e4, 1e8, 1e8)),
        }
    }
}

/// A frame with its object mask, work scale.
pub(super) struct Seen {
    pub view: View,
    pub mask: Vec<u8>,
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
    let Some(key) = Keyframe::new(&start.view, shape)? else { return Ok(vec![Located::own(); count]) };
    let start = Arc::new(start);
    let after: Vec<usize> = (here + 1..count).collect();
    let before: Vec<usize> = (0..here).rev().collect();
    let run = |targets: &[usize]| sweep(scene, object, &key, (clean, &start), targets, params);
    let (after, before) = rayon::join(|| run(&after), || run(&before));
    let (after, before) = (after?, before?);
    // Steps lead from frame k to k + 1; the backward sweep measured the way back.
    let mut steps: Vec<Step> = before.iter().rev().map(|(_, step)| step.reversed()).collect();
    steps.extend(after.iter().map(|(_, step)| *step));
    let mut located: Vec<Located> = before.into_iter().rev().map(|(entry, _)| entry).collect();
    located.push(Located::own());
    located.extend(after.into_iter().map(|(entry, _)| entry));
    if params.smoothing > 0 {
        path::smooth(&mut located, &steps, key.centre, key.radius);
    }
    Ok(located)
}

fn sweep(
    scene: &Scene<'_>,
    object: &MaskTrack,
    key: &Keyframe,
    start: (FrameIndex, &Arc<Seen>),
    targets: &[usize],
    params: &TemplateParams,
) -> Result<Vec<(Located, Step)>, TemplateError> {
    let (mut before, mut previous) = (start.0, Arc::clone(start.1));
    let mut transform = Matrix3::identity();
    let mut carried = Carried::default();
    let mut spread = Matrix4::from_diagonal_element(1e-6);
    let mut located = Vec::with_capacity(targets.len());
    for target in targets {
        scene.watch.check()?;
        let index = FrameIndex(*target as u32);
        let seen = Arc::new(Seen::load(scene, object, index)?);
        let hands = [before, index].map(|at| scene.landmarks.get(at.as_usize()));
        let hands = Hands { scale: &scene.scale, before: hands[0], after: hands[1] };
        let steps = step(key, &previous, &seen, &transform, &hands, &mut carried)?;
        let mut best: Option<(Located, Step, Matrix4<f64>)> = None;
        for step in steps {
            // Another motion than the likeliest has to explain the frame clearly better.
            let other = step.transform * transform;
            if best.as_ref().is_some_and(|(_, first, _)| near(key, &(first.transform * transform), &other)) {
                continue;
            }
            let spread = spread + step.precision().try_inverse().unwrap_or_else(Matrix4::zeros);
            let found = measure(key, &seen, &other, &spread, params)?;
            if best.as_ref().is_none_or(|(kept, _, _)| found.rating > kept.rating + 0.03) {
                best = Some((found, step, spread));
            }
        }
        let Some((mut found, step, wider)) = best else { continue };
        spread = wider;
        let predicted = step.transform * transform;
        if !found.transform.iter().all(|v| v.is_finite()) {
            found = Located { transform: predicted, evidence: 0.0, ..found };
            found.information = Matrix4::zeros();
        }
        if let Some(known) = spread.try_inverse()
            && let Some(narrower) = (known + found.information).try_inverse()
        {
            spread = narrower;
        }
        transform = found.transform;
        located.push((found, step));
        (before, previous) = (index, seen);
    }
    Ok(located)
}

/// Whether two placements are much the same.
fn near(key: &Keyframe, a: &Matrix3<f64>, b: &Matrix3<f64>) -> bool {
    let (x, y) = key.centre;
    let corners = [(x - key.radius, y), (x + key.radius, y), (x, y + key.radius)];
    corners.iter().all(|(x, y)| {
        let (a, b) = (apply(a, *x, *y), apply(b, *x, *y));
        (a.0 - b.0).hypot(a.1 - b.1) < 1.0
    })
}

/// Aligns the clean view to a frame. `spread` is the covariance of the prediction's
/// [`Pose::vector`](super::pose::Pose::vector).
fn measure(
    key: &Keyframe,
    seen: &Seen,
    predicted: &Matrix3<f64>,
    spread: &Matrix4<f64>,
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
    let fallback =
        Located { transform: *predicted, evidence: 0.0, visible, rating: 0.0, information: Matrix4::zeros() };
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
    let radius_here = key.radius * (area_of(key, predicted) / key.area).sqrt();
    let deviation = |low: usize, high: usize| spread[(low, low)].max(spread[(high, high)]).max(0.0).sqrt();
    // What little is seen of a hidden object cannot tell its shape from its place.
    let whole = ramp(visible, 0.5, 0.9);
    let tight = AlignPrior {
        shift: (2.0 * deviation(0, 1) / radius_here).clamp(0.12, 0.3),
        scale: 0.003 + 0.027 * whole,
        rotation: deviation(3, 3).clamp(0.01, 0.08),
        affine: affine * (0.01 + 0.05 * whole),
        perspective: 0.0,
    };
    let (start, centre, radius) = (into * predicted, key.centre, key.radius);
    let fine = |start: &Matrix3<f64>, prior: &AlignPrior| {
        align(&[texture_ref(&texture), outline(&soft_mask)], start, centre, radius, prior, 12)
    };
    let back = shift(roi.x as f64, roi.y as f64);
    let rate = |candidate: &Alignment| -> opencv::Result<(f64, f64)> {
        let placed = key.place(&(back * candidate.transform), &roi)?;
        let overlap = visible_overlap(&placed, &mask, &clear);
        Ok((overlap, overlap + 0.3 * candidate.agreement * candidate.seen))
    };
    let mut best = fine(&start, &tight);
    let mut rating = rate(&best)?;
    // Where most of the object is seen, or prediction says nothing, the outline may move it further:
    // prediction was off, or the object shows another side and its texture no longer fits.
    let lost = deviation(0, 1) > 0.35 * radius_here;
    if rating.0 < 0.97 || lost {
        let loose = AlignPrior {
            shift: 0.4,
            scale: 0.003 + 0.047 * whole,
            rotation: 0.02 + 0.08 * whole,
            affine: affine * 0.05 * whole,
            perspective: 0.0,
        };
        let near = AlignPrior { shift: 0.12, ..loose };
        let coarse = align(&[outline(&wide_mask)], &start, centre, radius, &loose, 8);
        let mut candidates = vec![
            fine(&coarse.transform, &near),
            align(&[outline(&soft_mask)], &coarse.transform, centre, radius, &near, 8),
        ];
        if rating.0 < 0.86 {
            let placed = key.place(predicted, &roi)?;
            let moved = by_moments(&placed, &mask, &clear) * start;
            let outlined = align(&[outline(&wide_mask)], &moved, centre, radius, &loose, 8);
            candidates.push(align(&[outline(&soft_mask)], &outlined.transform, centre, radius, &near, 8));
            candidates.push(fine(&outlined.transform, &near));
        }
        for candidate in candidates {
            let other = rate(&candidate)?;
            if other.1 > rating.1 + 0.01 {
                (best, rating) = (candidate, other);
            }
        }
    }
    let transform = back * best.transform;
    let sound = ramp(best.agreement, 0.35, 0.75) * ramp(rating.0, 0.4, 0.8);
    let information = information(&best, &transform, radius, affine) * sound;
    let evidence = sound * ramp(visible, 0.05, 0.4);
    let visible = (area / area_of(key, &transform)).min(1.0);
    Ok(Located { transform, evidence, visible, rating: rating.1, information })
}

/// What an alignment says about [`Pose::vector`](super::pose::Pose::vector), aspect and shear left open.
fn information(found: &Alignment, transform: &Matrix3<f64>, radius: f64, affine: f64) -> Matrix4<f64> {
    let order = [4, 5, 0, 1, 2, 3];
    let n = SMatrix::<f64, 6, 6>::from_fn(|r, c| found.information[(order[r], order[c])]);
    let mut own = n.fixed_view::<4, 4>(0, 0).into_owned();
    if affine > 0.0 {
        let open = n.fixed_view::<2, 2>(4, 4).into_owned() + Matrix2::from_diagonal_element(400.0);
        if let Some(inverse) = open.try_inverse() {
            let across = n.fixed_view::<4, 2>(0, 4).into_owned();
            own -= across * inverse * across.transpose();
        }
    }
    // Shifts are in radii along the template's axes.
    let linear = transform.fixed_view::<2, 2>(0, 0).into_owned() * radius;
    let Some(inverse) = linear.try_inverse() else { return Matrix4::zeros() };
    let mut change = Matrix4::identity();
    change.fixed_view_mut::<2, 2>(0, 0).copy_from(&inverse);
    change.transpose() * own * change
}

fn ramp(value: f64, low: f64, high: f64) -> f64 {
    ((value - low) / (high - low)).clamp(0.0, 1.0)
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
