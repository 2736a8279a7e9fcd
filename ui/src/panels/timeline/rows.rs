//! The rows under the filmstrip.

use agenticfocus::{geometry::Side, hands::HandState};
use egui::{
    Align2, Color32, CornerRadius, FontId, Painter, Rangef, Rect, Shape, Stroke, StrokeKind, Ui,
    epaint::PathStroke, pos2, vec2,
};

use super::{
    HandRow, MaskKind, MaskRow, Rows, Scale, TemplateRow,
    paint::{Glyphs, bar, dashes, line, striped_bar},
};
use crate::{
    state::{Context, Workspace},
    theme::{Tokens, small_number_font},
    widgets::Icon,
};

/// Below this a mask wants a look; the line in the row of quality.
const DOUBT: f32 = 0.35;

/// Where every row lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    pub whole: Rect,
    pub ruler: Rect,
    pub filmstrip: Rect,
    object: Rect,
    arms: Rect,
    template: Rect,
    left: Rect,
    right: Rect,
    order: Rect,
    quality: Rect,
}

impl Places {
    /// Rows from the top of `rect` down, between the ends `x`.
    pub fn new(rect: Rect, x: Rangef) -> Self {
        let mut y = rect.top();
        let mut row = |height: f32, gap: f32| {
            let place = Rect::from_x_y_ranges(x, Rangef::new(y, y + height));
            y += height + gap;
            place
        };
        Self {
            ruler: row(14.0, 0.0),
            filmstrip: row(36.0, 4.0),
            object: row(14.0, 0.0),
            arms: row(14.0, 0.0),
            template: row(12.0, 0.0),
            left: row(12.0, 1.0),
            right: row(12.0, 3.0),
            order: row(18.0, 4.0),
            quality: row(20.0, 0.0),
            whole: rect,
        }
    }
}

/// Draws ruler and rows.
pub(super) fn paint(
    ui: &Ui,
    cx: &Context<'_>,
    workspace: &Workspace,
    rows: &Rows,
    scale: &Scale,
    places: &Places,
) {
    let tokens = cx.tokens;
    let painter = ui.painter();
    names(painter, tokens, places);
    ruler(painter, tokens, scale, places, workspace);
    for place in [places.object, places.arms, places.template, places.left, places.right] {
        painter.hline(place.x_range(), place.center().y, Stroke::new(1.0, tokens.line.gamma_multiply(0.6)));
    }
    mask_row(painter, tokens, &rows.object, scale, places.object, &[tokens.object]);
    mask_row(painter, tokens, &rows.arms, scale, places.arms, &[tokens.left, tokens.right]);
    template_row(painter, tokens, &rows.template, scale, places.template);
    for (side, place) in [(Side::Left, places.left), (Side::Right, places.right)] {
        hand_row(painter, tokens, &rows.hands[side], scale, place, tokens.side(side));
    }
    swapped(painter, tokens, rows, scale, places.left.union(places.right));
    contact(painter, tokens, rows, scale, places.order);
    order(painter, tokens, rows, scale, places.order);
    quality(painter, tokens, rows, scale, places.quality);
}

fn names(painter: &Painter, tokens: &Tokens, places: &Places) {
    let named = [
        (places.object, "object"),
        (places.arms, "arms"),
        (places.template, "template"),
        (places.left, "left hand"),
        (places.right, "right hand"),
        (places.order, "contact, order"),
        (places.quality, "trust"),
    ];
    for (place, name) in named {
        let at = pos2(places.whole.left(), place.center().y);
        let font = FontId::proportional(Tokens::SMALL);
        painter.text(at, Align2::LEFT_CENTER, name, font, tokens.muted);
    }
}

/// Seconds between labels so that they stand at least 64 points apart.
fn label_step(scale: &Scale) -> f64 {
    let second = f64::from(scale.frame_width()) * agenticfocus::clip::STANDARD_FPS;
    let steps = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0];
    steps.into_iter().find(|step| step * second >= 64.0).unwrap_or(600.0)
}

