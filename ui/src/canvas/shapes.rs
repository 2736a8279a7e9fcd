//! Lines, badges and handles over the picture.

use std::sync::Arc;

use egui::{Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Shape, Stroke, Vec2, pos2, vec2};

use super::view::Projection;
use crate::{paint::Outline, theme::Tokens, widgets::Icon};

/// Dash and gap of what is doubtful, points.
const DASH: (f32, f32) = (7.0, 5.0);

/// Side of a checkerboard's cell, points.
const CELL: f32 = 12.0;

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LineStyle {
    /// Points.
    pub width: f32,
    pub colour: Color32,
    pub dashed: bool,
}

impl LineStyle {
    pub fn solid(width: f32, colour: Color32) -> Self {
        Self { width, colour, dashed: false }
    }

    fn stroke(&self) -> Stroke {
        Stroke::new(self.width, self.colour)
    }
}

/// Draws borders of masks, all in one mesh: they run along pixels, so they are rectangles.
pub(super) fn outlines<'a>(
    painter: &Painter,
    projection: &Projection,
    lines: impl IntoIterator<Item = (&'a Outline, LineStyle)>,
) {
    let mut mesh = Mesh::default();
    let clip = painter.clip_rect().expand(4.0);
    for (line, style) in lines {
        let mut travelled = 0.0;
        let ends = line.corners.iter().zip(line.corners.iter().cycle().skip(1));
        for (from, to) in ends {
            let corner = |at: &[u32; 2]| projection.corner_to_screen(f64::from(at[0]), f64::from(at[1]));
            let (a, b) = (corner(from), corner(to));
            let length = (b - a).length();
            if clip.intersects(Rect::from_two_pos(a, b)) {
                edge(&mut mesh, a, b, style, travelled);
            }
            travelled = (travelled + length) % (DASH.0 + DASH.1);
        }
    }
    if !mesh.is_empty() {
        painter.add(Shape::mesh(mesh));
    }
}

/// One horizontal or vertical edge. Horizontal ones take the corners, so that nothing is drawn twice.
fn edge(mesh: &mut Mesh, a: Pos2, b: Pos2, style: LineStyle, travelled: f32) {
    let half = style.width / 2.0;
    let horizontal = (a.y - b.y).abs() < (a.x - b.x).abs();
    let mut piece = |from: Pos2, to: Pos2| {
        let margin = if horizontal { Vec2::splat(half) } else { vec2(half, -half) };
        let rect = Rect::from_two_pos(from, to);
        let rect = Rect::from_min_max(rect.min - margin, rect.max + margin);
        if rect.is_positive() {
            mesh.add_colored_rect(rect, style.colour);
        }
    };
    if !style.dashed {
        piece(a, b);
        return;
    }
    let (length, period) = ((b - a).length(), DASH.0 + DASH.1);
    if length <= 0.0 {
        return;
    }
    let direction = (b - a) / length;
    let mut at = -travelled;
    while at < length {
        let (start, end) = (at.max(0.0), (at + DASH.0).min(length));
        if start < end {
            piece(a + direction * start, a + direction * end);
        }
        at += period;
    }
}

/// A line through `points`.
pub(super) fn polyline(painter: &Painter, points: &[Pos2], closed: bool, style: LineStyle) {
    let mut points = points.to_vec();
    if closed {
        points.extend(points.first().copied());
    }
    if points.len() < 2 {
        return;
    }
    if style.dashed {
        painter.extend(Shape::dashed_line(&points, style.stroke(), DASH.0, DASH.1));
    } else {
        painter.add(Shape::line(points, style.stroke()));
    }
}

/// A line in a data colour with a dark rim, so that it is seen on every picture.
pub(super) fn rimmed_line(painter: &Painter, points: &[Pos2], closed: bool, style: LineStyle) {
    let rim = LineStyle { width: style.width + 2.0, colour: rim_colour(), ..style };
    polyline(painter, points, closed, rim);
    polyline(painter, points, closed, style);
}

/// What lies behind lines and dots on the picture.
pub(super) fn rim_colour() -> Color32 {
    Color32::from_black_alpha(130)
}

/// A rectangle's corners in order.
pub(super) fn corners(rect: Rect) -> [Pos2; 4] {
    [rect.left_top(), rect.right_top(), rect.right_bottom(), rect.left_bottom()]
}

/// A dot with a dark rim.
pub(super) fn dot(painter: &Painter, at: Pos2, radius: f32, colour: Color32) {
    painter.circle(at, radius, colour, Stroke::new(1.5, rim_colour()));
}

/// A square handle that can be dragged.
pub(super) fn handle(painter: &Painter, at: Pos2, colour: Color32, lit: bool) {
    let rect = Rect::from_center_size(at, Vec2::splat(if lit { 12.0 } else { 9.0 }));
    painter.rect(rect, 2.0, Color32::WHITE, Stroke::new(2.0, colour), egui::StrokeKind::Inside);
}

