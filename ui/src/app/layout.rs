//! One frame's drawing: the shell with canvas and inspector in it, messages over them.

use egui::{Align2, Area, Frame, Order, Ui, vec2};

use super::OperatorApp;
use crate::{
    action::Action,
    canvas::Canvas,
    inspector::Inspector,
    panels::{Shell, Timeline},
    widgets::icon_button,
};

/// Widest message, points.
const MESSAGE_WIDTH: f32 = 560.0;
/// Above the timeline, the status bar and the strip with the zoom, points.
const ABOVE: f32 = Timeline::HEIGHT + 26.0 + 40.0;

impl OperatorApp {
    pub(super) fn lay_out(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        // The panels' own state is taken out so that they may see everything else.
        let mut shell: Shell = std::mem::take(&mut self.shell);
        let mut canvas: Canvas = std::mem::take(&mut self.canvas);
        let mut inspector: Inspector = std::mem::take(&mut self.inspector);
        let mut cx = self.context(actions);
        shell.show(ui, &mut cx, |ui, cx| canvas.show(ui, cx), |ui, cx| inspector.show(ui, cx));
        (self.shell, self.canvas, self.inspector) = (shell, canvas, inspector);
        self.show_messages(ui);
    }

    fn show_messages(&mut self, ui: &Ui) {
        if self.messages.is_empty() {
            return;
        }
        let tokens = self.tokens.clone();
        let mut closed = None;
        Area::new(egui::Id::unique("messages"))
            .order(Order::Foreground)
            .anchor(Align2::CENTER_BOTTOM, vec2(0.0, -ABOVE))
            .show(ui.ctx(), |ui| {
                ui.set_max_width(MESSAGE_WIDTH);
                for (at, message) in self.messages.iter().enumerate() {
                    let frame = Frame::new()
                        .fill(tokens.raised)
                        .stroke((1.0, tokens.line))
                        .corner_radius(4)
                        .inner_margin(8);
                    frame.show(ui, |ui| {
                        ui.horizontal(|ui| {
                            ui.set_max_width(MESSAGE_WIDTH - 16.0);
                            if icon_button(ui, crate::widgets::Icon::Cross, "Close this message").clicked() {
                                closed = Some(at);
                            }
                            ui.add(egui::Label::new(&message.text).wrap());
                        });
                    });
                    ui.add_space(4.0);
                }
            });
        if let Some(at) = closed {
            self.messages.remove(at);
        }
    }
}
