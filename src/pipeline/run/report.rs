//! `report.json`: how good the result is, frame by frame and as a whole.

use std::{collections::BTreeMap, sync::PoisonError};

use serde::Serialize;

use super::{context::Context, export::Parts, source::flag_name};
use crate::{
    clip::{ClipInfo, FrameIndex, FrameSource as _},
    geometry::Side,
    inpaint::FrameCoverage,
    session::{Document, ObjectChoice},
};

/// The whole report.
#[derive(Serialize)]
pub(super) struct Report<'a> {
    id: &'a str,
    version: &'a str,
    flags: &'a [String],
    clip: &'a ClipInfo,
    document: &'a Document,
    object: Option<&'a ObjectChoice>,
    backends: BTreeMap<&'static str, &'a str>,
    summary: Summary,
    frames: Vec<FrameReport>,
    /// Wall time of each stage in seconds; the only part that differs from run to run.
    timings: BTreeMap<&'static str, f64>,
}

/// Numbers for the whole clip.
#[derive(Serialize)]
struct Summary {
    frames: usize,
    object_visible_share: f64,
    object_score: f64,
    arm_score: f64,
    template_frame: Option<FrameIndex>,
    template_confidence: f64,
    background_seen: f64,
    hands: BTreeMap<&'static str, HandSummary>,
}

#[derive(Serialize)]
struct HandSummary {
    valid_share: f64,
    reachable_share: f64,
    hand_length_m: Option<f64>,
    error_position_mean_m: f64,
    error_position_max_m: f64,
    error_rotation_mean_rad: f64,
    limit_margin_min: f64,
}

/// One frame.
#[derive(Serialize)]
struct FrameReport {
    frame: FrameIndex,
    source_frame: u32,
    object_score: f64,
    object_flags: Vec<String>,
    arm_score: f64,
    arm_flags: Vec<String>,
    template_confidence: Option<f64>,
    object_visible: Option<f64>,
    clean_score: Option<f64>,
    background: FrameCoverage,
    hands: BTreeMap<&'static str, HandReport>,
}

#[derive(Serialize)]
struct HandReport {
    state: crate::hands::HandState,
    confidence: f64,
    driven: bool,
    reachable: bool,
    error_position_m: f64,
    error_rotation_rad: f64,
    limit_margin: f64,
    contact: f64,
}

/// Back ends by artifact, as record and report name them.
pub(super) fn backends<'a>(parts: &'a Parts<'a>) -> BTreeMap<&'static str, &'a str> {
    let select = match parts.choice.as_ref().map(|choice| &choice.author) {
        None => "none",
        Some(crate::session::Author::Human) => "operator",
        Some(crate::session::Author::Manifest) => "manifest",
        Some(crate::session::Author::Machine(name)) => name,
    };
    BTreeMap::from([
        ("clip", "ffmpeg"),
        ("select", select),
        ("object_masks", parts.object.backend.as_str()),
        ("arm_masks", parts.arms.union.backend.as_str()),
        ("template", if parts.template.is_some() { "clean-frame" } else { "none" }),
        ("background", parts.background.report.backend.as_str()),
        ("hands", parts.hands.backend.as_str()),
        ("retarget", "damped-least-squares"),
        ("render", "mujoco-egl"),
    ])
}

/// Puts the report together.
pub(super) fn report<'a>(context: &'a Context<'_>, parts: &'a Parts<'a>) -> Report<'a> {
    let count = parts.clip.frame_count();
    let frames: Vec<FrameReport> = FrameIndex::all(count).map(|index| frame_report(parts, index)).collect();
    Report {
        id: &parts.outcome.id,
        version: &parts.outcome.version,
        flags: &parts.outcome.flags,
        clip: &parts.clip.info,
        document: &context.document,
        object: parts.found.choice.as_ref(),
        backends: backends(parts),
        summary: summary(parts, &frames),
        frames,
        timings: context
            .timings
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .iter()
            .map(|(stage, seconds)| (stage.name(), *seconds))
            .collect(),
    }
}

fn frame_report(parts: &Parts<'_>, index: FrameIndex) -> FrameReport {
    let at = index.as_usize();
    let (object, arms) = (parts.object.frame(index), parts.arms.union.frame(index));
    let placement = parts.template.as_ref().and_then(|template| template.placements[at].as_ref());
    let hand = |side: Side| {
        let (hand, solved) = (&parts.hands.hands[side][at], &parts.motion.sides[side][at]);
        let report = HandReport {
            state: hand.state,
            confidence: hand.confidence,
            driven: solved.driven,
            reachable: solved.reachable,
            error_position_m: solved.error_position,
            error_rotation_rad: solved.error_rotation,
            limit_margin: solved.limit_margin,
            contact: solved.contact,
        };
        (side.name(), report)
    };
    FrameReport {
        frame: index,
        source_frame: parts.clip.info.frame_table[at].source_frame,
        object_score: object.score,
        object_flags: object.flags.iter().map(flag_name).collect(),
        arm_score: arms.score,
        arm_flags: arms.flags.iter().map(flag_name).collect(),
        template_confidence: placement.map(|placement| placement.confidence),
        object_visible: placement.map(|placement| placement.visible),
        clean_score: parts.template.as_ref().map(|template| template.scores[at]),
        background: parts.background.report.coverage[at],
        hands: Side::BOTH.map(hand).into_iter().collect(),
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    if count == 0 { 0.0 } else { sum / count as f64 }
}

fn summary(parts: &Parts<'_>, frames: &[FrameReport]) -> Summary {
    let share = |seen: &dyn Fn(&FrameReport) -> bool| {
        mean(frames.iter().map(|frame| if seen(frame) { 1.0 } else { 0.0 }))
    };
    let hands = Side::BOTH.map(|side| {
        let driven: Vec<&HandReport> =
            frames.iter().map(|frame| &frame.hands[side.name()]).filter(|hand| hand.driven).collect();
        let summary = HandSummary {
            valid_share: share(&|frame| frame.hands[side.name()].state != crate::hands::HandState::Invalid),
            reachable_share: mean(driven.iter().map(|hand| if hand.reachable { 1.0 } else { 0.0 })),
            hand_length_m: parts.hands.hand_length[side],
            error_position_mean_m: mean(driven.iter().map(|hand| hand.error_position_m)),
            error_position_max_m: driven.iter().map(|hand| hand.error_position_m).fold(0.0, f64::max),
            error_rotation_mean_rad: mean(driven.iter().map(|hand| hand.error_rotation_rad)),
            limit_margin_min: driven.iter().map(|hand| hand.limit_margin).fold(0.5, f64::min),
        };
        (side.name(), summary)
    });
    Summary {
        frames: frames.len(),
        object_visible_share: mean(parts.object.frames.iter().map(|frame| f64::from(!frame.mask.is_empty()))),
        object_score: mean(frames.iter().map(|frame| frame.object_score)),
        arm_score: mean(frames.iter().map(|frame| frame.arm_score)),
        template_frame: parts.template.as_ref().map(|template| template.frame),
        template_confidence: mean(frames.iter().filter_map(|frame| frame.template_confidence)),
        background_seen: parts.background.report.seen_share(),
        hands: hands.into_iter().collect(),
    }
}
