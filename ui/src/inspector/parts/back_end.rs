//! Who made what is on screen: the embedded back end or a learned model.

use egui::{Label, RichText, TextWrapMode, Ui, text::LayoutJob};

use crate::{theme::Tokens, widgets::Icon};

/// Lines of a fault that are shown; all of it is in the tooltip.
const LINES: usize = 6;

/// Which back end made something, by its name in records; and why a learned model did not.
pub(in crate::inspector) fn made_by(ui: &mut Ui, tokens: &Tokens, backend: &str, fault: Option<&String>) {
    super::fact(ui, tokens, "Made by", backend_in_words(backend));
    if let Some(fault) = fault {
        model_fault(ui, tokens, fault);
    }
}

/// What a learned model said that cannot be used.
pub(in crate::inspector) fn model_fault(ui: &mut Ui, tokens: &Tokens, fault: &str) {
    ui.horizontal_top(|ui| {
        Icon::Warning.show(ui, tokens.alarm);
        let text = RichText::new(fault).size(11.0).color(tokens.text);
        let font = egui::FontSelection::Default;
        let mut job = LayoutJob::default();
        text.append_to(&mut job, ui.style(), font, egui::Align::Min);
        job.wrap.max_rows = LINES;
        ui.add(Label::new(job).wrap_mode(TextWrapMode::Wrap)).on_hover_text(fault);
    });
}

/// A back end's name, as records write it, in words; learned models are called what people call them.
pub(in crate::inspector) fn backend_in_words(backend: &str) -> &str {
    match backend {
        "classical" => "flow, colours and cuts",
        "temporal-plate" => "plates of other frames",
        "none" => "nobody",
        name => name,
    }
}
