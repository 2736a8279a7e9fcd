//! Masks: what the tools do, how masks spread, and which frames want a look.

use agenticfocus::{
    clip::FrameIndex,
    engine::ModelUse,
    geometry::Side,
    inpaint::InpaintParams,
    segment::MaskAuthor,
    session::{Command, MaskLayer},
};
use egui::{Checkbox, ProgressBar, RichText, ScrollArea, Ui};

use super::{
    parts::{
        Edit, Parameter, choice_button, draft, empty, fact, go_to_frame, hint, made_by, model_fault, section,
        sign, tool_button, unavailable,
    },
    words::{author_of_mask, reasons_of},
};
use crate::{
    action::Action,
    state::{Context, Tool, Work, Workspace},
    ui_command::UiCommand,
    widgets::{Icon, command_button},
};

pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    section(ui, cx, "Target", |ui, cx| target(ui, cx, workspace));
    section(ui, cx, "Tool", |ui, cx| {
        ui.add_enabled_ui(workspace.is_writable(), |ui| tools(ui, cx));
    });
    section(ui, cx, "This frame", |ui, cx| this_frame(ui, cx, workspace));
    section(ui, cx, "Propagate", |ui, cx| propagate(ui, cx, workspace));
    section(ui, cx, "Frames that want a look", |ui, cx| problems(ui, cx, workspace));
    section(ui, cx, "Hole in the background", |ui, cx| hole(ui, cx, workspace));
    section(ui, cx, "View", view);
}

fn column(ui: &Ui, count: usize) -> f32 {
    (ui.available_width() - ui.spacing().item_spacing.x * (count - 1) as f32) / count as f32
}

fn target(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let width = column(ui, 3);
    ui.horizontal(|ui| {
        let arm = cx.options.arm();
        choice_button(ui, cx, UiCommand::LayerObject, "Object", arm.is_none(), width);
        choice_button(ui, cx, UiCommand::LayerLeftArm, "Left arm", arm == Some(Side::Left), width);
        choice_button(ui, cx, UiCommand::LayerRightArm, "Right arm", arm == Some(Side::Right), width);
    });
    let found = &workspace.found;
    match cx.options.mask_layer {
        MaskLayer::Object => {
            let fault = found.model_faults.get(&ModelUse::ObjectMasks);
            match &found.object {
                Some(track) => made_by(ui, cx.tokens, &track.backend, fault),
                None => fault.into_iter().for_each(|fault| model_fault(ui, cx.tokens, fault)),
            }
        }
        MaskLayer::Arms => {
            if let Some(track) = &found.arms {
                made_by(ui, cx.tokens, &track.union.backend, None);
            }
        }
    }
    if let Some(fault) = found.model_faults.get(&ModelUse::PointMasks) {
        model_fault(ui, cx.tokens, fault);
    }
}

fn tools(ui: &mut Ui, cx: &mut Context<'_>) {
    const TOOLS: [[(UiCommand, Tool); 3]; 2] = [
        [
            (UiCommand::Brush, Tool::Brush),
            (UiCommand::Eraser, Tool::Eraser),
            (UiCommand::PointsTool, Tool::Points),
        ],
        [
            (UiCommand::BoxTool, Tool::Box),
            (UiCommand::Polygon, Tool::Polygon),
            (UiCommand::Lasso, Tool::Lasso),
        ],
    ];
    let width = column(ui, 3);
    for row in TOOLS {
        ui.horizontal(|ui| {
            for (command, tool) in row {
                let chosen = cx.options.tool == tool;
                tool_button(ui, cx, command, chosen, width);
            }
        });
    }
    match cx.options.tool {
        Tool::Brush | Tool::Eraser => brush_size(ui, cx),
        Tool::Points => hint(ui, cx.tokens, "Click on it, right-click or Shift+click beside it"),
        Tool::Box | Tool::Polygon | Tool::Lasso => {
            hint(ui, cx.tokens, "Adds; takes away while Shift is held")
        }
    }
}

