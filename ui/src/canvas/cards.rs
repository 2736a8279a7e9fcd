//! What is said in the middle of the canvas when there is no picture to show.

use egui::{
    Align, Align2, FontId, Frame, Layout, Margin, Rect, RichText, Sense, Stroke, Ui, UiBuilder, Vec2, pos2,
    vec2,
};

use super::{
    scene::Scene,
    shapes::{self, LineStyle},
};
use crate::{
    action::Action,
    state::{Context, Work, Workspace},
    theme::Tokens,
    ui_command::UiCommand,
    widgets::{Icon, command_button, empty_state, path_button},
};

/// Width of a card, points.
const WIDTH: f32 = 400.0;
/// Files shown that were open before.
const RECENT: usize = 5;
/// Width of a row with such a file, points.
const ROW_WIDTH: f32 = 360.0;
/// Height of the heading over these rows with the room above it, points.
const HEADING: f32 = 40.0;
/// Room kept free above and below all of it, inside the dashed border, points.
const AROUND: f32 = 36.0;
/// Height of glyph, words and buttons, points.
const BEGINNING: f32 = 132.0;

/// Says how to begin.
pub(super) fn no_clip(ui: &mut Ui, cx: &mut Context<'_>, rect: Rect) {
    let dropping = ui.input(|input| !input.raw.hovered_files.is_empty());
    let colour = if dropping { cx.tokens.accent } else { cx.tokens.line };
    let border = LineStyle { width: if dropping { 2.0 } else { 1.0 }, colour, dashed: true };
    shapes::polyline(ui.painter(), &shapes::corners(rect.shrink(24.0)), true, border);
    if dropping {
        let (title, text) = ("Let go to open", "A video, a session, or a folder of clips");
        empty(ui, cx, rect, (Icon::Folder, title, text), &[]);
    } else {
        start(ui, cx, rect);
    }
}

/// Ways to begin: files, the demo where it was made, what was open before.
fn start(ui: &mut Ui, cx: &mut Context<'_>, rect: Rect) {
    let text =
        if cx.demo.is_some() { "Drop a video here, or try the demo episode" } else { "Drop a video here" };
    let rect = rect.shrink2(vec2(0.0, AROUND));
    let room = ((rect.height() - BEGINNING - HEADING) / Tokens::ROW).max(0.0) as usize;
    let shown = cx.recent.len().min(RECENT).min(room);
    let list = if shown > 0 { HEADING + shown as f32 * Tokens::ROW } else { 0.0 };
    // The list hangs below what an empty state draws.
    let above = Rect::from_min_max(rect.min, pos2(rect.max.x, rect.max.y - list));
    let width = ROW_WIDTH.min(rect.width() - 96.0);
    ui.scope_builder(UiBuilder::new().max_rect(above), |ui| {
        let tokens = cx.tokens;
        empty_state(ui, tokens, Icon::Picture, "No clip open", text, |ui| {
            buttons(ui, cx, &[UiCommand::Open, UiCommand::OpenFolder], true);
            if shown > 0 {
                recent(ui, cx, shown, width);
            }
        });
    });
}

/// The `shown` newest files that were open.
fn recent(ui: &mut Ui, cx: &mut Context<'_>, shown: usize, width: f32) {
    ui.add_space(16.0);
    ui.spacing_mut().item_spacing.y = 0.0;
    ui.allocate_ui_with_layout(vec2(width, 0.0), Layout::top_down(Align::Min), |ui| {
        ui.set_width(width);
        ui.horizontal(|ui| {
            ui.add_space(ui.spacing().button_padding.x);
            ui.label(RichText::new("Recent").size(Tokens::SMALL).color(cx.tokens.muted));
        });
        ui.add_space(4.0);
        let paths = cx.recent;
        for path in &paths[..shown] {
            path_button(ui, cx, path, width);
        }
    });
}

/// Says why there is no picture of an open clip yet.
pub(super) fn no_pictures(ui: &mut Ui, cx: &mut Context<'_>, rect: Rect, workspace: &Workspace) {
    let again = [UiCommand::Rerun];
    match &workspace.work {
        Work::Failed(failure) => {
            let title = "This clip cannot be shown";
            framed(ui, cx, rect, title, &failure.message, &[UiCommand::Rerun, UiCommand::Open]);
        }
        Work::Cancelled => {
            let text = "Frames appear when it was read to its end";
            empty(ui, cx, rect, (Icon::Stop, "Reading was stopped", text), &again);
        }
        Work::Running { share, .. } => {
            let text = "Frames appear as soon as they are decoded";
            ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| {
                let title = "Reading the clip";
                empty_state(ui, cx.tokens, Icon::HalfRing, title, text, |ui| {
                    progress(ui, cx.tokens, *share as f32)
                });
            });
        }
        Work::Idle => {
            let text = "Frames appear once it was decoded";
            empty(ui, cx, rect, (Icon::Ring, "The clip was not read yet", text), &again);
        }
    }
}