fn ruler(painter: &Painter, tokens: &Tokens, scale: &Scale, places: &Places, workspace: &Workspace) {
    let painter = &painter.with_clip_rect(places.ruler.intersect(painter.clip_rect()));
    let step = label_step(scale);
    let (first, last) = scale.in_sight();
    let seconds = |frame: u32| workspace.seconds(agenticfocus::clip::FrameIndex(frame));
    let mut tick = (seconds(first) / step).ceil() as i64;
    while (tick as f64) * step <= seconds(last) {
        let time = tick as f64 * step;
        let frame = (time * agenticfocus::clip::STANDARD_FPS).round() as u32;
        let x = scale.middle(frame);
        let text = if step < 1.0 { format!("{time:.1} s") } else { format!("{time:.0} s") };
        painter.vline(
            x,
            Rangef::new(places.ruler.bottom() - 3.0, places.ruler.bottom()),
            Stroke::new(1.0, tokens.line),
        );
        if x + 30.0 < places.ruler.right() {
            let at = pos2(x + 3.0, places.ruler.center().y - 1.0);
            painter.text(at, Align2::LEFT_CENTER, text, small_number_font(), tokens.muted);
        }
        tick += 1;
    }
}

/// Stretches as lines (one for each of `colours`), what is doubtful dashed under a triangle, people's edits as
/// diamonds, hollow where they said "absent".
fn mask_row(
    painter: &Painter,
    tokens: &Tokens,
    row: &MaskRow,
    scale: &Scale,
    place: Rect,
    colours: &[Color32],
) {
    let middle = place.center().y;
    let offset = |at: usize| 3.0 * (at as f32 - 0.5 * (colours.len() - 1) as f32);
    let width = if colours.len() > 1 { 2.0 } else { 3.0 };
    for run in &row.runs {
        let Some(x) = scale.span(run.first, run.last) else { continue };
        match run.kind {
            MaskKind::Machine => {
                for (at, colour) in colours.iter().enumerate() {
                    line(painter, x, middle + offset(at), Stroke::new(width, *colour));
                }
            }
            MaskKind::Flagged => dashes(painter, x, middle, Stroke::new(3.0, tokens.hole)),
            MaskKind::Lost => dashes(painter, x, middle, Stroke::new(1.0, tokens.hole)),
        }
    }
    let mut warnings = Glyphs::new(painter, scale);
    for run in row.runs.iter().filter(|run| run.kind != MaskKind::Machine) {
        warnings.put(run.first.midpoint(run.last), middle - 1.0, Icon::Warning, 10.0, tokens.alarm);
    }
    let mut edits = Glyphs::new(painter, scale);
    for (frame, absent) in &row.human {
        edits.put(*frame, middle, Icon::Diamond, 13.0, tokens.panel);
        edits.last = f32::NEG_INFINITY;
        edits.put(*frame, middle, Icon::Diamond, 10.0, tokens.text);
        if *absent {
            let x = scale.middle(*frame);
            Icon::Diamond.paint_at(painter, pos2(x, middle), 6.0, tokens.panel);
        }
    }
}

/// A person's frames, each with a rim that sets it off from what is under it.
fn diamonds(painter: &Painter, tokens: &Tokens, scale: &Scale, frames: &[u32], y: f32) {
    let mut glyphs = Glyphs::new(painter, scale);
    for frame in frames {
        glyphs.put(*frame, y, Icon::Diamond, 11.0, tokens.panel);
        glyphs.last = f32::NEG_INFINITY;
        glyphs.put(*frame, y, Icon::Diamond, 8.0, tokens.text);
    }
}

/// A thin line where it is placed, a thick one between keyframes that were joined, people's keyframes as diamonds.
fn template_row(painter: &Painter, tokens: &Tokens, row: &TemplateRow, scale: &Scale, place: Rect) {
    let middle = place.center().y;
    for run in &row.runs {
        if let Some(x) = scale.span(run.first, run.last) {
            line(painter, x, middle, Stroke::new(1.0, tokens.template));
        }
    }
    for (first, last) in &row.spans {
        if scale.span(*first, *last).is_some() {
            let x = Rangef::new(scale.middle(*first), scale.middle(*last));
            let x = Rangef::new(x.min.max(scale.x.min), x.max.min(scale.x.max));
            line(painter, x, middle, Stroke::new(4.0, tokens.template));
        }
    }
    diamonds(painter, tokens, scale, &row.human, middle);
}