fn brush_size(ui: &mut Ui, cx: &mut Context<'_>) {
    ui.horizontal(|ui| {
        let label = ui.label(RichText::new("Size").color(cx.tokens.muted));
        ui.spacing_mut().slider_width = (ui.available_width() - 80.0).max(40.0);
        let slider = egui::Slider::new(&mut cx.options.brush_radius, 1.0..=100.0)
            .logarithmic(true)
            .max_decimals(0)
            .suffix(" px");
        ui.add(slider).labelled_by(label.id);
    });
}

fn this_frame(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let (layer, frame) = (cx.options.mask_layer, workspace.playhead);
    let edited = workspace.document().masks(layer).contains_key(&frame);
    match workspace.mask(layer, frame) {
        None => hint(ui, cx.tokens, "No mask yet: the machine has not come this far"),
        Some(mask) => {
            let what = if mask.absent { "absent, said by you" } else { author_of_mask(mask.author) };
            fact(ui, cx.tokens, "Mask", what);
            if mask.author != MaskAuthor::Human {
                fact(ui, cx.tokens, "Trust", &format!("{:.0} %", 100.0 * mask.score));
            }
            for reason in reasons_of(workspace, layer, frame) {
                sign(ui, cx.tokens, Icon::Warning, cx.tokens.alarm, &reason);
            }
        }
    }
    if let Some(points) = &workspace.draft {
        draft(ui, cx.tokens, points);
    }
    ui.add_enabled_ui(workspace.is_writable(), |ui| {
        ui.horizontal_wrapped(|ui| {
            command_button(ui, cx, UiCommand::Trust);
            command_button(ui, cx, UiCommand::Absent);
            if edited {
                command_button(ui, cx, UiCommand::ForgetMask);
            } else {
                unavailable(ui, UiCommand::ForgetMask, "This frame is the machine's already");
            }
        });
        ui.horizontal(|ui| {
            command_button(ui, cx, UiCommand::FillHoles);
            command_button(ui, cx, UiCommand::Grow);
            command_button(ui, cx, UiCommand::Shrink);
            let by = egui::DragValue::new(&mut cx.options.grow_by).range(1..=50).suffix(" px");
            ui.add(by).accessible_name("Grow and shrink by").on_hover_text("Grow and shrink by");
        });
    });
}

fn propagate(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    ui.add_enabled_ui(workspace.is_writable(), |ui| {
        let width = column(ui, 3);
        ui.horizontal(|ui| {
            choice_button(
                ui,
                cx,
                UiCommand::PropagateBackward,
                (Icon::Previous.atom(), "Back"),
                false,
                width,
            );
            choice_button(ui, cx, UiCommand::PropagateBoth, "Both ways", false, width);
            choice_button(ui, cx, UiCommand::PropagateForward, ("Forward", Icon::Next.atom()), false, width);
        });
    });
    match &workspace.work {
        Work::Running { share, left, paused, .. } => {
            let text = match (paused, left) {
                (true, _) => format!("{:.0} % · held", 100.0 * share),
                (false, Some(left)) => format!("{:.0} % · {left:.0} s left", 100.0 * share),
                (false, None) => format!("{:.0} %", 100.0 * share),
            };
            ui.add(ProgressBar::new(*share as f32).desired_height(20.0).corner_radius(4.0).text(text))
                .accessible_name("Progress of the work");
            ui.horizontal(|ui| {
                command_button(ui, cx, UiCommand::Pause);
                command_button(ui, cx, UiCommand::Cancel);
            });
        }
        Work::Cancelled => hint(ui, cx.tokens, "Stopped: every frame is as before or done"),
        Work::Failed(failure) => {
            sign(ui, cx.tokens, Icon::Warning, cx.tokens.alarm, &failure.message);
            command_button(ui, cx, UiCommand::Rerun);
        }
        Work::Idle => {
            hint(ui, cx.tokens, "Spreads your mask of this frame; your own masks are never changed")
        }
    }
}

