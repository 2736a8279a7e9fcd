//! What is said in the middle of the canvas when there is no picture to show.

use agenticfocus::geometry::Size;
use egui::{Align, Frame, Layout, Margin, Rect, RichText, Stroke, Ui, UiBuilder, Vec2, vec2};

use super::{
    chrome::run_button,
    scene::Scene,
    shapes::{self, LineStyle},
};
use crate::{
    state::{Context, Work, Workspace},
    ui_command::UiCommand,
};

/// Width of a card, points.
const WIDTH: f32 = 380.0;

/// Says how to begin.
pub(super) fn no_clip(ui: &mut Ui, cx: &mut Context<'_>, rect: Rect) {
    let dropping = ui.input(|input| !input.raw.hovered_files.is_empty());
    let colour = if dropping { cx.tokens.accent } else { cx.tokens.line };
    let border = LineStyle { width: if dropping { 2.0 } else { 1.0 }, colour, dashed: true };
    shapes::polyline(ui.painter(), &shapes::corners(rect.shrink(24.0)), true, border);
    let (title, text) = if dropping {
        ("Let go to open", "A video, a session, or a folder of clips")
    } else {
        ("No clip open", "Drop a video here, or try the demo episode")
    };
    let buttons = [UiCommand::Open, UiCommand::OpenFolder];
    card(ui, cx, rect, &Card { title, text, framed: false, share: None, buttons: &buttons });
}

/// Says why there is no picture of an open clip yet.
pub(super) fn no_pictures(ui: &mut Ui, cx: &mut Context<'_>, rect: Rect, workspace: &Workspace) {
    match &workspace.work {
        Work::Failed(failure) => {
            let buttons = [UiCommand::Rerun, UiCommand::Open];
            let text = failure.message.as_str();
            let title = "This clip cannot be shown";
            card(ui, cx, rect, &Card { title, text, framed: true, share: None, buttons: &buttons });
        }
        Work::Cancelled => {
            let (title, text) = ("Reading was stopped", "The clip was not read to its end");
            let buttons = [UiCommand::Rerun];
            card(ui, cx, rect, &Card { title, text, framed: false, share: None, buttons: &buttons });
        }
        Work::Running { share, .. } => {
            let (title, text) = ("Reading the clip", "Its first frame appears as soon as it is decoded");
            let share = Some(*share as f32);
            card(ui, cx, rect, &Card { title, text, framed: false, share, buttons: &[] });
        }
        Work::Idle => {
            let (title, text) = ("The clip is not read yet", "Frames appear once it is decoded");
            let buttons = [UiCommand::Rerun];
            card(ui, cx, rect, &Card { title, text, framed: false, share: None, buttons: &buttons });
        }
    }
}

/// Says why there is no picture of this very frame.
pub(super) fn fault(ui: &mut Ui, cx: &mut Context<'_>, scene: &Scene<'_>) {
    let Some(text) = cx.pictures.fault(scene.frame).map(str::to_owned) else { return };
    let title = format!("No picture of {}", scene.frame);
    let buttons = [UiCommand::Rerun];
    let card_of = Card { title: &title, text: &text, framed: true, share: None, buttons: &buttons };
    card(ui, cx, scene.rect, &card_of);
}

/// A card's content.
struct Card<'a> {
    title: &'a str,
    text: &'a str,
    /// Something went wrong, or it lies over a picture.
    framed: bool,
    share: Option<f32>,
    buttons: &'a [UiCommand],
}

fn card(ui: &mut Ui, cx: &mut Context<'_>, rect: Rect, card: &Card<'_>) {
    let width = WIDTH.min(rect.width() - 32.0).max(120.0);
    // Its height is known after it was drawn once; until then it is guessed.
    let id = ui.id().with("canvas card");
    let height = ui.data(|data| data.get_temp::<f32>(id)).unwrap_or(112.0);
    let place = Rect::from_center_size(rect.center(), vec2(width, height));
    let builder = UiBuilder::new().max_rect(place).layout(Layout::top_down(Align::Center));
    let inner = ui.scope_builder(builder, |ui| {
        let frame = if card.framed {
            let edge = Stroke::new(1.0, cx.tokens.hole);
            Frame::new().fill(cx.tokens.panel).stroke(edge).corner_radius(4).inner_margin(Margin::same(16))
        } else {
            Frame::new().inner_margin(Margin::same(16))
        };
        frame.show(ui, |ui| {
            ui.set_width(width - 32.0);
            ui.spacing_mut().item_spacing = vec2(8.0, 8.0);
            let mark = if card.framed { "⚠  " } else { "" };
            let title = RichText::new(format!("{mark}{}", card.title)).size(15.0).strong().color(cx.tokens.text);
            ui.label(title);
            ui.label(RichText::new(card.text).color(cx.tokens.muted));
            if let Some(share) = card.share {
                progress(ui, cx, share);
            }
            if !card.buttons.is_empty() {
                ui.add_space(4.0);
                buttons(ui, cx, card.buttons);
            }
        });
    });
    let drawn = inner.response.rect.height();
    if (drawn - height).abs() > 0.5 {
        ui.data_mut(|data| data.insert_temp(id, drawn));
        ui.ctx().request_repaint();
    }
}

/// Buttons side by side in the middle.
fn buttons(ui: &mut Ui, cx: &mut Context<'_>, commands: &[UiCommand]) {
    let id = ui.id().with("card buttons");
    let width = ui.data(|data| data.get_temp::<f32>(id)).unwrap_or(0.0);
    let space = ((ui.available_width() - width) / 2.0).max(0.0);
    let row = ui.horizontal(|ui| {
        ui.add_space(space);
        let start = ui.cursor().min.x;
        for command in commands {
            run_button(ui, cx, *command, false);
        }
        ui.min_rect().max.x - start
    });
    if (row.inner - width).abs() > 0.5 {
        ui.data_mut(|data| data.insert_temp(id, row.inner));
        ui.ctx().request_repaint();
    }
}

fn progress(ui: &mut Ui, cx: &Context<'_>, share: f32) {
    let (rect, _) = ui.allocate_exact_size(Vec2::new(160.0, 4.0), egui::Sense::hover());
    ui.painter().rect_filled(rect, 2.0, cx.tokens.line);
    let done = Rect::from_min_size(rect.min, vec2(rect.width() * share.clamp(0.0, 1.0), rect.height()));
    ui.painter().rect_filled(done, 2.0, cx.tokens.accent);
}

/// A size in words.
pub(super) fn size_text(size: Size) -> String {
    format!("{size} px")
}
