//! Strokes and glyphs that rows are drawn with.

use egui::{Color32, CornerRadius, Painter, Rangef, Rect, Shape, Stroke, pos2};

use super::Scale;
use crate::widgets::Icon;

/// Glyphs nearer than this to the one before are left out, points: rows of a long clip stay readable.
const GLYPH_DISTANCE: f32 = 7.0;

/// A line along a run.
pub(super) fn line(painter: &Painter, x: Rangef, y: f32, stroke: Stroke) {
    painter.hline(x, y, stroke);
}

/// A dashed line along a run.
pub(super) fn dashes(painter: &Painter, x: Rangef, y: f32, stroke: Stroke) {
    let ends = [pos2(x.min, y), pos2(x.max, y)];
    if x.span() < 6.0 {
        painter.line_segment(ends, stroke);
    } else {
        painter.extend(Shape::dashed_line(&ends, stroke, 3.0, 3.0));
    }
}

/// A bar along a run.
pub(super) fn bar(painter: &Painter, rect: Rect, colour: Color32) {
    painter.rect_filled(rect, CornerRadius::same(1), colour);
}

/// A bar that is striped rather than full: known at second hand.
pub(super) fn striped_bar(painter: &Painter, rect: Rect, colour: Color32) {
    if rect.width() < 4.0 {
        return bar(painter, rect, colour.gamma_multiply(0.5));
    }
    painter.rect_filled(rect, CornerRadius::same(1), colour.gamma_multiply(0.25));
    let painter = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    let step = 4.0;
    let mut x = (rect.left() / step).floor() * step - rect.height();
    while x < rect.right() {
        let ends = [pos2(x, rect.bottom()), pos2(x + rect.height(), rect.top())];
        painter.line_segment(ends, Stroke::new(1.25, colour));
        x += step;
    }
}

/// Glyphs at frames, thinned out where they would touch.
pub(super) struct Glyphs<'a> {
    pub painter: &'a Painter,
    pub scale: &'a Scale,
    pub last: f32,
}

impl<'a> Glyphs<'a> {
    pub fn new(painter: &'a Painter, scale: &'a Scale) -> Self {
        Self { painter, scale, last: f32::NEG_INFINITY }
    }

    /// Draws `icon` at the middle of `frame` unless it is out of sight or too near the one before.
    pub fn put(&mut self, frame: u32, y: f32, icon: Icon, size: f32, colour: Color32) {
        let x = self.scale.middle(frame);
        if !self.scale.x.contains(x) || x - self.last < GLYPH_DISTANCE {
            return;
        }
        self.last = x;
        icon.paint_at(self.painter, pos2(x, y), size, colour);
    }
}