/// Says why there is no picture of this very frame.
pub(super) fn fault(ui: &mut Ui, cx: &mut Context<'_>, scene: &Scene<'_>) {
    if let Some(text) = cx.pictures.fault(scene.frame).map(str::to_owned) {
        framed(ui, cx, scene.rect, &format!("No picture of {}", scene.frame), &text, &[UiCommand::Rerun]);
    }
}

/// Says that what is dragged over an open clip may be let go.
pub(super) fn drop_hint(ui: &Ui, tokens: &Tokens, rect: Rect) {
    if ui.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, tokens.ground.gamma_multiply(0.8));
    let border = LineStyle { width: 2.0, colour: tokens.accent, dashed: true };
    shapes::polyline(&painter, &shapes::corners(rect.shrink(16.0)), true, border);
    let font = FontId::proportional(Tokens::HEADING);
    painter.text(rect.center(), Align2::CENTER_CENTER, "Let go to open", font, tokens.text);
}

fn empty(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    rect: Rect,
    (icon, title, text): (Icon, &str, &str),
    commands: &[UiCommand],
) {
    ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| {
        let tokens = cx.tokens;
        empty_state(ui, tokens, icon, title, text, |ui| buttons(ui, cx, commands, false));
    });
}

/// A card over whatever lies below: something went wrong.
fn framed(ui: &mut Ui, cx: &mut Context<'_>, rect: Rect, title: &str, text: &str, commands: &[UiCommand]) {
    let width = WIDTH.min(rect.width() - 32.0).max(160.0);
    // Its height is known after it was drawn once; until then it is guessed.
    let id = ui.scope_id().with("canvas card");
    let height = ui.data(|data| data.get_temp::<f32>(id)).unwrap_or(128.0);
    let place = Rect::from_center_size(rect.center(), vec2(width, height));
    let builder = UiBuilder::new().max_rect(place).layout(Layout::top_down(Align::Min));
    let inner = ui.scope_builder(builder, |ui| {
        let frame = Frame::new()
            .fill(cx.tokens.panel)
            .stroke(Stroke::new(1.0, cx.tokens.line))
            .corner_radius(Tokens::RADIUS)
            .inner_margin(Margin::same(16));
        frame.show(ui, |ui| {
            ui.set_width(width - 34.0);
            ui.spacing_mut().item_spacing = Vec2::splat(8.0);
            ui.horizontal(|ui| {
                Icon::Warning.show(ui, cx.tokens.hole);
                ui.label(RichText::new(title).size(Tokens::HEADING).color(cx.tokens.text));
            });
            ui.label(RichText::new(text).color(cx.tokens.text));
            ui.add_space(4.0);
            ui.horizontal(|ui| {
                for command in commands {
                    command_button(ui, cx, *command);
                }
            });
        });
    });
    let drawn = inner.response.rect.height();
    if (drawn - height).abs() > 0.5 {
        ui.data_mut(|data| data.insert_temp(id, drawn));
        ui.ctx().request_repaint();
    }
}

/// Buttons side by side in the middle.
fn buttons(ui: &mut Ui, cx: &mut Context<'_>, commands: &[UiCommand], with_demo: bool) {
    let id = ui.scope_id().with("card buttons");
    let width = ui.data(|data| data.get_temp::<f32>(id)).unwrap_or(0.0);
    let space = ((ui.available_width() - width) / 2.0).max(0.0);
    let row = ui.horizontal(|ui| {
        ui.add_space(space);
        let start = ui.cursor().min.x;
        for command in commands {
            command_button(ui, cx, *command);
        }
        if with_demo {
            demo(ui, cx);
        }
        ui.min_rect().max.x - start
    });
    if !commands.is_empty() && (row.inner - width).abs() > 0.5 {
        ui.data_mut(|data| data.insert_temp(id, row.inner));
        ui.ctx().request_repaint();
    }
}

/// Opens the demo, where it was made.
fn demo(ui: &mut Ui, cx: &mut Context<'_>) {
    let Some(path) = cx.demo else { return };
    let button = ui.button("Try the demo episode").on_hover_text(path.display().to_string());
    if button.clicked() {
        cx.ask(Action::Open(path.to_owned()));
    }
}

fn progress(ui: &mut Ui, tokens: &Tokens, share: f32) {
    let (bar, _) = ui.allocate_exact_size(vec2(160.0, 4.0), Sense::hover());
    ui.painter().rect_filled(bar, 2.0, tokens.line);
    let done = Rect::from_min_size(bar.min, vec2(bar.width() * share.clamp(0.0, 1.0), bar.height()));
    ui.painter().rect_filled(done, 2.0, tokens.accent);
}
