//! Buttons: of commands, of glyphs.

use egui::{Button, Response, RichText, Ui, Vec2, WidgetInfo, accesskit::Role};

use super::{Icon, blocked, tooltip_with_key};
use crate::{action::Action, state::Context, theme::Tokens, ui_command::UiCommand};

/// Names a button and says whether it can be pressed, for tests and screen readers.
fn named(response: &Response, name: &str) {
    response.widget_info(|| WidgetInfo::labeled(Role::Button, response.enabled(), name));
}

/// Adds `button` for `command`: greyed with the reason where it cannot be carried out, asked for when clicked.
fn of_command(ui: &mut Ui, cx: &mut Context<'_>, command: UiCommand, button: Button<'_>) -> Response {
    let reason = blocked(cx, command);
    let response = ui.add_enabled(reason.is_none(), button);
    named(&response, command.text());
    let response = response.on_hover_text(tooltip_with_key(ui.ctx(), command));
    if response.clicked() {
        cx.ask(Action::Run(command));
    }
    match reason {
        Some(reason) => response.on_disabled_hover_text(reason),
        None => response,
    }
}

/// A button of `command` with its own text, tooltip and key.
pub fn command_button(ui: &mut Ui, cx: &mut Context<'_>, command: UiCommand) -> Response {
    of_command(ui, cx, command, Button::new(command.text()))
}

/// A button of `command` that shows a glyph alone; quiet until the pointer is over it.
pub fn command_icon_button(ui: &mut Ui, cx: &mut Context<'_>, icon: Icon, command: UiCommand) -> Response {
    let button = Button::new(icon.atom()).frame_when_inactive(false).min_size(Vec2::splat(Tokens::ROW));
    of_command(ui, cx, command, button)
}

/// A row of `command` in a menu: its text to the left, its key to the right.
pub fn command_menu_button(ui: &mut Ui, cx: &mut Context<'_>, command: UiCommand) -> Response {
    let mut button =
        Button::new(command.text()).frame_when_inactive(false).min_size(Vec2::new(224.0, Tokens::ROW));
    if let Some(key) = command.keys().first() {
        button = button.shortcut_text(RichText::new(super::key_text(ui.ctx(), key)).color(cx.tokens.muted));
    }
    of_command(ui, cx, command, button)
}

/// A button of `command` that stays pressed while `on`: one of several side by side.
pub fn command_toggle(ui: &mut Ui, cx: &mut Context<'_>, command: UiCommand, on: bool) -> Response {
    toggle(ui, cx, command, on, Button::selectable(on, command.text()))
}

/// As [`command_toggle`], but alone: it has a frame, without which nobody would take it for a button.
pub fn command_switch(ui: &mut Ui, cx: &mut Context<'_>, command: UiCommand, on: bool) -> Response {
    toggle(ui, cx, command, on, Button::selectable(on, command.text()).frame_when_inactive(true))
}

fn toggle(ui: &mut Ui, cx: &mut Context<'_>, command: UiCommand, on: bool, button: Button<'_>) -> Response {
    let response = of_command(ui, cx, command, button);
    response.widget_info(|| WidgetInfo::selected(Role::Button, response.enabled(), on, command.text()));
    response
}

/// A quiet button that shows a glyph alone.
#[derive(Clone, Debug)]
pub struct IconButton<'a> {
    icon: Icon,
    name: &'a str,
    selected: bool,
    enabled: bool,
}

impl<'a> IconButton<'a> {
    /// The button with this accessible name, which its tooltip shows too.
    pub fn new(icon: Icon, name: &'a str) -> Self {
        Self { icon, name, selected: false, enabled: true }
    }

    /// Whether it is drawn pressed (default: no).
    #[must_use]
    pub fn selected(mut self, selected: bool) -> Self {
        self.selected = selected;
        self
    }

    /// Whether it can be pressed (default: yes).
    #[must_use]
    pub fn enabled(mut self, enabled: bool) -> Self {
        self.enabled = enabled;
        self
    }

    /// Draws it.
    pub fn show(self, ui: &mut Ui) -> Response {
        let button = Button::new(self.icon.atom())
            .frame_when_inactive(self.selected)
            .selected(self.selected)
            .min_size(Vec2::splat(Tokens::ROW));
        let response = ui.add_enabled(self.enabled, button);
        response.widget_info(|| WidgetInfo::selected(Role::Button, self.enabled, self.selected, self.name));
        response.on_hover_text(self.name)
    }
}

/// A quiet button that shows a glyph alone, named `name`.
pub fn icon_button(ui: &mut Ui, icon: Icon, name: &str) -> Response {
    IconButton::new(icon, name).show(ui)
}
