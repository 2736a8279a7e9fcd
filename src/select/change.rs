//! What a hand took away or put down: places that show something else before than after.

use opencv::{
    core::{Mat, MatTraitConstManual},
    imgproc,
};

use super::{
    SelectError,
    arm_colours::ArmColours,
    places::{compactness, difference, distance, divided, threshold, without_shadow},
    scene::{Scene, mapped},
    timeline::{Ends, Timeline},
};
use crate::{
    geometry::Pixel,
    vision::{ColourModel, binary},
};

/// Lab distance (lightness halved) from which on a place surely shows something else.
const SURE: f32 = 14.0;
/// Distance from which on it shows something else if a sure place is near.
const LIKELY: f32 = 8.0;

/// A place where something was at one end of a stretch of time and is not at the other.
pub(super) struct Change {
    /// CV_8UC1 on the grid of `reference`: the object's pixels.
    pub mask: Mat,
    /// Position in the scene's samples on which the object lies there.
    pub reference: usize,
    /// Whether it lay there at first: taken away; otherwise put down.
    pub taken: bool,
    /// How well contours at that end agree with the changed place, against the other end, 0 to 1.
    pub outline: f64,
    /// How sudden and lasting the change is, 0 to 1.
    pub lasting: f64,
    /// How near a hand came at the time, 0 to 1.
    pub touched: f64,
    /// How much it looks like an arm, 0 to 1.
    pub arm_like: f64,
    /// Share of its rim that was not seen at both ends.
    pub cut_off: f64,
    /// Share of the changed place that no shadow explains, 0 to 1.
    pub solid: f64,
    /// Share of its convex hull that it fills, 0 to 1.
    pub compact: f64,
    /// Area in squares of the palm's width.
    pub relative_area: f64,
    /// Its colours.
    pub colours: ColourModel,
    /// Samples between which it changed.
    pub when: (usize, usize),
}

/// Everything taken away (the timeline's reference is the first of `samples`) or put down (it is the last).
pub(super) fn changes(
    scene: &Scene<'_>,
    samples: &[usize],
    timeline: &Timeline,
    arms: &ArmColours,
) -> Result<Vec<Change>, SelectError> {
    let reference = timeline.reference;
    if timeline.shown.len() < 3 {
        return Ok(Vec::new());
    }
    let ends = timeline.ends();
    let taken = samples.first() == Some(&reference);
    let difference = difference(&ends, timeline.columns, LIKELY);
    let palm = palm_width(scene, samples);
    let sure = threshold(&difference, timeline.columns, SURE)?;
    let likely = binary::closed(&threshold(&difference, timeline.columns, LIKELY)?, 1)?;
    let sure = binary::opened(&sure, 1)?;
    let grown = binary::opened(&binary::touching(&likely, &sure)?, 1)?;
    let (found, labels) = binary::components(&grown)?;
    let total = timeline.area() as f64;
    let mut changes = Vec::new();
    for component in &found {
        let area = f64::from(component.area);
        if area < (0.03 * palm * palm).max(12.0) || area > 0.3 * total {
            continue;
        }
        let keep: Vec<bool> = (0..=found.len()).map(|label| label as i32 == component.label).collect();
        let around = binary::by_label(&grown, &labels, &keep)?;
        let evidence = Evidence { scene, timeline, ends: &ends, taken, palm };
        for around in divided(&around, &ends, taken)? {
            let (mask, solid) = without_shadow(&around, &ends, taken)?;
            if let Some(change) = evidence.change(mask, solid, arms)? {
                changes.push(change);
            }
        }
    }
    Ok(changes)
}

fn palm_width(scene: &Scene<'_>, samples: &[usize]) -> f64 {
    let hands = samples.iter().flat_map(|at| &scene.samples[*at].hands);
    let mut widths: Vec<f64> = hands.map(|hand| hand.palm_width).collect();
    widths.sort_unstable_by(f64::total_cmp);
    widths.get(widths.len() / 2).copied().unwrap_or(0.12 * f64::from(scene.scale.work.width))
}

/// What counts as touch where no hand was found at the time.
const UNSEEN_HAND: f64 = 0.6;

struct Evidence<'a> {
    scene: &'a Scene<'a>,
    timeline: &'a Timeline,
    ends: &'a Ends,
    taken: bool,
    palm: f64,
}

