//! Facts: a name and a value, numbers, shares of a whole.

use egui::{Align, Align2, Color32, FontId, Layout, Rect, RichText, Sense, Stroke, Ui, pos2, vec2};

use crate::{theme::Tokens, widgets::Icon};

/// A name on the left, its value on the right.
pub(in crate::inspector) fn fact(ui: &mut Ui, tokens: &Tokens, name: &str, value: &str) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(name).color(tokens.muted));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add(egui::Label::new(RichText::new(value).color(tokens.text)).truncate());
        });
    });
}

/// A glyph and what it says.
pub(in crate::inspector) fn sign(ui: &mut Ui, tokens: &Tokens, icon: Icon, colour: Color32, text: &str) {
    ui.horizontal_top(|ui| {
        icon.show(ui, colour);
        ui.add(egui::Label::new(RichText::new(text).color(tokens.text)).wrap());
    });
}

/// A coloured mark with a letter or sign in it, so that the colour never stands alone.
pub(in crate::inspector) fn mark(ui: &mut Ui, tokens: &Tokens, colour: Color32, sign: &str) {
    let (rect, _) = ui.allocate_exact_size(vec2(16.0, 16.0), Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(rect, 4.0, colour);
    let ink = ink_on(tokens, colour);
    painter.text(rect.center(), Align2::CENTER_CENTER, sign, FontId::proportional(11.0), ink);
}

/// The darker or the lighter of the theme's extremes, whichever reads better on `ground`.
fn ink_on(tokens: &Tokens, ground: Color32) -> Color32 {
    let bright = |c: Color32| 0.299 * f32::from(c.r()) + 0.587 * f32::from(c.g()) + 0.114 * f32::from(c.b());
    let away = |c: &Color32| (bright(*c) - bright(ground)).abs();
    [tokens.text, tokens.ground].into_iter().max_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(tokens.text)
}

/// A part of a whole.
#[derive(Clone, Copy, Debug)]
pub(in crate::inspector) struct Share {
    /// 0 to 1.
    pub share: f64,
    /// Its colour.
    pub colour: Color32,
    /// Whether it is hatched.
    pub hatched: bool,
}

/// A bar made of shares, left to right; hatching tells them apart without colour.
pub(in crate::inspector) fn bar_of_shares(ui: &mut Ui, tokens: &Tokens, shares: &[Share]) {
    let (bar, _) = ui.allocate_exact_size(vec2(ui.available_width(), 8.0), Sense::hover());
    let painter = ui.painter().with_clip_rect(bar);
    painter.rect_filled(bar, 2.0, tokens.raised);
    let mut left = bar.left();
    for Share { share, colour, hatched } in shares {
        let width = bar.width() * (*share as f32).clamp(0.0, 1.0);
        let part = Rect::from_min_size(pos2(left, bar.top()), vec2(width, bar.height()));
        left += width;
        if *hatched {
            let painter = painter.with_clip_rect(part);
            let mut x = part.left() - part.height();
            while x < part.right() {
                painter.line_segment(
                    [pos2(x, part.bottom()), pos2(x + part.height(), part.top())],
                    Stroke::new(1.5, *colour),
                );
                x += 4.0;
            }
        } else {
            painter.rect_filled(part, 0.0, *colour);
        }
    }
}
