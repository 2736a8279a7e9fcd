//! What the machine doubts about a mask, in words a person can act on.

use agenticfocus::{
    clip::FrameIndex,
    segment::{MaskAuthor, MaskFlag, RleMask},
    session::{Author, MaskLayer},
};

use crate::state::Workspace;

/// Who made a mask.
pub fn author_of_mask(author: MaskAuthor) -> &'static str {
    match author {
        MaskAuthor::Human => "by you",
        MaskAuthor::Seeded => "found on this frame",
        MaskAuthor::Propagated => "carried over from another frame",
    }
}

/// Who proposed something.
pub(super) fn author_of_proposal(author: &Author) -> String {
    match author {
        Author::Human => "you".to_owned(),
        Author::Manifest => "the manifest".to_owned(),
        Author::Machine(name) => name.clone(),
    }
}

/// Why the mask on `frame` wants a look, the weightiest first, with numbers taken from the track.
pub fn reasons_of(workspace: &Workspace, layer: MaskLayer, frame: FrameIndex) -> Vec<String> {
    let Some((author, score, flags)) = workspace.mask_summary(layer, frame) else { return Vec::new() };
    if author == MaskAuthor::Human {
        return Vec::new();
    }
    let mut reasons: Vec<String> =
        flags.iter().map(|flag| flag_reason(workspace, layer, frame, *flag)).collect();
    if score < 0.35 || reasons.is_empty() && score < 0.5 {
        reasons.push(format!("trust only {:.0} %", 100.0 * score));
    }
    reasons
}

/// One flag in words.
pub fn flag_reason(workspace: &Workspace, layer: MaskLayer, frame: FrameIndex, flag: MaskFlag) -> String {
    match flag {
        MaskFlag::AreaJump => area_jump(workspace, layer, frame),
        MaskFlag::LowOverlap => low_overlap(workspace, layer, frame),
        MaskFlag::ColourDrift => "colours are not the object's any more".to_owned(),
        MaskFlag::TouchesBorder => "touches the picture's border".to_owned(),
        MaskFlag::Occluded => "mostly hidden".to_owned(),
        MaskFlag::Lost => "not found on this frame".to_owned(),
    }
}

fn area_jump(workspace: &Workspace, layer: MaskLayer, frame: FrameIndex) -> String {
    let Some(here) = workspace.mask(layer, frame) else { return "area jumped".to_owned() };
    let (now, before) = (here.mask.area() as f64, trusted_area_before(workspace, layer, frame));
    match before {
        Some(before) if (now / before - 1.0).abs() < 0.1 => "area is not what was expected".to_owned(),
        Some(before) if now < before => format!("area fell by {:.0} %", 100.0 * (1.0 - now / before)),
        Some(before) => format!("area grew by {:.0} %", 100.0 * (now / before - 1.0)),
        None => "area jumped".to_owned(),
    }
}

/// The area of the nearest mask before `frame` (or after it, where there is none) that nothing is doubtful about.
fn trusted_area_before(workspace: &Workspace, layer: MaskLayer, frame: FrameIndex) -> Option<f64> {
    let count = workspace.frame_count() as u32;
    let nearest = (0..frame.0).rev().chain(frame.0 + 1..count).map(FrameIndex);
    let trusted = |at: &FrameIndex| {
        workspace.mask_summary(layer, *at).is_some_and(|(author, score, flags)| {
            let clean = flags.iter().all(|flag| matches!(flag, MaskFlag::TouchesBorder));
            author == MaskAuthor::Human || clean && score >= 0.5
        })
    };
    let areas = nearest.filter(trusted).filter_map(|at| Some(workspace.mask(layer, at)?.mask.area() as f64));
    areas.into_iter().find(|area| *area > 0.0)
}

fn low_overlap(workspace: &Workspace, layer: MaskLayer, frame: FrameIndex) -> String {
    let before = frame.0.checked_sub(1).and_then(|before| workspace.mask(layer, FrameIndex(before)));
    match (before, workspace.mask(layer, frame)) {
        (Some(before), Some(here)) if before.mask.size() == here.mask.size() => {
            let share = intersection_over_union(&before.mask, &here.mask);
            format!("overlaps the frame before by only {:.0} %", 100.0 * share)
        }
        _ => "jumped away from the frame before".to_owned(),
    }
}

/// Intersection over union straight from the runs, without decoding; both masks have one size.
pub(super) fn intersection_over_union(one: &RleMask, other: &RleMask) -> f64 {
    let (mut a, mut b) = (one.counts().iter(), other.counts().iter());
    let (mut left_a, mut left_b) = (a.next().copied().unwrap_or(0), b.next().copied().unwrap_or(0));
    let (mut in_a, mut in_b) = (false, false);
    let (mut both, mut any) = (0_u64, 0_u64);
    loop {
        while left_a == 0 {
            let Some(next) = a.next() else { break };
            (left_a, in_a) = (*next, !in_a);
        }
        while left_b == 0 {
            let Some(next) = b.next() else { break };
            (left_b, in_b) = (*next, !in_b);
        }
        let run = left_a.min(left_b);
        if run == 0 {
            break;
        }
        both += if in_a && in_b { u64::from(run) } else { 0 };
        any += if in_a || in_b { u64::from(run) } else { 0 };
        (left_a, left_b) = (left_a - run, left_b - run);
    }
    if any == 0 { 1.0 } else { both as f64 / any as f64 }
}

#[cfg(test)]
mod tests {
    use agenticfocus::{geometry::Size, image::Mask};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn overlap_of_runs_is_overlap_of_pixels(bits in proptest::collection::vec(any::<(bool, bool)>(), 35)) {
            let size = Size::new(7, 5);
            let at = |x: u32, y: u32| bits[(y * 7 + x) as usize];
            let one = Mask::from_fn(size, |x, y| at(x, y).0);
            let other = Mask::from_fn(size, |x, y| at(x, y).1);
            let runs = intersection_over_union(&RleMask::encode(&one), &RleMask::encode(&other));
            let expected = if one.is_empty() && other.is_empty() { 1.0 } else { one.iou(&other) };
            prop_assert!((runs - expected).abs() < 1e-12);
        }
    }
}
