//! The key sheet: every command with its keys, grouped by where they hold.

use agenticfocus::session::Step;
use egui::{Align, CornerRadius, Frame, Id, Layout, Margin, Modal, RichText, ScrollArea, Ui, vec2};

use crate::{
    state::Context,
    theme::Tokens,
    ui_command::{Scope, UiCommand},
    widgets::{Icon, icon_button, key_caps, small, step_name},
};

/// Height of a row, points.
const ROW: f32 = 22.0;
/// Width of a column, points.
const COLUMN: f32 = 288.0;

/// The key sheet.
#[derive(Debug, Default)]
pub struct KeySheet;

/// A line of the sheet.
#[derive(Clone, Copy)]
enum Line {
    Heading(&'static str),
    Command(UiCommand),
}

/// The step on screen comes first, then what holds everywhere, then the other steps.
fn lines(step: Step) -> Vec<Line> {
    let others = Step::ALL.into_iter().filter(|other| *other != step).map(Scope::Step);
    let mut lines = Vec::new();
    for scope in [Scope::Step(step), Scope::Global].into_iter().chain(others) {
        lines.push(Line::Heading(match scope {
            Scope::Global => "Everywhere",
            Scope::Step(step) => step_name(step),
        }));
        lines.extend(UiCommand::all().filter(|command| command.scope() == scope).map(Line::Command));
    }
    lines
}

impl KeySheet {
    /// Draws it over everything, while it is open.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if !cx.options.keys_open {
            return;
        }
        let room = ui.ctx().content_rect().size() - vec2(96.0, 96.0);
        let columns = ((room.x / (COLUMN + 24.0)) as usize).clamp(1, 4);
        let frame = Frame::popup(ui.style())
            .inner_margin(Margin::same(16))
            .corner_radius(CornerRadius::same(2 * Tokens::RADIUS));
        let modal = Modal::new(Id::unique("key sheet")).frame(frame).show(ui.ctx(), |ui| {
            ui.set_width(columns as f32 * COLUMN + (columns - 1) as f32 * 24.0 + 12.0);
            let close = heading(ui);
            ui.add_space(8.0);
            let height = room.y - 48.0;
            let scroll = ScrollArea::vertical().max_height(height).min_scrolled_height(height);
            scroll.show(ui, |ui| sheet(ui, cx.tokens, columns, cx.options.step));
            close
        });
        if modal.should_close() || modal.inner {
            cx.options.keys_open = false;
        }
    }
}

fn heading(ui: &mut Ui) -> bool {
    ui.horizontal(|ui| {
        ui.heading("Keys");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            icon_button(ui, Icon::Cross, "Close").clicked()
        })
        .inner
    })
    .inner
}

fn sheet(ui: &mut Ui, tokens: &Tokens, columns: usize, step: Step) {
    let lines = lines(step);
    let length = lines.len().div_ceil(columns);
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 24.0;
        let mut rest = lines.as_slice();
        let mut heading = "";
        for _ in 0..columns {
            let mut end = length.min(rest.len());
            // A heading does not stand alone at the foot of a column.
            if end > 0 && matches!(rest[end - 1], Line::Heading(_)) && end < rest.len() {
                end -= 1;
            }
            let (here, after) = rest.split_at(end);
            rest = after;
            ui.allocate_ui_with_layout(vec2(COLUMN, 0.0), Layout::top_down(Align::Min), |ui| {
                column(ui, tokens, here, &mut heading);
            });
        }
    });
}

fn column(ui: &mut Ui, tokens: &Tokens, lines: &[Line], heading: &mut &'static str) {
    ui.set_width(COLUMN);
    ui.spacing_mut().item_spacing = vec2(4.0, 0.0);
    if let Some(Line::Command(_)) = lines.first() {
        ui.label(small(tokens, format!("{heading}, continued")));
    }
    for (at, line) in lines.iter().enumerate() {
        match line {
            Line::Heading(name) => {
                *heading = name;
                ui.add_space(if at == 0 { 0.0 } else { 8.0 });
                ui.label(RichText::new(*name).strong().color(tokens.accent_text));
            }
            Line::Command(command) => row(ui, tokens, *command),
        }
    }
}

fn row(ui: &mut Ui, tokens: &Tokens, command: UiCommand) {
    ui.allocate_ui_with_layout(vec2(COLUMN, ROW), Layout::left_to_right(Align::Center), |ui| {
        ui.label(RichText::new(command.text()).size(12.0)).on_hover_text(command.tooltip());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            for key in command.keys().iter().rev() {
                key_caps(ui, tokens, key);
            }
        });
    });
}
