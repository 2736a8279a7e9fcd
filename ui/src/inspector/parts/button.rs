//! Buttons of the inspectors that the window's widgets do not have: of a given width, of a tool, of a frame.

use agenticfocus::clip::FrameIndex;
use egui::{Button, Response, RichText, Ui};

use crate::{
    action::Action,
    state::Context,
    ui_command::UiCommand,
    widgets::{blocked, key_text, tooltip_with_key},
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
pub(in crate::inspector) fn choice_button(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    command: UiCommand,
    text: &str,
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
    let key = command.keys().first().map(|key| key_text(ui.ctx(), key)).unwrap_or_default();
    let button = Button::selectable(chosen, command.text())
        .frame_when_inactive(true)
        .right_text(RichText::new(key).size(11.0).color(cx.tokens.muted));
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

/// A line that goes to a frame when it is clicked.
pub(in crate::inspector) fn go_to_frame(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    frame: FrameIndex,
    text: &str,
    width: f32,
) -> Response {
    let here = cx.workspace.is_some_and(|workspace| workspace.playhead == frame);
    let number = RichText::new(frame.0.to_string()).monospace().color(cx.tokens.text);
    let button = Button::selectable(here, (number, RichText::new(text).color(cx.tokens.muted)))
        .min_size(egui::vec2(width, 24.0))
        .truncate();
    let layout = egui::Layout::left_to_right(egui::Align::Center).with_main_justify(false);
    let response = ui
        .allocate_ui_with_layout(egui::vec2(width, 24.0), layout, |ui| ui.add(button))
        .inner
        .accessible_name(format!("Go to frame {}: {text}", frame.0))
        .on_hover_text(text);
    if response.clicked() {
        cx.ask(Action::Seek(frame));
    }
    response
}
