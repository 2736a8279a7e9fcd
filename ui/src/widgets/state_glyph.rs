//! States as glyphs and as words: never as a colour alone.

use agenticfocus::session::{ReviewState, Step};
use egui::Color32;

use super::Icon;
use crate::{state::StepState, theme::Tokens};

/// A glyph with its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateGlyph {
    /// The glyph.
    pub icon: Icon,
    /// Its colour.
    pub colour: Color32,
}

/// What a step is called.
pub const fn step_name(step: Step) -> &'static str {
    match step {
        Step::Object => "Object",
        Step::Masks => "Masks",
        Step::Template => "Template",
        Step::Hands => "Hands",
        Step::Retarget => "Retarget",
        Step::Composite => "Composite",
        Step::Review => "Review",
    }
}

/// How far a step is, as a glyph.
pub fn step_glyph(tokens: &Tokens, state: StepState) -> StateGlyph {
    let (icon, colour) = match state {
        StepState::NotRun => (Icon::Ring, tokens.muted),
        StepState::Running => (Icon::HalfRing, tokens.accent),
        StepState::Done => (Icon::Dot, tokens.muted),
        StepState::NeedsLook(_) => (Icon::Warning, tokens.alarm),
        StepState::Confirmed => (Icon::Check, tokens.accent),
    };
    StateGlyph { icon, colour }
}

/// How far a step is, in words.
pub fn step_words(state: StepState) -> String {
    match state {
        StepState::NotRun => "not run".to_owned(),
        StepState::Running => "running".to_owned(),
        StepState::Done => "done by the machine".to_owned(),
        StepState::NeedsLook(1) => "1 frame needs a look".to_owned(),
        StepState::NeedsLook(count) => format!("{count} frames need a look"),
        StepState::Confirmed => "confirmed".to_owned(),
    }
}

/// Where a clip stands, as a glyph.
pub fn review_glyph(tokens: &Tokens, review: &ReviewState) -> StateGlyph {
    let (icon, colour) = match review {
        ReviewState::Unreviewed => (Icon::Ring, tokens.muted),
        ReviewState::NeedsReview { .. } => (Icon::Warning, tokens.alarm),
        ReviewState::Accepted => (Icon::Check, tokens.accent),
        ReviewState::Rejected { .. } => (Icon::Cross, tokens.muted),
        ReviewState::Flagged { .. } => (Icon::Flag, tokens.alarm),
    };
    StateGlyph { icon, colour }
}

/// Where a clip stands, in words, with the reason where there is one.
pub fn review_words(review: &ReviewState) -> String {
    let because = |state: &str, reason: &str| {
        if reason.is_empty() { state.to_owned() } else { format!("{state}: {reason}") }
    };
    match review {
        ReviewState::Unreviewed => "not reviewed".to_owned(),
        ReviewState::NeedsReview { reason } => because("needs a look", reason),
        ReviewState::Accepted => "accepted".to_owned(),
        ReviewState::Rejected { reason, .. } => because("rejected", reason),
        ReviewState::Flagged { reason, .. } => because("flagged", reason),
    }
}
