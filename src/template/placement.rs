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
        object::{Keyframe, Roi, Scene, View, arm, bounds_of, turned_about},
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
    let sweeps = Sweeps { scene, object, key: &key, params };
    let run = |targets: &[usize]| sweeps.there_and_back((clean, &start), targets);
    let (after, before) = rayon::join(|| run(&after), || run(&before));
    let (after, before) = (after?, before?);
    // Steps lead from frame k to k + 1; the backward sweep measured the way back.
    let mut steps: Vec<Step> = before.iter().rev().map(|found| found.step.reversed()).collect();
    steps.extend(after.iter().map(|found| found.step));
    let mut located: Vec<Located> = before.into_iter().rev().map(|found| found.located).collect();
    located.push(Located::own());
    located.extend(after.into_iter().map(|found| found.located));
    if params.smoothing > 0 {
        path::smooth(&mut located, &steps, key.centre, key.radius);
    }
    Ok(located)
}

/// What a sweep found on one frame.
#[derive(Clone, Copy)]
struct Found {
    located: Located,
    /// From the frame swept before to this one.
    step: Step,
    /// Standard deviation of the centre before the frame was looked at, radii of the template.
    doubt: f64,
}

impl Found {
    /// Whether the frame alone fixes the placement: sweeps may start here.
    fn is_anchor(&self) -> bool {
        self.located.evidence > 0.8 && self.located.visible > 0.85 && self.located.rating > 1.1
    }

    /// How far to believe it.
    fn worth(&self) -> f64 {
        self.located.rating - 0.25 * self.doubt.min(1.0)
    }
}

/// What sweeps over frames read.
struct Sweeps<'a> {
    scene: &'a Scene<'a>,
    object: &'a MaskTrack,
    key: &'a Keyframe,
    params: &'a TemplateParams,
}

impl Sweeps<'_> {
    /// Sweeps from `start` over `targets`; where the object comes out of hiding again, sweeps back to
    /// where it went into hiding, and keeps the better of both: after a thing was put down, what is
    /// seen later tells more of where it lies than what was seen before it was taken up.
    fn there_and_back(
        &self,
        start: (FrameIndex, &Arc<Seen>),
        targets: &[usize],
    ) -> Result<Vec<Found>, TemplateError> {
        let mut found = self.sweep(start, &Matrix3::identity(), targets)?;
        let mut open = None;
        for at in 0..found.len() {
            if !found[at].is_anchor() {
                open = open.or(Some(at));
                continue;
            }
            if let Some(first) = open.take() {
                let index = FrameIndex(targets[at] as u32);
                let seen = Arc::new(Seen::load(self.scene, self.object, index)?);
                let way: Vec<usize> = targets[first..at].iter().rev().copied().collect();
                let back = self.sweep((index, &seen), &found[at].located.transform, &way)?;
                merge(&mut found[first..=at], &back);
            }
        }
        Ok(found)
    }

    /// Sweeps from `start`, where the object lies at `transform`, over `targets`.
    fn sweep(
        &self,
        start: (FrameIndex, &Arc<Seen>),
        transform: &Matrix3<f64>,
        targets: &[usize],
    ) -> Result<Vec<Found>, TemplateError> {
        let (mut before, mut previous) = (start.0, Arc::clone(start.1));
        let mut transform = *transform;
        let mut carried = Carried::default();
        let mut spread = Matrix4::from_diagonal_element(1e-6);
        let mut all = Vec::with_capacity(targets.len());
        for target in targets {
            self.scene.watch.check()?;
            let index = FrameIndex(*target as u32);
            let seen = Arc::new(Seen::load(self.scene, self.object, index)?);
            let hands = [before, index].map(|at| self.scene.landmarks.get(at.as_usize()));
            let hands = Hands { scale: &self.scene.scale, before: hands[0], after: hands[1] };
            let steps = step(self.key, &previous, &seen, &transform, &hands, &mut carried)?;
            let (found, wider) = self.likeliest(&steps, &seen, &transform, &spread)?;
            spread = wider;
            if let Some(known) = spread.try_inverse()
                && let Some(narrower) = (known + found.located.information).try_inverse()
            {
                spread = narrower;
            }
            transform = found.located.transform;
            all.push(found);
            (before, previous) = (index, seen);
        }
        Ok(all)
    }

    /// What the likeliest of `steps` leads to, and the covariance of its prediction.
    fn likeliest(
        &self,
        steps: &[Step],
        seen: &Seen,
        transform: &Matrix3<f64>,
        spread: &Matrix4<f64>,
    ) -> Result<(Found, Matrix4<f64>), TemplateError> {
        let key = self.key;
        let mut best: Option<(Found, Matrix4<f64>)> = None;
        for step in steps {
            // Another motion than the likeliest has to explain the frame clearly better.
            let other = step.transform * transform;
            let first = best.as_ref().map(|(found, _)| found.step.transform * transform);
            if first.is_some_and(|first| key.near(&first, &other, 1.0)) {
                continue;
            }
            let spread = spread + step.precision().try_inverse().unwrap_or_else(Matrix4::zeros);
            let located = measure(key, seen, &other, &spread, self.params)?;
            if best.as_ref().is_none_or(|(kept, _)| located.rating > kept.located.rating + 0.02) {
                let doubt = (spread[(0, 0)] + spread[(1, 1)]).max(0.0).sqrt() / key.radius;
                best = Some((Found { located, step: *step, doubt }, spread));
            }
        }
        let still = Step { transform: Matrix3::identity(), shift: 3.0, form: 0.02 };
        let (mut found, wider) = best.unwrap_or_else(|| {
            let located = Located { transform: *transform, evidence: 0.0, ..Located::own() };
            (Found { located, step: still, doubt: 1.0 }, *spread)
        });
        if !found.located.transform.iter().all(|v| v.is_finite()) {
            found.located.transform = found.step.transform * transform;
            (found.located.evidence, found.located.information) = (0.0, Matrix4::zeros());
        }
        Ok((found, wider))
    }
}

