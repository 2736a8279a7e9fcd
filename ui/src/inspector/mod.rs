//! The inspector: what a step knows about the clip, and what a person can change about it.

mod answer;
mod composite;
mod edits;
mod hands;
mod masks;
mod object;
mod parts;
mod retarget;
mod review;
mod template;
mod words;

pub use edits::{
    LayerOrderChange, choose_template_frame, layer_order_on, with_layer_order, without_layer_order,
    without_swap,
};
pub use retarget::{Knob, SideNumbers, Turn, View, numbers_of, sparc};
pub use review::{ChecklistItem, Verdict, checklist};
pub use words::{author_of_mask, flag_reason, reasons_of};

use agenticfocus::session::{Command, Step};
use egui::{Panel, RichText, ScrollArea, Ui};

use crate::{
    action::Action,
    state::{Context, StepState, Workspace},
    ui_command::UiCommand,
    widgets::{Icon, step_name},
};
use parts::Textures;

/// The panel on the right. Keeps what is being typed and the textures of small pictures.
#[derive(Debug, Default)]
pub struct Inspector {
    clip: String,
    textures: Textures,
    object: object::ObjectInspector,
    template: template::TemplateInspector,
    retarget: retarget::RetargetInspector,
    review: review::ReviewInspector,
    /// The keyboard is to go to the first control.
    wants_keyboard: bool,
}

impl Inspector {
    /// Gives the keyboard to the first control when it is drawn next.
    pub fn take_keyboard(&mut self) {
        self.wants_keyboard = true;
    }

    /// Draws the inspector of the step on screen.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let Some(workspace) = cx.workspace else {
            parts::empty(
                ui,
                cx.tokens,
                "No clip open",
                "Drop a video on the window, or open one from the queue",
            );
            return;
        };
        let id = &workspace.document().clip.id;
        if *id != self.clip {
            *self = Self { clip: id.clone(), ..Self::default() };
        }
        let step = cx.options.step;
        Panel::bottom("inspector_confirm")
            .show_separator_line(true)
            .frame(egui::Frame::new().inner_margin(egui::Margin::symmetric(12, 8)).fill(cx.tokens.panel))
            .show(ui, |ui| match step {
                Step::Review => self.review.decide(ui, cx, workspace),
                _ => confirm(ui, cx, workspace, step),
            });
        if std::mem::take(&mut self.wants_keyboard) {
            // What is drawn next and takes keys gets them.
            ui.memory_mut(|memory| {
                if let Some(id) = memory.focused() {
                    memory.surrender_focus(id);
                }
                memory.move_focus(egui::FocusDirection::Next);
            });
        }
        ScrollArea::vertical().id_salt(("inspector", step)).auto_shrink(false).show(ui, |ui| {
            egui::Frame::new().inner_margin(egui::Margin::symmetric(12, 8)).show(ui, |ui| {
                ui.spacing_mut().item_spacing = egui::vec2(8.0, 4.0);
                self.step(ui, cx, workspace, step);
            });
        });
    }

    fn step(&mut self, ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace, step: Step) {
        ui.label(RichText::new(step_name(step)).size(15.0).strong().color(cx.tokens.text));
        match step {
            Step::Object => self.object.show(ui, cx, workspace, &mut self.textures),
            Step::Masks => masks::show(ui, cx, workspace),
            Step::Template => self.template.show(ui, cx, workspace, &mut self.textures),
            Step::Hands => hands::show(ui, cx, workspace),
            Step::Retarget => self.retarget.show(ui, cx, workspace, &mut self.textures),
            Step::Composite => composite::show(ui, cx, workspace, &mut self.textures),
            Step::Review => self.review.show(ui, cx, workspace),
        }
    }
}

/// The button that ends a step, always in the same place.
fn confirm(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace, step: Step) {
    ui.horizontal(|ui| {
        if workspace.step_state(step) == StepState::Confirmed {
            Icon::Check.show(ui, cx.tokens.accent);
            ui.label(RichText::new("Confirmed").color(cx.tokens.text));
            let size = egui::vec2(ui.available_width(), 24.0);
            let layout = egui::Layout::right_to_left(egui::Align::Center);
            ui.allocate_ui_with_layout(size, layout, |ui| {
                let button = egui::Button::new("Take back");
                if ui.add_enabled(workspace.is_writable(), button).clicked() {
                    cx.ask(Action::Change(Command::SetConfirmed { step, confirmed: false }));
                }
            });
        } else {
            ui.add_enabled_ui(workspace.is_writable(), |ui| {
                parts::primary_button(ui, cx, UiCommand::Confirm, ui.available_width());
            });
        }
    });
}