fn problems(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let frames = doubtful(workspace, cx.options.mask_layer);
    if frames.is_empty() {
        empty(ui, cx.tokens, "Nothing doubtful", "Play through once, then confirm");
        return;
    }
    ui.horizontal(|ui| {
        hint(ui, cx.tokens, &format!("{} of {} frames", frames.len(), workspace.frame_count()));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            choice_button(ui, cx, UiCommand::NextProblem, "Next", false, 56.0);
            choice_button(ui, cx, UiCommand::PreviousProblem, "Previous", false, 72.0);
        });
    });
    let layer = cx.options.mask_layer;
    ScrollArea::vertical().id_salt("problems").max_height(176.0).auto_shrink([false, true]).show_rows(
        ui,
        24.0,
        frames.len(),
        |ui, rows| {
            for frame in &frames[rows] {
                let reasons = reasons_of(workspace, layer, *frame).join(", ");
                let width = ui.available_width();
                go_to_frame(ui, cx, *frame, &reasons, width);
            }
        },
    );
}

/// Frames whose mask of `layer` wants a look.
fn doubtful(workspace: &Workspace, layer: MaskLayer) -> Vec<FrameIndex> {
    use agenticfocus::segment::MaskFlag::{Occluded, TouchesBorder};
    let doubts = |frame: &FrameIndex| {
        workspace.mask_summary(layer, *frame).is_some_and(|(author, score, flags)| {
            let counts = flags.iter().any(|flag| !matches!(flag, TouchesBorder | Occluded));
            author != MaskAuthor::Human && (counts || score < 0.35)
        })
    };
    FrameIndex::all(workspace.frame_count()).filter(doubts).collect()
}

/// How far around the arms the background is restored.
fn hole(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let Some(size) = workspace.size() else {
        return hint(ui, cx.tokens, "The clip is still being read");
    };
    let width = f64::from(size.width);
    let kept = workspace.document().hole_dilation;
    let row = Parameter {
        name: "Widen",
        hint: "The arms' masks are widened by this before the background behind them is restored",
        unit: " px",
        range: 0.0..=(0.03 * width).round(),
        limits: 0.0..=(InpaintParams::WIDEST_DILATION * width).floor(),
        decimals: 0,
    };
    let shown = width * cx.options.hole_moving.unwrap_or_else(|| workspace.hole_dilation());
    let edit =
        ui.add_enabled_ui(workspace.is_writable(), |ui| row.show(ui, cx.tokens, shown, kept.is_some()));
    let wanted = match edit.inner {
        Edit::Preview(pixels) => {
            cx.options.hole_moving = Some(pixels / width);
            None
        }
        Edit::Keep(pixels) => Some(Some(pixels / width)),
        Edit::Reset => Some(None),
        Edit::None if ui.input(|input| input.pointer.any_down()) => None,
        Edit::None => {
            cx.options.hole_moving = None;
            None
        }
    };
    if let Some(wanted) = wanted {
        cx.options.hole_moving = None;
        if wanted != kept {
            cx.ask(Action::Change(Command::SetHoleDilation(wanted)));
        }
    }
    ui.add(Checkbox::new(&mut cx.options.hole_outline, "Outline of the hole"));
}

fn view(ui: &mut Ui, cx: &mut Context<'_>) {
    ui.horizontal(|ui| {
        let label = ui.label(RichText::new("Fill").color(cx.tokens.muted));
        ui.spacing_mut().slider_width = (ui.available_width() - 80.0).max(40.0);
        let slider = egui::Slider::new(&mut cx.options.mask_opacity, 0.0..=1.0)
            .custom_formatter(|value, _| format!("{:.0} %", 100.0 * value))
            .custom_parser(|text| Some(text.trim_end_matches('%').trim().parse::<f64>().ok()? / 100.0));
        ui.add(slider).labelled_by(label.id);
    });
    ui.add(Checkbox::new(&mut cx.options.onion_skin, "Outlines of the frames before and after"));
}