/// Takes over from the way `back` what is worth more than the way there. `there` ends with the anchor
/// that `back` starts from.
fn merge(there: &mut [Found], back: &[Found]) {
    let last = there.len() - 1;
    for (way, found) in back.iter().enumerate() {
        let at = last - 1 - way;
        if found.worth() > there[at].worth() {
            there[at].located = found.located;
            there[at].doubt = found.doubt;
            // The step measured on the way back leads from the frame after.
            there[at + 1].step = found.step.reversed();
        }
    }
}

/// Pictures of one frame that the clean view is aligned to, inside a rectangle of it.
struct Target {
    roi: Roi,
    /// Pixels of the mask in the rectangle.
    area: f64,
    mask: Plane,
    /// 0 where an arm hides what lies below, 1 well away from there.
    clear: Plane,
    border_trust: Plane,
    texture_trust: Plane,
    soft_mask: Plane,
    wide_mask: Plane,
    gray: Plane,
}

impl Target {
    fn new(key: &Keyframe, seen: &Seen, predicted: &Matrix3<f64>) -> Result<Self, TemplateError> {
        let (width, height) = (seen.view.width, seen.view.height);
        let margin = (0.5 * key.radius).max(24.0);
        let mut roi = Roi::around(key.bounds(predicted), margin, width, height);
        if let Some(b) = bounds_of(&seen.mask, width) {
            roi = roi.union(&Roi::around(b, margin, width, height));
        }
        let bytes = roi.crop(&seen.mask, width);
        let classes = roi.crop(&seen.view.arms, width);
        let plane = |data: Vec<f32>| Plane { width: roi.width, height: roi.height, data };
        let mask = plane(bytes.iter().map(|v| f32::from(*v)).collect());
        // An arm, where the mask does not show the object, hides what lies below and the border there.
        let open = |at: usize| f32::from(u8::from(classes[at] < arm::MASK || bytes[at] != 0));
        let clear = plane((0..roi.area()).map(open).collect()).blurred(2.5)?;
        let border = clear.data.iter().map(|v| ((v - 0.9) / 0.1).clamp(0.0, 1.0)).collect();
        Ok(Self {
            area: bytes.iter().filter(|v| **v != 0).count() as f64,
            border_trust: plane(border),
            texture_trust: mask.blurred(1.0)?,
            soft_mask: mask.blurred(1.5)?,
            wide_mask: mask.blurred(4.0)?,
            gray: roi.crop_plane(&seen.view.gray_plane).blurred(0.8)?,
            clear,
            mask,
            roi,
        })
    }

    fn outline<'a>(&'a self, key: &'a Keyframe, target: &'a Plane) -> AlignChannel<'a> {
        AlignChannel {
            points: &key.outline,
            target,
            trust: Some(&self.border_trust),
            scale: 0.35,
            // A thing that turns shows other texture within the same outline: the outline rules.
            strength: 300.0,
            photometric: false,
        }
    }

    fn texture<'a>(&'a self, key: &'a Keyframe) -> AlignChannel<'a> {
        AlignChannel {
            points: &key.texture,
            target: &self.gray,
            trust: Some(&self.texture_trust),
            scale: 14.0,
            strength: 60.0,
            photometric: true,
        }
    }

    /// The IoU with the mask, and that with the agreement of texture and outline on top.
    fn rate(&self, key: &Keyframe, found: &Alignment) -> opencv::Result<(f64, f64)> {
        let placed = key.place(&(self.offset() * found.transform), &self.roi)?;
        let overlap = visible_overlap(&placed, &self.mask, &self.clear);
        Ok((overlap, overlap + 0.3 * found.agreement * found.seen))
    }

    /// Pixels of the rectangle to those of the frame.
    fn offset(&self) -> Matrix3<f64> {
        Matrix3::new(1.0, 0.0, self.roi.x as f64, 0.0, 1.0, self.roi.y as f64, 0.0, 0.0, 1.0)
    }
}

/// How much of what is seen of a hidden object is believed over what its motion between frames is
/// guessed to be.
const HIDDEN_WEIGHT: f64 = 4.0;

