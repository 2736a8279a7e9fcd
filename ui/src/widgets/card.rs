//! A raised rectangle that can be chosen.

use egui::{
    CornerRadius, Frame, Margin, Response, Sense, Stroke, Ui, UiBuilder, WidgetInfo, accesskit::Role,
};

use crate::theme::Tokens;

/// A card named `name` with `contents`, framed in the accent when `chosen`; clicking anywhere on it counts, unless
/// a widget inside takes the click.
pub fn card(
    ui: &mut Ui,
    tokens: &Tokens,
    name: &str,
    chosen: bool,
    contents: impl FnOnce(&mut Ui),
) -> Response {
    let id = ui.next_auto_id().with(name);
    let hovered =
        ui.ctx().read_response(id).is_some_and(|response| response.hovered() || response.has_focus());
    let (fill, line) = match (chosen, hovered) {
        (true, _) => (tokens.selected, tokens.accent),
        (false, true) => (tokens.hovered, tokens.muted),
        (false, false) => (tokens.raised, tokens.line),
    };
    let frame = Frame::new()
        .fill(fill)
        .stroke(Stroke::new(1.0, line))
        .corner_radius(CornerRadius::same(Tokens::RADIUS))
        .inner_margin(Margin::same(8));
    let builder = UiBuilder::new().scope_id(id).sense(Sense::click());
    let response = ui
        .scope_builder(builder, |ui| {
            frame.show(ui, |ui| {
                ui.set_width(ui.available_width());
                contents(ui);
            });
        })
        .response;
    response.widget_info(|| WidgetInfo::selected(Role::Button, response.enabled(), chosen, name));
    response
}
