//! The clips of the folder: picture, state, flags; a click opens.

use agenticfocus::{engine::QueueItem, session::ReviewState};
use egui::{
    Align, Align2, Color32, CornerRadius, FontId, Layout, Rect, RichText, ScrollArea, Sense, Ui, WidgetInfo,
    accesskit::Role, pos2, vec2,
};

use crate::{
    action::Action,
    state::Context,
    theme::Tokens,
    ui_command::UiCommand,
    widgets::{
        Icon, StateGlyph, Thumbnails, command_button, command_icon_button, empty_state, review_glyph,
        review_words, small,
    },
};

/// Height of a clip's row, points.
const ROW: f32 = 52.0;
/// Size of a clip's picture, points.
const PICTURE: egui::Vec2 = vec2(48.0, 36.0);

/// The queue.
#[derive(Debug, Default)]
pub struct QueuePanel {
    thumbnails: Thumbnails<String>,
}

impl QueuePanel {
    /// Draws it.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        ui.spacing_mut().item_spacing = vec2(4.0, 0.0);
        header(ui, cx);
        let queue = cx.queue;
        if queue.items.is_empty() {
            let (missing, hint) = match &queue.path {
                Some(_) => ("No clips in this folder", "Open another folder, or a single clip"),
                None => ("No folder open", "Drop a folder of clips here"),
            };
            return empty_state(ui, cx.tokens, Icon::Folder, missing, hint, |ui| {
                command_button(ui, cx, UiCommand::OpenFolder);
            });
        }
        let open = cx.workspace.map(|workspace| workspace.document().clip.id.clone());
        ScrollArea::vertical().auto_shrink(false).show_rows(ui, ROW, queue.items.len(), |ui, range| {
            for item in queue.items.get(range).unwrap_or_default() {
                self.row(ui, cx, item, open.as_deref() == Some(item.id.as_str()));
            }
        });
    }

    fn row(&mut self, ui: &mut Ui, cx: &mut Context<'_>, item: &QueueItem, open: bool) {
        let tokens = cx.tokens;
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
        let (glyph, words) = state_of(tokens, item);
        let name = format!("{}: {words}", item.id);
        response.widget_info(|| WidgetInfo::selected(Role::Button, true, open, &name));
        if !ui.is_rect_visible(rect) {
            return;
        }
        let painter = ui.painter();
        if open || response.hovered() || response.has_focus() {
            painter.rect_filled(
                rect,
                CornerRadius::ZERO,
                if open { tokens.selected } else { tokens.hovered },
            );
        }
        if open {
            let mark = Rect::from_min_size(rect.min, vec2(3.0, rect.height()));
            painter.rect_filled(mark, CornerRadius::ZERO, tokens.accent);
        }
        let frame = Rect::from_min_size(pos2(rect.left() + 12.0, rect.center().y - 18.0), PICTURE);
        self.picture(ui, tokens, item, frame);
        text(
            ui,
            tokens,
            item,
            (glyph, &words),
            Rect::from_min_max(pos2(frame.right() + 8.0, rect.top()), rect.max),
        );
        if response.clicked() && !open {
            cx.ask(Action::Open(item.path.clone()));
        }
        response.on_hover_ui(|ui| {
            ui.label(RichText::new(&item.id).strong());
            ui.label(&words);
            if let Some(flags) = flag_words(item) {
                ui.label(RichText::new(flags).color(tokens.alarm));
            }
            ui.label(small(tokens, item.path.display().to_string()));
        });
    }

    fn picture(&mut self, ui: &Ui, tokens: &Tokens, item: &QueueItem, rect: Rect) {
        let painter = ui.painter();
        painter.rect_filled(rect, CornerRadius::same(2), tokens.raised);
        match &item.thumbnail {
            Some(picture) => {
                let texture = self.thumbnails.texture(ui.ctx(), item.id.clone(), picture);
                let size = picture.size();
                let scale = (rect.width() / size.width as f32).min(rect.height() / size.height as f32);
                let place = Rect::from_center_size(
                    rect.center(),
                    vec2(size.width as f32, size.height as f32) * scale,
                );
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                painter.image(texture, place, whole, Color32::WHITE);
            }
            None => Icon::Picture.paint_at(painter, rect.center(), 16.0, tokens.muted),
        }
    }
}