impl Evidence<'_> {
    fn change(&self, mask: Mat, solid: f64, arms: &ArmColours) -> Result<Option<Change>, SelectError> {
        let pixels: Vec<usize> =
            mask.data_bytes()?.iter().enumerate().filter(|(_, v)| **v != 0).map(|(at, _)| at).collect();
        let here = if self.taken { &self.ends.first } else { &self.ends.last };
        let colours: Vec<[u8; 3]> = pixels.iter().filter_map(|at| here[*at]).collect();
        let Some(model) = ColourModel::learn(colours.iter().map(|lab| (*lab, 1.0))) else { return Ok(None) };
        let (own, other, cut_off) = self.rim(&mask)?;
        let outline = ((own - other) / (own + other).max(4.0)).clamp(-1.0, 1.0);
        if outline < 0.0 {
            return Ok(None);
        }
        let (lasting, when) = self.step(&pixels);
        let touched = self.touched(&mask, when)?;
        let compact = compactness(&mask)?;
        Ok(Some(Change {
            relative_area: pixels.len() as f64 / (self.palm * self.palm),
            arm_like: arms.share_then(&colours, self.taken, when),
            reference: self.timeline.reference,
            taken: self.taken,
            colours: model,
            mask,
            solid,
            compact,
            outline,
            lasting,
            touched,
            cut_off,
            when,
        }))
    }

    /// Mean colour step across the mask's rim with and without the object, and the share of the rim that is
    /// not known.
    fn rim(&self, mask: &Mat) -> opencv::Result<(f64, f64, f64)> {
        let (inner, outer) = (binary::eroded(mask, 1)?, binary::dilated(mask, 2)?);
        let columns = self.timeline.columns as i64;
        let rows = self.timeline.area() as i64 / columns;
        let (mask, inner, outer) = (mask.data_bytes()?, inner.data_bytes()?, outer.data_bytes()?);
        let (here, there) = if self.taken {
            (&self.ends.first, &self.ends.last)
        } else {
            (&self.ends.last, &self.ends.first)
        };
        let (mut own, mut other, mut known, mut unknown) = (0.0, 0.0, 0_u32, 0_u32);
        for at in (0..mask.len()).filter(|at| mask[*at] != 0 && inner[*at] == 0) {
            let (x, y) = (at as i64 % columns, at as i64 / columns);
            for (dx, dy) in [(3, 0), (-3, 0), (0, 3), (0, -3)] {
                let (u, v) = (x + dx, y + dy);
                if u < 0 || v < 0 || u >= columns || v >= rows {
                    unknown += 1;
                    continue;
                }
                let out = (v * columns + u) as usize;
                if outer[out] != 0 {
                    continue;
                }
                if let (Some(a), Some(b), Some(c), Some(d)) = (here[at], here[out], there[at], there[out]) {
                    own += f64::from(distance(a, b));
                    other += f64::from(distance(c, d));
                    known += 1;
                } else {
                    unknown += 1;
                }
            }
        }
        let count = f64::from(known.max(1));
        Ok((own / count, other / count, f64::from(unknown) / f64::from((known + unknown).max(1))))
    }

    /// How well one moment divides sights of the first colours from sights of the last ones, 0 to 1, and
    /// the samples on either side of it.
    fn step(&self, pixels: &[usize]) -> (f64, (usize, usize)) {
        let mut sights = Vec::new();
        for shown in &self.timeline.shown {
            let (mut first, mut seen) = (0_u32, 0_u32);
            for at in pixels.iter().filter(|at| shown.known[**at]) {
                let (Some(a), Some(b)) = (self.ends.first[*at], self.ends.last[*at]) else { continue };
                seen += 1;
                first += u32::from(distance(shown.lab[*at], a) < distance(shown.lab[*at], b));
            }
            if 4 * seen as usize >= pixels.len() && seen > 0 {
                sights.push((shown.sample, f64::from(first) / f64::from(seen)));
            }
        }
        let mean = |part: &[(usize, f64)]| part.iter().map(|s| s.1).sum::<f64>() / part.len().max(1) as f64;
        let mut best = (0.0, (self.timeline.reference, self.timeline.reference));
        for split in 1..sights.len() {
            let (before, after) = sights.split_at(split);
            let score = mean(before) - mean(after);
            if score > best.0 {
                best = (score, (before[before.len() - 1].0, after[0].0));
            }
        }
        best
    }

    /// How near fingers or arms came to the place around the time it changed: 1 when they touched it.
    fn touched(&self, mask: &Mat, when: (usize, usize)) -> Result<f64, SelectError> {
        let reference = &self.scene.samples[self.timeline.reference];
        let (from, to) = (when.0.min(when.1), when.0.max(when.1));
        let mut nearest = f64::INFINITY;
        let outside = binary::map2(mask, mask, |v, _| if v == 0 { 255 } else { 0 })?;
        let mut away = Mat::default();
        imgproc::distance_transform(
            &outside,
            &mut away,
            imgproc::DIST_L2,
            imgproc::DIST_MASK_3,
            opencv::core::CV_32F,
        )?;
        let away = away.data_typed::<f32>()?;
        let (columns, rows) = (self.timeline.columns as i64, self.timeline.area() as i64);
        let rows = rows / columns;
        let mut hands = 0;
        for at in from.saturating_sub(1)..(to + 2).min(self.scene.samples.len()) {
            let sample = &self.scene.samples[at];
            let Some(map) = self.scene.camera(sample.index, reference.index) else { continue };
            hands += sample.hands.len();
            for p in sample.hands.iter().flat_map(|hand| &hand.keypoints[4..]) {
                let p: Pixel = mapped(&map, *p);
                let (x, y) = (p.x.round() as i64, p.y.round() as i64);
                let (u, v) = (x.clamp(0, columns - 1), y.clamp(0, rows - 1));
                let beyond = ((x - u) as f64).hypot((y - v) as f64);
                nearest = nearest.min(f64::from(away[(v * columns + u) as usize]) + beyond);
            }
        }
        if hands == 0 {
            return Ok(UNSEEN_HAND);
        }
        Ok((1.6 - 0.8 * nearest / self.palm).clamp(0.0, 1.0))
    }
}
