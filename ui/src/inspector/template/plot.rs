//! Trust in the placement over the clip.

use agenticfocus::{clip::FrameIndex, template::TemplateTrack};
use egui::Ui;
use egui_plot::{MarkerShape, Points};

use crate::{
    inspector::parts::{Trace, TraceStyle, time_plot},
    state::Workspace,
    theme::Tokens,
};

/// Draws the plot; the frame that was clicked, if one was.
pub(super) fn confidence(
    ui: &mut Ui,
    tokens: &Tokens,
    workspace: &Workspace,
    track: &TemplateTrack,
) -> Option<FrameIndex> {
    let trust =
        |frame: usize| track.placements.get(frame)?.as_ref().map(|placement| 100.0 * placement.confidence);
    let values = (0..track.placements.len()).map(trust).collect();
    let trace = Trace { name: "Trust", values, colour: tokens.template, style: TraceStyle::Solid };
    let keyframes: Vec<[f64; 2]> = workspace
        .document()
        .template
        .placements
        .keys()
        .map(|frame| [f64::from(frame.0), trust(frame.as_usize()).unwrap_or(0.0)])
        .collect();
    time_plot(ui, tokens, "placement_trust", " %", workspace.playhead, &[trace], |plot| {
        plot.set_plot_bounds_y(-5.0..=105.0);
        plot.points(
            Points::new("Keyframes", keyframes)
                .shape(MarkerShape::Diamond)
                .radius(5.0)
                .color(tokens.text)
                .allow_hover(false),
        );
    })
}
