//! Keys as they are written.

use egui::{Context, CornerRadius, KeyboardShortcut, RichText, Stroke, StrokeKind, Ui, vec2};

use crate::{
    theme::{Tokens, small_number_font},
    ui_command::UiCommand,
};

/// A key with its modifiers, as the system writes it: `Ctrl+Shift+Z`, `[`.
pub fn key_text(ctx: &Context, shortcut: &KeyboardShortcut) -> String {
    let symbol = shortcut.logical_key.symbol_or_name();
    let modifiers = ctx.format_modifiers(shortcut.modifiers);
    match (modifiers.is_empty(), symbol) {
        // The arrows of the fonts look like triangles: words are clearer beside them.
        (true, _) => short(shortcut).to_owned(),
        (false, _) => format!("{modifiers}+{}", short(shortcut)),
    }
}

fn short(shortcut: &KeyboardShortcut) -> &'static str {
    use egui::Key;
    match shortcut.logical_key {
        Key::ArrowLeft => "Left",
        Key::ArrowRight => "Right",
        Key::ArrowUp => "Up",
        Key::ArrowDown => "Down",
        Key::Escape => "Esc",
        Key::Delete => "Del",
        Key::Quote => "'",
        Key::Minus => "-",
        key => key.symbol_or_name(),
    }
}

/// What a command does and its first key, as a tooltip says it.
pub fn tooltip_with_key(ctx: &Context, command: UiCommand) -> String {
    match command.keys().first() {
        Some(key) => format!("{} ({})", command.tooltip(), key_text(ctx, key)),
        None => command.tooltip().to_owned(),
    }
}

/// Draws a key as a cap.
pub fn key_caps(ui: &mut Ui, tokens: &Tokens, shortcut: &KeyboardShortcut) -> egui::Response {
    let text = key_text(ui.ctx(), shortcut);
    let galley = ui.painter().layout_no_wrap(text.clone(), small_number_font(), tokens.muted);
    let size = vec2((galley.size().x + 8.0).max(16.0), 16.0);
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
    if ui.is_rect_visible(rect) {
        let radius = CornerRadius::same(3);
        ui.painter().rect(rect, radius, tokens.raised, Stroke::new(1.0, tokens.line), StrokeKind::Inside);
        let at = rect.center() - galley.size() / 2.0;
        ui.painter().galley(at, galley, tokens.muted);
    }
    response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Label, true, &text));
    response
}

/// Small muted text.
pub(crate) fn small(tokens: &Tokens, text: impl Into<String>) -> RichText {
    RichText::new(text).small().color(tokens.muted)
}
