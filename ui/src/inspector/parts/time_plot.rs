//! A plot over the frames of the clip, with the playhead in it.

use agenticfocus::clip::FrameIndex;
use egui::{Color32, RichText, Stroke, Ui};
use egui_plot::{AxisHints, Line, LineStyle, Plot, PlotUi, VLine};

use crate::theme::Tokens;

/// How a line is drawn: what tells it from others besides its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::inspector) enum TraceStyle {
    /// Unbroken.
    Solid,
    /// Dashes.
    Dashed,
    /// Dots.
    Dotted,
}

impl TraceStyle {
    fn line(self) -> LineStyle {
        match self {
            Self::Solid => LineStyle::Solid,
            Self::Dashed => LineStyle::Dashed { length: 6.0 },
            Self::Dotted => LineStyle::Dotted { spacing: 4.0 },
        }
    }
}

/// One value a frame; a gap where there is none.
#[derive(Clone, Debug)]
pub(in crate::inspector) struct Trace<'a> {
    /// Its name.
    pub name: &'a str,
    /// One a frame.
    pub values: Vec<Option<f64>>,
    /// Its colour.
    pub colour: Color32,
    /// How it is drawn.
    pub style: TraceStyle,
}

/// Draws the traces and what `more` adds; the frame that was clicked, if one was.
pub(in crate::inspector) fn time_plot<'a>(
    ui: &mut Ui,
    tokens: &Tokens,
    id: &str,
    unit: &'a str,
    playhead: FrameIndex,
    traces: &[Trace<'_>],
    more: impl FnOnce(&mut PlotUi<'a>) + 'a,
) -> Option<FrameIndex> {
    let last = traces.iter().map(|trace| trace.values.len()).max().unwrap_or(0).saturating_sub(1);
    let runs: Vec<_> = traces
        .iter()
        .flat_map(|trace| runs_of(&trace.values).into_iter().map(move |run| (trace, run)))
        .collect();
    let lines: Vec<Line<'a>> = runs
        .into_iter()
        .map(|(trace, run)| {
            let stroke = Stroke::new(1.5, trace.colour);
            Line::new(trace.name, run).stroke(stroke).style(trace.style.line()).allow_hover(false)
        })
        .collect();
    let now = VLine::new("Playhead", f64::from(playhead.0))
        .stroke(Stroke::new(1.0, tokens.text))
        .allow_hover(false);
    ui.style_mut().text_styles.insert(egui::TextStyle::Small, egui::FontId::proportional(10.0));
    let response = Plot::new(id)
        .height(128.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .allow_axis_zoom_drag(false)
        .show_x(false)
        .show_y(false)
        .show_crosshair(false)
        .show_background(true)
        .y_axis_min_width(28.0)
        .y_axis_formatter(move |mark, _| format!("{}{unit}", tidy(mark.value)))
        .custom_x_axes(vec![
            AxisHints::new_x().label_spacing(28.0..=44.0).formatter(|mark, _| tidy(mark.value)),
        ])
        .default_x_bounds(0.0, last.max(1) as f64)
        .set_margin_fraction(egui::vec2(0.0, 0.08))
        .grid_spacing(16.0..=96.0)
        .grid_color(tokens.line)
        .show(ui, |plot| {
            more(plot);
            for line in lines {
                plot.line(line);
            }
            plot.vline(now);
        });
    let pointer = response.response.interact_pointer_pos().filter(|_| response.response.clicked())?;
    let frame = response.transform.value_from_position(pointer).x.round();
    Some(FrameIndex(frame.clamp(0.0, last as f64) as u32))
}

fn tidy(value: f64) -> String {
    if value.fract().abs() < 1e-9 { format!("{value:.0}") } else { format!("{value}") }
}

/// Stretches without gaps, as points.
fn runs_of(values: &[Option<f64>]) -> Vec<Vec<[f64; 2]>> {
    let mut runs: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut open = false;
    for (frame, value) in values.iter().enumerate() {
        match value {
            Some(value) => {
                let point = [frame as f64, *value];
                match runs.last_mut().filter(|_| open) {
                    Some(run) => run.push(point),
                    None => runs.push(vec![point]),
                }
                open = true;
            }
            None => open = false,
        }
    }
    runs
}

/// What a line means: a piece of it, and its name.
pub(in crate::inspector) fn legend(
    ui: &mut Ui,
    tokens: &Tokens,
    colour: Color32,
    style: TraceStyle,
    name: &str,
) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(20.0, 12.0), egui::Sense::hover());
    let ends = [rect.left_center(), rect.right_center()];
    let stroke = Stroke::new(2.0, colour);
    match style {
        TraceStyle::Solid => {
            ui.painter().line_segment(ends, stroke);
        }
        TraceStyle::Dashed => ui.painter().extend(egui::Shape::dashed_line(&ends, stroke, 5.0, 3.0)),
        TraceStyle::Dotted => ui.painter().extend(egui::Shape::dotted_line(&ends, colour, 4.0, 1.2)),
    }
    ui.label(RichText::new(name).size(11.0).color(tokens.muted));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_split_a_line() {
        let runs = runs_of(&[None, Some(1.0), Some(2.0), None, Some(3.0)]);
        assert_eq!(runs, vec![vec![[1.0, 1.0], [2.0, 2.0]], vec![[4.0, 3.0]]]);
    }
}