/// Seen full, bridged striped, absent left out; corrections as diamonds.
fn hand_row(painter: &Painter, tokens: &Tokens, row: &HandRow, scale: &Scale, place: Rect, colour: Color32) {
    let y = place.shrink2(vec2(0.0, 2.0)).y_range();
    for run in &row.runs {
        let Some(x) = scale.span(run.first, run.last) else { continue };
        let rect = Rect::from_x_y_ranges(x, y);
        match run.kind {
            HandState::Bridged => striped_bar(painter, rect, colour),
            _ => bar(painter, rect, colour),
        }
    }
    diamonds(painter, tokens, scale, &row.human, place.center().y);
}

/// Frames on which a person exchanged the hands: a frame round both rows, with a glyph where there is room.
fn swapped(painter: &Painter, tokens: &Tokens, rows: &Rows, scale: &Scale, place: Rect) {
    for (first, last) in &rows.swapped {
        let Some(x) = scale.span(*first, *last) else { continue };
        let rect = Rect::from_x_y_ranges(x, place.y_range());
        painter.rect_stroke(rect, CornerRadius::same(2), Stroke::new(1.0, tokens.text), StrokeKind::Inside);
        if rect.width() >= 18.0 {
            painter.circle_filled(rect.center(), 8.0, tokens.panel);
            Icon::Swap.paint_at(painter, rect.center(), 10.0, tokens.text);
        }
    }
}

/// One value for every point of the width, joined from the frames under it.
fn columns(scale: &Scale, values: &[f32], join: impl Fn(f32, f32) -> f32) -> Vec<(f32, f32)> {
    let (first, last) = scale.in_sight();
    let last = last.min(values.len().saturating_sub(1) as u32);
    let mut joined: Vec<(f32, f32)> = Vec::new();
    for frame in first..=last {
        let Some(value) = values.get(frame as usize).copied() else { break };
        let x = scale.middle(frame);
        match joined.last_mut() {
            Some((at, known)) if x - *at < 1.0 && !known.is_nan() && !value.is_nan() => {
                *known = join(*known, value)
            }
            _ => joined.push((x, value)),
        }
    }
    joined
}

/// Contact as a filled curve.
fn contact(painter: &Painter, tokens: &Tokens, rows: &Rows, scale: &Scale, place: Rect) {
    let colour = tokens.robot.gamma_multiply(0.45);
    let height = place.height() - 2.0;
    let half = (0.5 * scale.frame_width()).max(0.5);
    for (x, value) in columns(scale, &rows.contact, f32::max) {
        if value > 0.02 {
            let top = place.bottom() - value.clamp(0.0, 1.0) * height;
            let column = Rect::from_min_max(pos2(x - half, top), pos2(x + half, place.bottom()));
            painter.rect_filled(column.intersect(place), CornerRadius::ZERO, colour);
        }
    }
    painter.hline(place.x_range(), place.bottom(), Stroke::new(1.0, tokens.line));
}

/// Stretches with the object in front as frames with words; a diamond where a person said so.
fn order(painter: &Painter, tokens: &Tokens, rows: &Rows, scale: &Scale, place: Rect) {
    for run in rows.order.iter().filter(|run| run.kind.object_in_front || run.kind.by_person) {
        let Some(x) = scale.span(run.first, run.last) else { continue };
        let rect = Rect::from_x_y_ranges(x, place.y_range());
        let colour = if run.kind.object_in_front { tokens.object } else { tokens.robot };
        painter.rect_stroke(rect, CornerRadius::same(2), Stroke::new(1.0, colour), StrokeKind::Inside);
        let mut at = rect.left_center() + vec2(5.0, 0.0);
        if run.kind.by_person && rect.width() > 12.0 {
            Icon::Diamond.paint_at(painter, at + vec2(3.0, 0.0), 8.0, tokens.text);
            at.x += 12.0;
        }
        let words = if run.kind.object_in_front { "object in front" } else { "robot in front" };
        let galley =
            painter.layout_no_wrap(words.to_owned(), FontId::proportional(Tokens::SMALL), tokens.text);
        if at.x + galley.size().x + 4.0 < rect.right() {
            // Contact rises behind the words: they stand on a ground of their own.
            let words = Rect::from_min_size(at - vec2(0.0, 0.5 * galley.size().y), galley.size());
            let ground = words.expand2(vec2(2.0, 0.0)).intersect(rect.shrink(1.0));
            painter.rect_filled(ground, CornerRadius::same(2), tokens.panel.gamma_multiply(0.8));
            painter.galley(words.min, galley, tokens.text);
        }
    }
}

