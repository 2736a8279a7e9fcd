//! Evidence of all cues put together: which thing, on which frame, how sure.

use opencv::core::Mat;

use super::{SelectError, change::Change, held::Held, scene::Scene, timeline::carried};
use crate::{clip::FrameIndex, vision::binary};

/// A thing that a hand seems to handle, on one sample.
pub(super) struct Candidate {
    /// Index of the frame it is shown on.
    pub index: usize,
    /// CV_8UC1, work size.
    pub shape: Mat,
    /// CV_8UC1, work size: how far it may reach, where the shape is only a part of it.
    pub around: Option<Mat>,
    /// Trust, 0 to 1.
    pub score: f64,
    pub reason: String,
}

/// Evidence below this is none.
const LEAST: f64 = 0.01;

/// How much a single change speaks for an object, 0 to 1.
fn strength(change: &Change) -> f64 {
    let outline = (change.outline / 0.7).clamp(0.0, 1.0);
    let lasting = ((change.lasting - 0.2) / 0.6).clamp(0.0, 1.0);
    let whole = (1.0 - 3.0 * change.cut_off).max(0.1) * (change.compact / 0.75).min(1.0).powi(2);
    let solid = (change.solid / 0.3).clamp(0.1, 1.0);
    let size = (change.relative_area / 0.15).min(1.0) * (8.0 / change.relative_area).min(1.0);
    outline * lasting * change.touched * (1.0 - change.arm_like) * whole * solid * size
}

/// How much what was put down looks like what was taken away, 0 to 1.
fn likeness(a: &Change, b: &Change) -> f64 {
    let ratio = a.relative_area.min(b.relative_area) / a.relative_area.max(b.relative_area);
    let colours = (1.4 - 1.6 * a.colours.distance(&b.colours)).clamp(0.0, 1.0);
    colours * (ratio / 0.6).min(1.0)
}

/// Candidates from places that changed, each where it is best visible.
pub(super) fn from_changes(scene: &Scene<'_>, changes: &[Change]) -> Result<Vec<Candidate>, SelectError> {
    let mut candidates = Vec::new();
    for (at, change) in changes.iter().enumerate() {
        let own = strength(change);
        if own < LEAST {
            continue;
        }
        let partner = changes
            .iter()
            .enumerate()
            .filter(|(other, partner)| *other != at && partner.taken != change.taken)
            .filter(|(_, partner)| {
                let (taken, put) = if change.taken { (change, *partner) } else { (*partner, change) };
                taken.when.0 <= put.when.1
            })
            .map(|(_, partner)| likeness(change, partner) * strength(partner).sqrt())
            .fold(0.0, f64::max);
        let score = own * (0.3 + 0.7 * partner);
        let Some((sample, shape)) = clearest(scene, change)? else { continue };
        let reason = change_reason(scene, change, partner);
        let index = scene.samples[sample].index;
        candidates.push(Candidate { index, shape, around: None, score, reason });
    }
    Ok(candidates)
}

fn change_reason(scene: &Scene<'_>, change: &Change, partner: f64) -> String {
    let frame = |sample: usize| FrameIndex(scene.samples[sample].index as u32);
    let (first, last) = (change.when.0.min(change.when.1), change.when.0.max(change.when.1));
    let (what, where_else) = if change.taken {
        ("taken from its place", "something like it was put down elsewhere")
    } else {
        ("put in its place", "something like it was taken from elsewhere")
    };
    let between = format!("{what} between {} and {}", frame(first), frame(last));
    if partner > 0.3 { format!("{between}; {where_else}") } else { between }
}

/// Candidates from things that stay in a hand.
pub(super) fn from_held(held: Vec<Held>) -> Vec<Candidate> {
    let candidate = |held: Held| {
        let steady = (held.steady / 0.35).clamp(0.0, 1.0);
        let often = ((held.sights as f64 - 2.0) / 6.0).clamp(0.0, 1.0).sqrt();
        let size = (held.relative_area / 0.3).min(1.0) * (4.0 / held.relative_area).min(1.0);
        let own = (1.0 - 2.0 * held.arm_like).max(0.0);
        let inside = if held.at_border { 0.3 } else { 1.0 };
        let score = 0.8 * steady * often * size * own * inside;
        let reason = format!(
            "moves with a hand and keeps its place in it at {} of the moments looked at, best seen on {}",
            held.sights,
            FrameIndex(held.index as u32)
        );
        Candidate { index: held.index, shape: held.shape, around: Some(held.around), score, reason }
    };
    held.into_iter().map(candidate).filter(|candidate| candidate.score >= LEAST).collect()
}

/// The sample on which arms are farthest from the object while it lies there.
fn clearest(scene: &Scene<'_>, change: &Change) -> Result<Option<(usize, Mat)>, SelectError> {
    let (first, last) = (change.when.0.min(change.when.1), change.when.0.max(change.when.1));
    let span: Vec<usize> = if change.taken {
        (change.reference..=first).collect()
    } else {
        (last..=change.reference).rev().collect()
    };
    let mut best: Option<(f64, (usize, Mat))> = None;
    for (tried, sample) in span.into_iter().enumerate() {
        if tried >= 8 {
            break;
        }
        let Some(shape) = carried(scene, &change.mask, change.reference, sample)? else { continue };
        let area = binary::area(&shape)? as f64;
        if area < 8.0 {
            continue;
        }
        let near = binary::dilated(&shape, (0.15 * area.sqrt()).round().clamp(2.0, 6.0) as i32)?;
        let covered = binary::area(&binary::map2(&near, &scene.samples[sample].arm, |a, b| a & b)?)? as f64;
        let score = area.min(binary::area(&change.mask)? as f64) - 2.0 * covered;
        if best.as_ref().is_none_or(|(other, _)| score > *other + 0.02 * area) {
            best = Some((score, (sample, shape)));
        }
        if covered == 0.0 {
            break;
        }
    }
    Ok(best.map(|(_, found)| found))
}
