//! Buttons of the inspectors that the window's widgets do not have: of a given width, of a tool, of a frame.

use agenticfocus::clip::FrameIndex;
use egui::{
    Align2, Button, Label, Rect, Response, RichText, Sense, Ui, WidgetInfo, accesskit::Role, pos2, vec2,
};

use crate::{
    action::Action,
    state::{Context, Workspace},
    theme::Tokens,
    ui_command::UiCommand,
    widgets::{Icon, IconButton, blocked, key_text, tooltip_with_key},
};

/// Adds `button` for `command`: greyed with the reason where it cannot be carried out, asked for when clicked.
fn of_command(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    command: UiCommand,
    button: Button<'_>,
    width: f32,
) -> Response {
    let reason = blocked(cx, command);
    let response = ui
        .add_enabled_ui(reason.is_none(), |ui| ui.add_sized([width, 24.0], button))
        .inner
        .accessible_name(command.text())
        .on_hover_text(tooltip_with_key(ui.ctx(), command));
    if response.clicked() {
        cx.ask(Action::Run(command));
    }
    match reason {
        Some(reason) => response.on_disabled_hover_text(reason),
        None => response,
    }
}

/// A button of `command` with a shorter text, `width` wide, that shows whether it is in force.
pub(in crate::inspector) fn choice_button<'a>(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    command: UiCommand,
    text: impl egui::IntoAtoms<'a>,
    chosen: bool,
    width: f32,
) -> Response {
    let button = Button::selectable(chosen, text).frame_when_inactive(true);
    of_command(ui, cx, command, button, width)
}

/// A tool: its name, and its key in faint letters.
pub(in crate::inspector) fn tool_button(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    command: UiCommand,
    chosen: bool,
    width: f32,
) -> Response {
    let mut button = Button::selectable(chosen, command.text()).frame_when_inactive(true);
    // In a narrow panel the name is worth more than the key, which the tooltip says too.
    if let Some(key) = command.keys().first().filter(|_| width >= 84.0) {
        let key = key_text(ui.ctx(), key);
        button = button.right_text(RichText::new(key).size(11.0).color(cx.tokens.muted));
    }
    of_command(ui, cx, command, button, width)
}

/// The one button of an inspector that stands out.
pub(in crate::inspector) fn primary_button(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    command: UiCommand,
    width: f32,
) -> Response {
    let key = command.keys().first().map(|key| key_text(ui.ctx(), key)).unwrap_or_default();
    if !ui.is_enabled() || blocked(cx, command).is_some() {
        // Out of reach it does not stand out: greyed letters on the accent could not be read.
        return of_command(ui, cx, command, Button::new(command.text()), width);
    }
    let colour = cx.tokens.on_accent;
    let button = Button::new(RichText::new(command.text()).strong().color(colour))
        .right_text(RichText::new(key).size(11.0).color(colour))
        .fill(cx.tokens.accent);
    of_command(ui, cx, command, button, width)
}

/// A small button with a name for those who do not see it.
pub(in crate::inspector) fn small_button(ui: &mut Ui, text: &str, name: &str) -> Response {
    ui.add(Button::new(text)).accessible_name(name).on_hover_text(name)
}

/// A line that goes to a frame when it is clicked: its number, and what is to be seen there.
pub(in crate::inspector) fn go_to_frame(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    frame: FrameIndex,
    text: &str,
    width: f32,
) -> Response {
    let here = cx.workspace.is_some_and(|workspace| workspace.playhead == frame);
    let (row, response) = ui.allocate_exact_size(vec2(width, Tokens::ROW), Sense::click());
    let (enabled, name) = (ui.is_enabled(), format!("Go to frame {}: {text}", frame.0));
    response.widget_info(|| WidgetInfo::selected(Role::Button, enabled, here, &name));
    if ui.is_rect_visible(row) {
        let tokens = cx.tokens;
        let fill = match (here, response.hovered() || response.has_focus()) {
            (true, _) => tokens.selected,
            (false, true) => tokens.hovered,
            (false, false) => egui::Color32::TRANSPARENT,
        };
        ui.painter().rect_filled(row, Tokens::RADIUS, fill);
        // Numbers end in one column, so that the words beside them begin in one.
        let numbers = pos2(row.left() + 36.0, row.center().y);
        let number = frame.0.to_string();
        ui.painter().text(numbers, Align2::RIGHT_CENTER, number, crate::theme::number_font(), tokens.text);
        let words = Rect::from_min_max(pos2(row.left() + 48.0, row.top()), row.max - vec2(4.0, 0.0));
        let label =
            Label::new(RichText::new(text).color(tokens.muted)).truncate().show_tooltip_when_elided(false);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.new_child(egui::UiBuilder::new().max_rect(words).layout(layout)).add(label);
    }
    let response = response.on_hover_text(text);
    if response.clicked() {
        cx.ask(Action::Seek(frame));
    }
    response
}

/// The button of a command that makes no sense here, with the reason why.
pub(in crate::inspector) fn unavailable(ui: &mut Ui, command: UiCommand, reason: &str) -> Response {
    ui.add_enabled(false, Button::new(command.text())).on_disabled_hover_text(reason)
}

/// A line that goes to a frame, with a cross at its end; whether the cross, named `name`, was clicked.
pub(in crate::inspector) fn frame_with_cross(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    frame: FrameIndex,
    text: &str,
    name: &str,
) -> bool {
    let writable = cx.workspace.is_some_and(Workspace::is_writable);
    ui.horizontal(|ui| {
        let width = ui.available_width() - Tokens::ROW - 16.0;
        go_to_frame(ui, cx, frame, text, width);
        IconButton::new(Icon::Cross, name).enabled(writable).show(ui).clicked()
    })
    .inner
}
