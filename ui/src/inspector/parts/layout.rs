//! Headings, hints, empty states.

use egui::{RichText, Ui};

use super::sign;
use crate::{
    state::{Context, Draft},
    theme::Tokens,
    widgets::Icon,
};

/// A part of an inspector under its heading, set off from the part above.
pub(in crate::inspector) fn section(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    title: &str,
    add: impl FnOnce(&mut Ui, &mut Context<'_>),
) {
    separator(ui, cx.tokens);
    ui.label(RichText::new(title).strong().color(cx.tokens.text));
    ui.push_id(title, |ui| add(ui, cx));
}

/// As [`section`], folded until it is opened; `open` says whether it is so from the start.
pub(in crate::inspector) fn folded_section(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    title: &str,
    open: bool,
    add: impl FnOnce(&mut Ui, &mut Context<'_>),
) {
    separator(ui, cx.tokens);
    let heading = RichText::new(title).strong().color(cx.tokens.text);
    egui::CollapsingHeader::new(heading).default_open(open).show_unindented(ui, |ui| add(ui, cx));
}

fn separator(ui: &mut Ui, tokens: &Tokens) {
    ui.add_space(8.0);
    let (line, _) = ui.allocate_exact_size(egui::vec2(ui.available_width(), 1.0), egui::Sense::hover());
    ui.painter().rect_filled(line, 0.0, tokens.line);
    ui.add_space(4.0);
}

/// A small line that explains.
pub(in crate::inspector) fn hint(ui: &mut Ui, tokens: &Tokens, text: &str) {
    ui.label(RichText::new(text).size(11.0).color(tokens.muted));
}

/// What is shown where there is nothing yet: what is missing, and what to do.
pub(in crate::inspector) fn empty(ui: &mut Ui, tokens: &Tokens, what: &str, then: &str) {
    ui.add_space(16.0);
    ui.vertical_centered(|ui| {
        ui.label(RichText::new(what).color(tokens.text));
        ui.label(RichText::new(then).size(11.0).color(tokens.muted));
    });
    ui.add_space(16.0);
}

/// Points that are being set, and what the engine makes of them.
pub(in crate::inspector) fn draft(ui: &mut Ui, tokens: &Tokens, draft: &Draft) {
    let (on, beside) = (draft.positive.len(), draft.negative.len());
    hint(ui, tokens, &format!("Points on frame {}: {on} on it, {beside} beside it", draft.frame.0));
    if draft.mask.is_some() {
        super::made_by(ui, tokens, &draft.backend, None);
    }
    if let Some(fault) = &draft.fault {
        sign(ui, tokens, Icon::Warning, tokens.alarm, fault);
    }
}
