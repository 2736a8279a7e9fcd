//! A number that can be dragged, typed and put back to its default.

use std::ops::RangeInclusive;

use egui::{DragValue, Label, RichText, Sense, Slider, SliderClamping, Ui, vec2};

use crate::theme::Tokens;

/// What a person did to a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::inspector) enum Edit {
    /// Nothing.
    None,
    /// It moves, and nothing is decided.
    Preview(f64),
    /// It is to be this.
    Keep(f64),
    /// It is to be its default again.
    Reset,
}

/// A row: name, slider, field with unit, reset dot.
#[derive(Clone, Debug)]
pub(in crate::inspector) struct Parameter<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it means, on hover.
    pub hint: &'a str,
    /// Its unit.
    pub unit: &'a str,
    /// What the slider covers.
    pub range: RangeInclusive<f64>,
    /// What may be typed.
    pub limits: RangeInclusive<f64>,
    /// Digits after the point.
    pub decimals: usize,
}

impl Parameter<'_> {
    /// Draws the row; `changed` says that the value is not the default.
    pub fn show(&self, ui: &mut Ui, tokens: &Tokens, value: f64, changed: bool) -> Edit {
        let mut edited = value;
        let mut result = Edit::None;
        ui.horizontal(|ui| {
            ui.set_min_height(24.0);
            let label = Label::new(RichText::new(self.name).color(tokens.muted)).truncate();
            let column = egui::Layout::left_to_right(egui::Align::Center);
            let label = ui.allocate_ui_with_layout(vec2(48.0, 24.0), column, |ui| {
                ui.set_width(48.0);
                ui.add(label)
            });
            let label = label.inner.on_hover_text(self.hint);
            let field_width = 76.0;
            ui.spacing_mut().slider_width = (ui.available_width() - field_width - 12.0 - 16.0).max(48.0);
            let slider = Slider::new(&mut edited, self.range.clone())
                .clamping(SliderClamping::Edits)
                .show_value(false);
            let slider = ui.add(slider).labelled_by(label.id).on_hover_text(self.hint);
            let speed = (self.range.end() - self.range.start()) / 400.0;
            let field = DragValue::new(&mut edited)
                .range(self.limits.clone())
                .clamp_existing_to_range(false)
                .speed(speed)
                .min_decimals(self.decimals.min(1))
                .max_decimals(self.decimals)
                .suffix(self.unit)
                .update_while_editing(false);
            let field = ui.add_sized(vec2(field_width, 24.0), field);
            let field = field.accessible_name(format!("{} value", self.name));
            result = self.edit(value, edited, &slider, &field);
            if self.reset_dot(ui, tokens, changed) {
                result = Edit::Reset;
            }
        });
        result
    }

    fn edit(&self, before: f64, after: f64, slider: &egui::Response, field: &egui::Response) -> Edit {
        let scale = 10_f64.powi(self.decimals as i32);
        // Digits that nobody sees are not kept, but a value that did not change is left alone.
        let after = if after == before { before } else { (after * scale).round() / scale };
        if slider.drag_stopped() || field.drag_stopped() {
            Edit::Keep(after)
        } else if after == before {
            Edit::None
        } else if slider.dragged() || field.dragged() {
            Edit::Preview(after)
        } else {
            Edit::Keep(after)
        }
    }

    fn reset_dot(&self, ui: &mut Ui, tokens: &Tokens, changed: bool) -> bool {
        let size = vec2(12.0, 24.0);
        if !changed {
            ui.allocate_space(size);
            return false;
        }
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let name = format!("Reset {}", self.name);
        let enabled = ui.is_enabled();
        response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Button, enabled, &name));
        let radius = if response.hovered() || response.has_focus() { 5.0 } else { 4.0 };
        ui.painter().circle_filled(rect.center(), radius, tokens.accent);
        response.on_hover_text("Back to the default").clicked()
    }
}