/// The clip's name over its state.
fn text(ui: &Ui, tokens: &Tokens, item: &QueueItem, (glyph, words): (StateGlyph, &str), rect: Rect) {
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let width = rect.width() - 8.0;
    let cut = |text: &str, size: f32, colour| {
        let mut job =
            egui::text::LayoutJob::simple_singleline(text.to_owned(), FontId::proportional(size), colour);
        job.wrap = egui::text::TextWrapping::truncate_at_width(width - if size < 12.0 { 16.0 } else { 0.0 });
        painter.layout_job(job)
    };
    let title = cut(&item.id, Tokens::TEXT, tokens.text);
    let top = rect.center().y - 9.0;
    let place = Align2::LEFT_CENTER.anchor_size(pos2(rect.left(), top), title.size());
    painter.galley(place.min, title, tokens.text);
    let low = rect.center().y + 9.0;
    glyph.icon.paint_at(&painter, pos2(rect.left() + 5.0, low), 11.0, glyph.colour);
    let state = match flag_words(item) {
        Some(flags) if item.fault.is_none() => format!("{words} · {flags}"),
        _ => words.to_owned(),
    };
    let state = cut(&state, Tokens::SMALL, tokens.muted);
    let place = Align2::LEFT_CENTER.anchor_size(pos2(rect.left() + 15.0, low), state.size());
    painter.galley(place.min, state, tokens.muted);
}

fn state_of(tokens: &Tokens, item: &QueueItem) -> (StateGlyph, String) {
    if let Some(fault) = &item.fault {
        return (StateGlyph { icon: Icon::Warning, colour: tokens.alarm }, fault.clone());
    }
    let mut words = review_words(&item.review);
    if item.exported {
        words.push_str(", exported");
    }
    (review_glyph(tokens, &item.review), words)
}

fn flag_words(item: &QueueItem) -> Option<String> {
    let flags: Vec<String> = item.flags.iter().map(|flag| flag.replace('_', " ")).collect();
    (!flags.is_empty()).then(|| flags.join(", "))
}

fn header(ui: &mut Ui, cx: &mut Context<'_>) {
    let items = &cx.queue.items;
    let decided =
        |item: &&QueueItem| !matches!(item.review, ReviewState::Unreviewed | ReviewState::NeedsReview { .. });
    let (done, all) = (items.iter().filter(decided).count(), items.len());
    let size = vec2(ui.available_width(), 36.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let mut inner = ui.new_child(
        egui::UiBuilder::new()
            .max_rect(rect.shrink2(vec2(12.0, 6.0)))
            .layout(Layout::left_to_right(Align::Center)),
    );
    inner.spacing_mut().item_spacing.x = 8.0;
    let title = inner.label(RichText::new("Queue").strong());
    if let Some(path) = &cx.queue.path {
        title.on_hover_text(path.display().to_string());
    }
    if all > 0 {
        inner.label(small(cx.tokens, format!("{done} of {all} reviewed")));
        inner.with_layout(Layout::right_to_left(Align::Center), |ui| {
            command_icon_button(ui, cx, Icon::Right, UiCommand::NextClip);
        });
        let share = done as f32 / all as f32;
        let y = rect.bottom() - 1.0;
        ui.painter().hline(rect.x_range(), y, egui::Stroke::new(2.0, cx.tokens.line));
        let end = rect.left() + share * rect.width();
        ui.painter().hline(rect.left()..=end, y, egui::Stroke::new(2.0, cx.tokens.accent));
    } else if cx.queue.path.is_some() {
        inner.label(small(cx.tokens, "0 clips"));
    }
}