/// Trust as a curve over the line below which a look is wanted.
fn quality(painter: &Painter, tokens: &Tokens, rows: &Rows, scale: &Scale, place: Rect) {
    // The first and the last frame in sight may lie half outside.
    let painter = &painter.with_clip_rect(place.expand(1.0).intersect(painter.clip_rect()));
    let y = |value: f32| place.bottom() - value.clamp(0.0, 1.0) * place.height();
    dashes(painter, place.x_range(), y(DOUBT), Stroke::new(1.0, tokens.line));
    let curve = columns(scale, &rows.quality, f32::min);
    for part in curve.split(|(_, value)| value.is_nan()).filter(|part| !part.is_empty()) {
        let half = (0.5 * scale.frame_width()).max(0.5);
        for (x, value) in part.iter().filter(|(_, value)| *value < DOUBT) {
            let column = Rect::from_min_max(pos2(x - half, y(DOUBT)), pos2(x + half, y(*value)));
            bar(painter, column.intersect(place), tokens.hole);
        }
        let points = part.iter().map(|(x, value)| pos2(*x, y(*value))).collect();
        painter.add(Shape::line(points, PathStroke::new(1.25, tokens.muted)));
    }
}

/// Draws the selection and the playhead over everything.
pub(super) fn paint_marks(
    ui: &Ui,
    cx: &Context<'_>,
    workspace: &Workspace,
    scale: &Scale,
    places: &Places,
    focused: bool,
) {
    let (tokens, painter) = (cx.tokens, ui.painter());
    if let Some((first, last)) = cx.options.selection
        && let Some(x) = scale.span(first.0, last.0)
    {
        let rect = Rect::from_x_y_ranges(x, places.whole.y_range());
        painter.rect_filled(rect, CornerRadius::ZERO, tokens.accent.gamma_multiply(0.14));
        for edge in [x.min, x.max] {
            dashed_edge(painter, edge, rect, tokens.accent);
        }
    }
    overview(painter, tokens, scale, places);
    let x = scale.middle(workspace.playhead.0);
    if !scale.x.contains(x) {
        return;
    }
    let y = Rangef::new(places.ruler.top(), places.quality.bottom() + 2.0);
    if scale.frame_width() > 4.0 {
        let (left, right) = (scale.left(workspace.playhead.0), scale.left(workspace.playhead.0 + 1));
        let column = Rect::from_x_y_ranges(Rangef::new(left, right), y);
        painter.rect_filled(column, CornerRadius::ZERO, tokens.accent.gamma_multiply(0.12));
    }
    painter.vline(x, y, Stroke::new(if focused { 2.5 } else { 1.5 }, tokens.accent));
    let top = places.ruler.top();
    let handle = vec![
        pos2(x - 5.0, top),
        pos2(x + 5.0, top),
        pos2(x + 5.0, top + 6.0),
        pos2(x, top + 11.0),
        pos2(x - 5.0, top + 6.0),
    ];
    painter.add(Shape::convex_polygon(handle, tokens.accent, Stroke::NONE));
}

/// Which part of the clip is in sight, while not all of it is.
fn overview(painter: &Painter, tokens: &Tokens, scale: &Scale, places: &Places) {
    let count = f64::from(scale.count.max(1));
    if scale.shown.1 - scale.shown.0 >= count {
        return;
    }
    let y = Rangef::new(places.quality.bottom() + 4.0, places.quality.bottom() + 7.0);
    let at = |frame: f64| scale.x.min + (frame / count) as f32 * scale.x.span();
    painter.rect_filled(Rect::from_x_y_ranges(scale.x, y), CornerRadius::same(1), tokens.line);
    let (left, right) = (at(scale.shown.0), at(scale.shown.1));
    let part = Rect::from_x_y_ranges(Rangef::new(left, right.max(left + 8.0)), y);
    painter.rect_filled(part, CornerRadius::same(1), tokens.muted);
}

fn dashed_edge(painter: &Painter, x: f32, rect: Rect, colour: Color32) {
    let ends = [pos2(x, rect.top()), pos2(x, rect.bottom())];
    painter.extend(Shape::dashed_line(&ends, Stroke::new(1.0, colour), 4.0, 3.0));
}
