//! Retargeting: a view from outside, numbers, parameters, plots.

mod angles;
mod knob;
mod limits;
mod numbers;
mod plots;
mod scene;
mod sparc;
mod view;

pub use knob::Knob;
pub(super) use numbers::followed;
pub use numbers::{SideNumbers, numbers_of};
pub use sparc::sparc;
pub use view::View;

use std::sync::Arc;

use agenticfocus::{
    geometry::{PerSide, Side},
    retarget::RobotMotion,
    session::{Command, RetargetSettings},
};
use egui::{RichText, Ui, vec2};

use super::{
    hands::mark_of,
    parts::{Edit, Textures, hint, mark, section},
};
use crate::{
    action::Action,
    state::{Context, Workspace},
    ui_command::UiCommand,
    widgets::command_button,
};

/// Parameters that are being dragged, and numbers that take a moment to compute.
#[derive(Debug, Default)]
pub(super) struct RetargetInspector {
    /// While a slider moves: what it says, not yet kept.
    moving: Option<RetargetSettings>,
    numbers: Option<(Arc<RobotMotion>, PerSide<SideNumbers>)>,
    plots: plots::Plots,
}

impl RetargetInspector {
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        workspace: &Workspace,
        textures: &mut Textures,
    ) {
        let motion = workspace.found.motion.clone();
        ui.add_space(4.0);
        scene::show(ui, cx, workspace, motion.as_deref(), textures);
        if let Some(motion) = &motion {
            self.numbers(ui, cx, motion);
        }
        section(ui, cx, "Scale and camera", |ui, cx| {
            ui.add_enabled_ui(workspace.is_writable(), |ui| {
                self.parameters(ui, cx, workspace, motion.as_deref())
            });
        });
        if let Some(motion) = &motion {
            section(ui, cx, "Over the clip", |ui, cx| self.plots.show(ui, cx, workspace, motion));
        }
    }

    fn numbers(&mut self, ui: &mut Ui, cx: &Context<'_>, motion: &Arc<RobotMotion>) {
        let known = self.numbers.as_ref().is_some_and(|(of, _)| Arc::ptr_eq(of, motion));
        // While a slider moves a new motion comes many times a second: the last numbers stand until it rests.
        if !known && (self.moving.is_none() || self.numbers.is_none()) {
            self.numbers = Some((Arc::clone(motion), numbers_of(motion)));
        }
        let Some((_, numbers)) = &self.numbers else { return };
        ui.add_space(4.0);
        let width = (ui.available_width() - 16.0 - 4.0 * 8.0) / 4.0;
        let heads = [
            ("Error", "Mean distance of the wrist to its target"),
            ("In reach", "Share of frames whose target lies within reach"),
            ("Margin", "Least distance of an arm joint to its limit, as a share of its range"),
            ("SPARC", "Smoothness of the wrist's speed: nearer to 0 is smoother"),
        ];
        egui::Grid::new("numbers")
            .num_columns(5)
            .min_col_width(0.0)
            .min_row_height(16.0)
            .spacing(vec2(8.0, 2.0))
            .show(ui, |ui| {
                ui.label("");
                for (head, meaning) in heads {
                    ui.vertical(|ui| {
                        ui.set_width(width);
                        let text = RichText::new(head).size(11.0).color(cx.tokens.muted);
                        ui.label(text).on_hover_text(meaning);
                    });
                }
                ui.end_row();
                for (side, numbers) in numbers.iter() {
                    let (colour, letter) = mark_of(cx.tokens, side);
                    mark(ui, cx.tokens, colour, letter);
                    for text in texts_of(numbers) {
                        ui.label(RichText::new(text).size(15.0).strong().color(cx.tokens.text));
                    }
                    ui.end_row();
                }
            });
    }

    fn parameters(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        workspace: &Workspace,
        motion: Option<&RobotMotion>,
    ) {
        let kept = workspace.document().retarget;
        self.drop_a_drag_that_ended_elsewhere(ui, cx, kept);
        let mut edited = self.moving.unwrap_or(kept);
        let fitted = motion.map(|motion| motion.map.beta);
        let mut result = Edit::None;
        for knob in Knob::ALL {
            if matches!(knob, Knob::Pitch | Knob::X | Knob::Alpha) {
                ui.add_space(4.0);
            }
            let edit = knob.row().show(ui, cx.tokens, knob.value(&edited, fitted), knob.is_changed(&edited));
            match edit {
                Edit::None => continue,
                Edit::Preview(value) | Edit::Keep(value) => edited = knob.with(&edited, value),
                Edit::Reset => edited = knob.reset(&edited),
            }
            result = edit;
        }
        ui.add_space(4.0);
        ui.horizontal_wrapped(|ui| {
            command_button(ui, cx, UiCommand::FitBeta);
            command_button(ui, cx, UiCommand::ResetRetarget);
        });
        let fits = !Knob::Beta.is_changed(&edited);
        let beta = if fits {
            "β is fitted so that 95 % of the frames come within reach"
        } else {
            "β is held by you"
        };
        hint(ui, cx.tokens, beta);
        hint(ui, cx.tokens, "α smooths both ways in time: nothing lags");
        self.ask(cx, kept, edited, result);
    }

    /// Another step was opened while a slider moved: nobody will ever let go of it here.
    fn drop_a_drag_that_ended_elsewhere(&mut self, ui: &Ui, cx: &mut Context<'_>, kept: RetargetSettings) {
        let held = ui.input(|input| input.pointer.any_down() || input.pointer.any_released());
        if !held && self.moving.take().is_some_and(|moving| moving != kept) {
            cx.ask(Action::Preview(Command::SetRetarget(kept)));
        }
    }

    /// A slider that moves is previewed; where it comes to rest is one undo step, if it is another place.
    fn ask(&mut self, cx: &mut Context<'_>, kept: RetargetSettings, edited: RetargetSettings, edit: Edit) {
        match edit {
            Edit::None => {}
            Edit::Preview(_) => {
                if self.moving.unwrap_or(kept) != edited {
                    cx.ask(Action::Preview(Command::SetRetarget(edited)));
                }
                self.moving = Some(edited);
            }
            Edit::Keep(_) | Edit::Reset => {
                let moved = self.moving.take().is_some_and(|moving| moving != kept);
                if edited != kept {
                    cx.ask(Action::Change(Command::SetRetarget(edited)));
                } else if moved {
                    cx.ask(Action::Preview(Command::SetRetarget(kept)));
                }
            }
        }
    }
}

/// Error, reach, margin and smoothness as they are written.
fn texts_of(numbers: &SideNumbers) -> [String; 4] {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    [
        or_dash(numbers.mean_error.map(|metres| format!("{:.1} cm", 100.0 * metres))),
        or_dash(numbers.reachable.map(|share| format!("{:.0} %", 100.0 * share))),
        or_dash(numbers.limit_margin.map(|share| format!("{:.0} %", 100.0 * share))),
        or_dash(numbers.sparc.map(|sparc| format!("{sparc:.1}"))),
    ]
}

/// Word for a side at the start of a name.
fn word_of(side: Side) -> &'static str {
    match side {
        Side::Left => "Left",
        Side::Right => "Right",
    }
}
