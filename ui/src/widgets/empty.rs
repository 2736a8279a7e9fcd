//! What a panel says while it has nothing to show.

use egui::{Align, Layout, RichText, Ui};

use super::Icon;
use crate::theme::Tokens;

/// A glyph, what is missing, what to do about it, and `buttons` to do it with, in the middle of `ui`.
pub fn empty_state(
    ui: &mut Ui,
    tokens: &Tokens,
    icon: Icon,
    missing: &str,
    hint: &str,
    buttons: impl FnOnce(&mut Ui),
) {
    let height = 132.0_f32.min(ui.available_height());
    ui.add_space(((ui.available_height() - height) * 0.4).max(0.0));
    ui.with_layout(Layout::top_down(Align::Center), |ui| {
        ui.spacing_mut().item_spacing.y = 8.0;
        let (rect, _) = ui.allocate_exact_size(egui::Vec2::splat(28.0), egui::Sense::hover());
        icon.paint(ui.painter(), rect, tokens.muted);
        ui.label(RichText::new(missing).size(Tokens::HEADING).color(tokens.text));
        ui.label(RichText::new(hint).color(tokens.muted));
        ui.add_space(4.0);
        buttons(ui);
    });
}
