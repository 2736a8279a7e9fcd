//! What is on screen, in words: the line at the right above the picture.

use agenticfocus::{
    segment::{MaskAuthor, MaskFlag},
    session::Step,
};

use super::{
    Freshness,
    scene::Scene,
    tools::{
        points::Points,
        template::{self, PlacedBy},
    },
};
use crate::{
    state::{Context, LayerEyes, MaskOnFrame},
    widgets::Icon,
};

/// A glyph, if one helps, and a few words.
pub(super) type Caption = (Option<Icon>, String);

/// What is on screen. Points in progress say what is to be done with them.
pub(super) fn caption(
    cx: &Context<'_>,
    scene: &Scene<'_>,
    points: Option<&Points>,
    fresh: Freshness,
) -> Caption {
    if let Some(points) = points {
        return (None, points.hint(scene));
    }
    if !scene.is_writable() {
        return (Some(Icon::Lock), "Read-only".to_owned());
    }
    match cx.options.step {
        Step::Object => object_caption(scene),
        Step::Masks => match scene.workspace.mask(cx.options.mask_layer, scene.frame) {
            Some(on) => mask_caption(&on),
            None => (Some(Icon::Ring), "No mask on this frame".to_owned()),
        },
        Step::Template => template_caption(scene),
        Step::Hands if scene.workspace.found.hands.is_none() => {
            (Some(Icon::Ring), "Hands are not known yet".to_owned())
        }
        Step::Hands => (None, "Drag a joint; with Shift the whole hand".to_owned()),
        Step::Retarget if scene.workspace.found.motion.is_none() => {
            (Some(Icon::Ring), "No motion yet".to_owned())
        }
        Step::Retarget => (None, "Rings are targets, dots the reached wrists".to_owned()),
        Step::Composite | Step::Review => composite_caption(cx, fresh),
    }
}

fn composite_caption(cx: &Context<'_>, fresh: Freshness) -> Caption {
    let single = cx.options.eyes != LayerEyes::default();
    match fresh {
        Freshness::Missing => (Some(Icon::Ring), "No composite of this frame yet".to_owned()),
        Freshness::Source => (None, "The frame as filmed".to_owned()),
        Freshness::Old => (Some(Icon::HalfRing), "A newer picture is being made".to_owned()),
        Freshness::Exact if single => (Some(Icon::Eye), "Single layers, not what is exported".to_owned()),
        Freshness::Exact => (Some(Icon::Dot), "As it is exported, pixel for pixel".to_owned()),
    }
}

fn object_caption(scene: &Scene<'_>) -> Caption {
    let document = scene.workspace.document();
    match &document.object {
        Some(object) => (Some(Icon::Check), object.label.clone()),
        None if document.proposals.is_empty() => (None, "Drag a box around the object".to_owned()),
        None => (None, "A digit takes a proposal; drag to draw a box".to_owned()),
    }
}

fn template_caption(scene: &Scene<'_>) -> Caption {
    let Some(track) = &scene.workspace.found.template else {
        return (Some(Icon::Ring), "No template yet".to_owned());
    };
    match template::placed(scene.workspace, scene.frame) {
        None => (Some(Icon::Ring), "The object is absent on this frame".to_owned()),
        Some((_, PlacedBy::Keyframe)) => (Some(Icon::Diamond), "By hand".to_owned()),
        Some((_, PlacedBy::Between(first, last))) => {
            (Some(Icon::Diamond), format!("Between frames {} and {}", first.0, last.0))
        }
        Some((_, PlacedBy::Machine)) => {
            let placement = track.placements.get(scene.frame.as_usize()).and_then(Option::as_ref);
            let trust = placement.map_or(0.0, |placement| placement.confidence * 100.0);
            (Some(Icon::Dot), format!("Machine, trust {trust:.0} %"))
        }
    }
}

fn mask_caption(on: &MaskOnFrame) -> Caption {
    if on.absent {
        return (Some(Icon::Diamond), "Absent here".to_owned());
    }
    let trust = on.score * 100.0;
    let doubts = on.flags.iter().filter(|flag| **flag != MaskFlag::TouchesBorder);
    let doubts: Vec<&str> = doubts.map(|flag| flag_words(*flag)).collect();
    match on.author {
        MaskAuthor::Human => (Some(Icon::Diamond), "Drawn by hand".to_owned()),
        _ if !doubts.is_empty() => {
            let mut words = doubts.join(", ");
            words[..1].make_ascii_uppercase();
            (Some(Icon::Warning), format!("{words}, trust {trust:.0} %"))
        }
        MaskAuthor::Seeded => (Some(Icon::Dot), format!("From a prompt, trust {trust:.0} %")),
        MaskAuthor::Propagated => (Some(Icon::Minus), format!("Propagated, trust {trust:.0} %")),
    }
}

fn flag_words(flag: MaskFlag) -> &'static str {
    match flag {
        MaskFlag::AreaJump => "area jumps",
        MaskFlag::LowOverlap => "moves oddly",
        MaskFlag::ColourDrift => "colours drift",
        MaskFlag::TouchesBorder => "touches the border",
        MaskFlag::Occluded => "mostly hidden",
        MaskFlag::Lost => "lost",
    }
}
