//! A short text with a glyph before it, in a rounded frame: a state, a filter, a step.

use egui::{
    Align2, Color32, CornerRadius, FontId, Response, Sense, Stroke, StrokeKind, Ui, Vec2, Widget, WidgetInfo,
    accesskit::Role, vec2,
};

use super::Icon;
use crate::theme::Tokens;

/// A chip.
#[derive(Clone, Debug)]
pub struct Chip<'a> {
    tokens: &'a Tokens,
    text: &'a str,
    name: &'a str,
    glyph: Option<(Icon, Color32)>,
    count: Option<usize>,
    chosen: bool,
    clickable: bool,
}

impl<'a> Chip<'a> {
    /// A chip that says `text`.
    pub fn new(tokens: &'a Tokens, text: &'a str) -> Self {
        Self { tokens, text, name: text, glyph: None, count: None, chosen: false, clickable: false }
    }

    /// Its accessible name, where the text alone does not say it.
    #[must_use]
    pub fn named(mut self, name: &'a str) -> Self {
        self.name = name;
        self
    }

    /// A glyph before the text.
    #[must_use]
    pub fn glyph(mut self, icon: Icon, colour: Color32) -> Self {
        self.glyph = Some((icon, colour));
        self
    }

    /// A number after the glyph.
    #[must_use]
    pub fn count(mut self, count: Option<usize>) -> Self {
        self.count = count;
        self
    }

    /// Whether it is the chosen one (default: no).
    #[must_use]
    pub fn chosen(mut self, chosen: bool) -> Self {
        self.chosen = chosen;
        self
    }

    /// Whether it can be clicked (default: no).
    #[must_use]
    pub fn clickable(mut self) -> Self {
        self.clickable = true;
        self
    }
}

impl Chip<'_> {
    /// The room it takes, points.
    pub fn size(&self, ui: &Ui) -> Vec2 {
        let width = |text: &str, size| {
            ui.painter()
                .layout_no_wrap(text.to_owned(), FontId::proportional(size), Color32::PLACEHOLDER)
                .size()
                .x
        };
        let alone = self.text.is_empty() && self.count.is_none();
        let glyph = if self.glyph.is_none() {
            0.0
        } else if alone {
            12.0
        } else {
            16.0
        };
        let number = self.count.map_or(0.0, |count| width(&count.to_string(), Tokens::SMALL) + 4.0);
        vec2(8.0 + glyph + number + width(self.text, Tokens::TEXT) + 8.0, Tokens::ROW)
    }
}

impl Widget for Chip<'_> {
    fn ui(self, ui: &mut Ui) -> Response {
        let size = self.size(ui);
        let Self { tokens, text, name, glyph, count, chosen, clickable } = self;
        let painter = ui.painter();
        let text =
            painter.layout_no_wrap(text.to_owned(), FontId::proportional(Tokens::TEXT), Color32::PLACEHOLDER);
        let number = count.map(|n| {
            painter.layout_no_wrap(n.to_string(), FontId::proportional(Tokens::SMALL), Color32::PLACEHOLDER)
        });
        let sense = if clickable { Sense::click() } else { Sense::hover() };
        let (rect, response) = ui.allocate_exact_size(size, sense);
        let role = if clickable { Role::Button } else { Role::Label };
        response.widget_info(|| WidgetInfo::selected(role, ui.is_enabled(), chosen, name));
        if !ui.is_rect_visible(rect) {
            return response;
        }
        let under = clickable && (response.hovered() || response.has_focus());
        let (fill, line) = match (chosen, under) {
            (true, _) => (tokens.selected, tokens.accent),
            (false, true) => (tokens.hovered, Color32::TRANSPARENT),
            (false, false) if clickable => (Color32::TRANSPARENT, Color32::TRANSPARENT),
            (false, false) => (tokens.raised, tokens.line),
        };
        let painter = ui.painter();
        painter.rect(
            rect,
            CornerRadius::same(Tokens::RADIUS),
            fill,
            Stroke::new(1.0, line),
            StrokeKind::Inside,
        );
        let colour = if chosen || under || !clickable { tokens.text } else { tokens.muted };
        let mut at = rect.left_center() + vec2(8.0, 0.0);
        let put = |at: egui::Pos2, galley: std::sync::Arc<egui::Galley>, colour| {
            let place = Align2::LEFT_CENTER.anchor_size(at, galley.size());
            painter.galley(place.min, galley, colour);
        };
        if let Some((icon, glyph_colour)) = glyph {
            icon.paint_at(painter, at + vec2(6.0, 0.0), 12.0, glyph_colour);
            at.x += 16.0;
        }
        if let Some(number) = number {
            let number_width = number.size().x;
            put(at, number, tokens.alarm);
            at.x += number_width + 4.0;
        }
        put(at, text, colour);
        response
    }
}
