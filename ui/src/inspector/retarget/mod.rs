//! Retargeting: a view from outside, numbers, parameters, plots.

mod angles;
mod knob;
mod limits;
mod method;
mod numbers;
mod plots;
mod scene;
mod sparc;
mod view;

pub use knob::{Knob, Turn};
pub(super) use numbers::followed;
pub use numbers::{SideNumbers, numbers_of};
pub use sparc::sparc;
pub use view::View;

use std::sync::Arc;

use agenticfocus::{
    geometry::{PerSide, Side},
    retarget::{Method, RobotMotion, Smoothing},
    session::{Command, RetargetSettings},
};
use egui::{Button, RichText, Ui, vec2};

use super::{
    hands::mark_of,
    parts::{Edit, Textures, folded_section, hint, mark, section},
};
use crate::{
    action::Action,
    state::{Context, Workspace},
    ui_command::UiCommand,
    widgets::command_button,
};
use knob::{smoothing_of, with_smoothing};

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
        self.parameters(ui, cx, workspace, motion.as_deref());
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
        let mut turning = Turning {
            settings: self.moving.unwrap_or(kept),
            touch: Touch::None,
            fitted: motion.map(|motion| motion.map.beta),
        };
        ui.add_enabled_ui(workspace.is_writable(), |ui| {
            section(ui, cx, "Scale and camera", |ui, cx| turning.camera(ui, cx));
            section(ui, cx, "Method", |ui, cx| turning.method(ui, cx));
            // A published method smooths in its own way and knows no corrections.
            if method::method_of(&turning.settings) != Method::Ours {
                return;
            }
            section(ui, cx, "Smoothing", |ui, cx| turning.smoothing(ui, cx));
            let corrected = Knob::WRISTS.iter().any(|knob| knob.is_changed(&kept));
            folded_section(ui, cx, "Wrist corrections", corrected, |ui, cx| turning.wrists(ui, cx));
        });
        self.ask(cx, kept, turning.settings, turning.touch);
    }

    /// Another step was opened while a slider moved: nobody will ever let go of it here.
    fn drop_a_drag_that_ended_elsewhere(&mut self, ui: &Ui, cx: &mut Context<'_>, kept: RetargetSettings) {
        let held = ui.input(|input| input.pointer.any_down() || input.pointer.any_released());
        if !held && self.moving.take().is_some_and(|moving| moving != kept) {
            cx.ask(Action::Preview(Command::SetRetarget(kept)));
        }
    }

    /// A slider that moves is previewed; where it comes to rest is one undo step, if it is another place.
    fn ask(&mut self, cx: &mut Context<'_>, kept: RetargetSettings, edited: RetargetSettings, touch: Touch) {
        match touch {
            Touch::None => {}
            Touch::Moves => {
                if self.moving.unwrap_or(kept) != edited {
                    cx.ask(Action::Preview(Command::SetRetarget(edited)));
                }
                self.moving = Some(edited);
            }
            Touch::Rests => {
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

/// What a person does to the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Touch {
    /// Nothing.
    None,
    /// One moves, and nothing is decided.
    Moves,
    /// One is to stay as it is now.
    Rests,
}

/// The parameters as they are shown, and what becomes of them meanwhile.
struct Turning {
    settings: RetargetSettings,
    touch: Touch,
    /// β, where it is fitted.
    fitted: Option<f64>,
}

impl Turning {
    fn knob(&mut self, ui: &mut Ui, cx: &Context<'_>, knob: Knob) {
        let (value, changed) = (knob.value(&self.settings, self.fitted), knob.is_changed(&self.settings));
        let (settings, touch) = match knob.row().show(ui, cx.tokens, value, changed) {
            Edit::None => return,
            Edit::Preview(value) => (knob.with(&self.settings, value), Touch::Moves),
            Edit::Keep(value) => (knob.with(&self.settings, value), Touch::Rests),
            Edit::Reset => (knob.reset(&self.settings), Touch::Rests),
        };
        (self.settings, self.touch) = (settings, touch);
    }

    fn method(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if let Some(chosen) = method::show(ui, cx, &self.settings) {
            (self.settings, self.touch) = (chosen, Touch::Rests);
        }
    }

    fn camera(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        for knob in Knob::CAMERA {
            if matches!(knob, Knob::Pitch | Knob::X) {
                ui.add_space(4.0);
            }
            self.knob(ui, cx, knob);
        }
        ui.add_space(4.0);
        ui.horizontal_wrapped(|ui| {
            command_button(ui, cx, UiCommand::FitBeta);
            command_button(ui, cx, UiCommand::ResetRetarget);
        });
        let beta = if Knob::Beta.is_changed(&self.settings) {
            "β is held by you"
        } else {
            "β is fitted so that 95 % of the frames come within reach"
        };
        hint(ui, cx.tokens, beta);
    }

    fn smoothing(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let now = smoothing_of(&self.settings);
        let width = (ui.available_width() - 2.0 * ui.spacing().item_spacing.x) / 3.0;
        let ways = [
            (Smoothing::ZeroPhase, "Both ways", "Forward and backward in time"),
            (Smoothing::Ema, "Forward", "Forward in time alone, as published"),
            (Smoothing::None, "None", "Joint angles as solved, within the limits of speed"),
        ];
        ui.horizontal(|ui| {
            for (way, text, meaning) in ways {
                let button = Button::selectable(way == now, text).frame_when_inactive(true);
                let name = format!("Smoothing: {}", text.to_lowercase());
                let response = ui.add_sized([width, 24.0], button).accessible_name(name);
                if response.on_hover_text(meaning).clicked() {
                    (self.settings, self.touch) = (with_smoothing(&self.settings, way), Touch::Rests);
                }
            }
        });
        ui.add_space(4.0);
        ui.add_enabled_ui(now != Smoothing::None, |ui| self.knob(ui, cx, Knob::Alpha));
        let lag = match now {
            Smoothing::ZeroPhase => "Nothing lags; wrists are put back on their targets",
            Smoothing::Ema => "The robot lags behind, the more the smaller α is",
            Smoothing::None => "α has no part in it",
        };
        hint(ui, cx.tokens, lag);
    }

    fn wrists(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        for (at, knob) in Knob::WRISTS.into_iter().enumerate() {
            if at == 3 {
                ui.add_space(4.0);
            }
            self.knob(ui, cx, knob);
        }
        hint(ui, cx.tokens, "Each hand turned about its wrist, which stays in its place");
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