/// Small text on a panel of its own, its bottom-left corner at `at`; stays within the picture's rectangle.
pub(super) fn badge(painter: &Painter, tokens: &Tokens, at: Pos2, text: &str, mark: Color32) -> Rect {
    badge_with(painter, tokens, at, None, text, mark)
}

/// A badge with a glyph before its text.
pub(super) fn badge_with(
    painter: &Painter,
    tokens: &Tokens,
    at: Pos2,
    icon: Option<Icon>,
    text: &str,
    mark: Color32,
) -> Rect {
    let rect = badge_rect(painter, tokens, at, icon, text);
    painter.rect_filled(rect, Tokens::RADIUS, tokens.panel.gamma_multiply(0.92));
    let bar = Rect::from_min_size(rect.min + vec2(4.0, 4.0), vec2(3.0, rect.height() - 8.0));
    painter.rect_filled(bar, 1.5, mark);
    if let Some(icon) = icon {
        let middle = pos2(rect.min.x + 17.0, rect.center().y);
        icon.paint(painter, Rect::from_center_size(middle, Vec2::splat(12.0)), tokens.text);
    }
    let galley = words(painter, tokens, text);
    painter.galley(rect.min + vec2(11.0 + indent(icon), 3.0), galley, tokens.text);
    rect
}

/// Where such a badge would be.
pub(super) fn badge_rect(
    painter: &Painter,
    tokens: &Tokens,
    at: Pos2,
    icon: Option<Icon>,
    text: &str,
) -> Rect {
    let size = words(painter, tokens, text).size() + vec2(17.0 + indent(icon), 6.0);
    let clip = painter.clip_rect();
    let corner = pos2(at.x, at.y - size.y).clamp(clip.min, (clip.max - size).max(clip.min));
    Rect::from_min_size(corner, size)
}

fn indent(icon: Option<Icon>) -> f32 {
    if icon.is_some() { 16.0 } else { 0.0 }
}

fn words(painter: &Painter, tokens: &Tokens, text: &str) -> Arc<egui::Galley> {
    painter.layout_no_wrap(text.to_owned(), FontId::proportional(Tokens::SMALL), tokens.text)
}

/// The brush's footprint. A dark and a light ring: one of them is seen on every picture. Taking away is a
/// ring with a bar, whatever its colours look like.
pub(super) fn brush_ring(painter: &Painter, at: Pos2, radius: f32, taking: bool) {
    painter.circle_stroke(at, radius, Stroke::new(3.0, rim_colour()));
    painter.circle_stroke(at, radius, Stroke::new(1.5, Color32::WHITE));
    if taking {
        let bar = [at - vec2(4.0, 0.0), at + vec2(4.0, 0.0)];
        painter.line_segment(bar, Stroke::new(4.0, rim_colour()));
        painter.line_segment(bar, Stroke::new(2.0, Color32::WHITE));
    }
}

/// What lies behind a picture that is clear in places.
pub(super) fn checkerboard(painter: &Painter, tokens: &Tokens, rect: Rect) {
    painter.rect_filled(rect, 0.0, tokens.raised);
    let seen = rect.intersect(painter.clip_rect());
    if !seen.is_positive() {
        return;
    }
    let mut mesh = Mesh::default();
    let cells = |from: f32, to: f32, start: f32| {
        (((from - start) / CELL).floor() as i32)..=(((to - start) / CELL).floor() as i32)
    };
    for row in cells(seen.min.y, seen.max.y, rect.min.y) {
        for column in cells(seen.min.x, seen.max.x, rect.min.x).filter(|column| (column + row) % 2 == 0) {
            let corner = rect.min + vec2(column as f32, row as f32) * CELL;
            let cell = Rect::from_min_size(corner, Vec2::splat(CELL)).intersect(seen);
            if cell.is_positive() {
                mesh.add_colored_rect(cell, tokens.line);
            }
        }
    }
    painter.add(Shape::mesh(mesh));
}

/// A plus or a minus where somebody clicked.
pub(super) fn click_mark(painter: &Painter, at: Pos2, positive: bool, tokens: &Tokens) {
    let colour = if positive { tokens.template } else { tokens.hole };
    painter.circle(at, 7.0, colour, Stroke::new(1.5, Color32::WHITE));
    let arm = 3.5;
    let stroke = Stroke::new(2.0, Color32::WHITE);
    painter.line_segment([at - vec2(arm, 0.0), at + vec2(arm, 0.0)], stroke);
    if positive {
        painter.line_segment([at - vec2(0.0, arm), at + vec2(0.0, arm)], stroke);
    }
}

/// Text in the middle of a rectangle, in small.
pub(super) fn small_text(painter: &Painter, at: Pos2, align: Align2, text: &str, colour: Color32) -> Rect {
    painter.text(at, align, text, FontId::proportional(Tokens::SMALL), colour)
}