/// Aligns the clean view to a frame. `spread` is the covariance of the prediction's
/// [`Pose::vector`](super::pose::Pose::vector).
fn measure(
    key: &Keyframe,
    seen: &Seen,
    predicted: &Matrix3<f64>,
    spread: &Matrix4<f64>,
    params: &TemplateParams,
) -> Result<Located, TemplateError> {
    let target = Target::new(key, seen, predicted)?;
    let visible = (target.area / area_of(key, predicted)).min(1.0);
    if !seen.trusted || target.area < 40.0 {
        let visible = if target.area < 40.0 { 0.0 } else { visible };
        let (evidence, rating, information) = (0.0, 0.0, Matrix4::zeros());
        return Ok(Located { transform: *predicted, evidence, visible, rating, information });
    }
    let radius_here = key.radius * (area_of(key, predicted) / key.area).sqrt();
    let deviation = |low: usize, high: usize| spread[(low, low)].max(spread[(high, high)]).max(0.0).sqrt();
    // What little is seen of a hidden object cannot tell its shape from its place.
    let affine = if params.affine { ramp(visible, 0.8, 0.97) } else { 0.0 };
    let prior = AlignPrior {
        shift: (2.0 * deviation(0, 1) / radius_here).clamp(0.1, 0.3),
        scale: deviation(2, 2).clamp(0.015, 0.03),
        rotation: deviation(3, 3).clamp(0.02, 0.08),
        affine: 0.06 * affine,
        perspective: 0.0,
    };
    let start = shifted_back(&target.roi) * predicted;
    let both = [target.texture(key), target.outline(key, &target.soft_mask)];
    let mut best = align(&both, &start, key.centre, key.radius, &prior, 10);
    let mut rating = target.rate(key, &best)?;
    // Where most of the object is seen, or prediction says nothing, the outline may move it further:
    // prediction was off, or the object shows another side and its texture no longer fits.
    let lost = deviation(0, 1) > 0.35 * radius_here;
    if rating.0 < 0.97 || lost {
        for candidate in candidates(key, &target, predicted, visible, affine, rating.0 < 0.97)? {
            let other = target.rate(key, &candidate)?;
            if other.1 > rating.1 + 0.01 {
                (best, rating) = (candidate, other);
            }
        }
    }
    let transform = target.offset() * best.transform;
    let sound = ramp(best.agreement, 0.35, 0.75) * ramp(rating.0, 0.4, 0.8);
    let weight = HIDDEN_WEIGHT + (1.0 - HIDDEN_WEIGHT) * ramp(visible, 0.6, 0.9);
    let information = information(&best, &transform, key.radius, affine) * sound * weight;
    let evidence = sound * ramp(visible, 0.05, 0.4);
    let visible = (target.area / area_of(key, &transform)).min(1.0);
    Ok(Located { transform, evidence, visible, rating: rating.1, information })
}

/// Alignments from further away than the prediction allows; `off`: the prediction does not fit.
fn candidates(
    key: &Keyframe,
    target: &Target,
    predicted: &Matrix3<f64>,
    visible: f64,
    affine: f64,
    off: bool,
) -> Result<Vec<Alignment>, TemplateError> {
    let whole = ramp(visible, 0.5, 0.9);
    let loose = AlignPrior {
        shift: 0.4,
        scale: 0.015 + 0.035 * whole,
        rotation: 0.02 + 0.08 * whole,
        affine: 0.05 * affine,
        perspective: 0.0,
    };
    let near = AlignPrior { shift: 0.12, ..loose };
    let (wide, soft) = (target.outline(key, &target.wide_mask), target.outline(key, &target.soft_mask));
    let (wide, soft, both) = ([wide], [soft], [target.texture(key), target.outline(key, &target.soft_mask)]);
    let fit = |channels: &[AlignChannel<'_>], start: &Matrix3<f64>, prior: &AlignPrior, iterations: usize| {
        align(channels, start, key.centre, key.radius, prior, iterations)
    };
    let start = shifted_back(&target.roi) * predicted;
    let coarse = fit(&wide, &start, &loose, 8).transform;
    let mut found = vec![fit(&both, &coarse, &near, 10), fit(&soft, &coarse, &near, 8)];
    if off {
        let placed = key.place(predicted, &target.roi)?;
        let moved = by_moments(&placed, &target.mask, &target.clear) * start;
        let outlined = fit(&wide, &moved, &loose, 8).transform;
        found.extend([fit(&soft, &outlined, &near, 8), fit(&both, &outlined, &near, 10)]);
        if let Some(seen) = target.mask.moments().filter(|_| visible < 0.8) {
            let turned = [-0.15, 0.15].map(|angle| turned_about(seen.centre, angle) * moved);
            found.extend(turned.iter().map(|start| fit(&both, start, &near, 8)));
        }
    }
    Ok(found)
}

/// Pixels of a frame to those of a rectangle of it.
fn shifted_back(roi: &Roi) -> Matrix3<f64> {
    Matrix3::new(1.0, 0.0, -(roi.x as f64), 0.0, 1.0, -(roi.y as f64), 0.0, 0.0, 1.0)
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
