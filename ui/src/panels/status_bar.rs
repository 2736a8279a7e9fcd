//! The bar at the bottom: whether everything is saved, the keys of this step, work in progress.

use std::time::{Duration, SystemTime};

use agenticfocus::{
    engine::{Access, Request, SaveState, WorkFailure},
    session::Step,
};
use egui::{
    Align, Button, CornerRadius, Frame, Label, Layout, Margin, RichText, Sense, Ui, WidgetInfo,
    accesskit::Role, vec2,
};

use crate::{
    action::Action,
    state::{Context, Work, Workspace},
    theme::Tokens,
    ui_command::UiCommand,
    widgets::{Icon, IconButton, command_icon_button, key_caps, key_text, small, tooltip_with_key},
};

/// The bar at the bottom.
#[derive(Debug, Default)]
pub struct StatusBar;

impl StatusBar {
    /// Draws it.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 6.0;
            ui.spacing_mut().interact_size.y = 20.0;
            ui.spacing_mut().button_padding = vec2(6.0, 0.0);
            let Some(workspace) = cx.workspace else {
                hints(
                    ui,
                    cx,
                    &[
                        (UiCommand::Open, "open"),
                        (UiCommand::OpenFolder, "open a folder"),
                        (UiCommand::Palette, "all commands"),
                    ],
                );
                return;
            };
            let loud = saving(ui, cx, workspace);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                exporting(ui, cx, workspace);
                work(ui, cx, workspace);
                if !loud {
                    ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                        ui.add_space(8.0);
                        hints(ui, cx, keys_of(cx.options.step));
                    });
                }
            });
        });
    }
}

/// Whether everything is saved; returns whether it had to be loud about it.
fn saving(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) -> bool {
    if let Access::ReadOnly(holder) = &workspace.access {
        Icon::Lock.show(ui, cx.tokens.alarm);
        let words = format!("Read-only: {holder} writes to this session");
        ui.label(RichText::new(words).small().color(cx.tokens.alarm));
        return true;
    }
    match &workspace.save {
        SaveState::Saved(count) if *count >= workspace.changes_sent => {
            Icon::Check.show(ui, cx.tokens.muted);
            ui.label(small(cx.tokens, "Saved")).on_hover_text(workspace.folder.display().to_string());
            false
        }
        SaveState::Saved(_) => {
            Icon::HalfRing.show(ui, cx.tokens.muted);
            ui.label(small(cx.tokens, "Saving…"));
            false
        }
        SaveState::NotSaved { saved, since, reason } => {
            let waiting = workspace.changes_sent.saturating_sub(*saved);
            not_saved(ui, cx, *since, reason, waiting);
            true
        }
    }
}

fn not_saved(ui: &mut Ui, cx: &mut Context<'_>, since: SystemTime, reason: &str, waiting: u64) {
    let ago = SystemTime::now().duration_since(since).unwrap_or_default();
    let changes = if waiting == 1 { "1 change".to_owned() } else { format!("{waiting} changes") };
    let words = format!("Not saved since {} ago: {reason}", duration_words(ago));
    let frame = Frame::new()
        .fill(cx.tokens.alarm)
        .corner_radius(CornerRadius::same(Tokens::RADIUS))
        .inner_margin(Margin::symmetric(8, 2));
    let room = (ui.available_width() - 360.0).max(160.0);
    frame.show(ui, |ui| {
        ui.set_max_width(room);
        Icon::Warning.show(ui, cx.tokens.on_alarm);
        let text = RichText::new(&words).small().strong().color(cx.tokens.on_alarm);
        ui.add(Label::new(text).truncate())
            .on_hover_text(format!("{words}\n{changes} wait here and are tried again every few seconds"));
    });
    let retry = ui.add(Button::new(RichText::new("Retry").small()));
    if retry.on_hover_text("Try at once to write what waits").clicked() {
        cx.ask(Action::Ask(Request::RetrySave));
    }
    let elsewhere = ui.add(Button::new(RichText::new("Save elsewhere…").small()));
    elsewhere.widget_info(|| WidgetInfo::labeled(Role::Button, true, UiCommand::SaveElsewhere.text()));
    if elsewhere.on_hover_text(tooltip_with_key(ui.ctx(), UiCommand::SaveElsewhere)).clicked() {
        cx.ask(Action::Run(UiCommand::SaveElsewhere));
    }
}

/// `40 s`, `3 min`, `1 h 5 min`.
fn duration_words(time: Duration) -> String {
    match time.as_secs() {
        seconds @ 0..60 => format!("{seconds} s"),
        seconds @ 60..3600 => format!("{} min", seconds / 60),
        seconds => format!("{} h {} min", seconds / 3600, seconds % 3600 / 60),
    }
}

/// The keys most used in a step.
fn keys_of(step: Step) -> &'static [(UiCommand, &'static str)] {
    use UiCommand as C;
    match step {
        Step::Object => &[
            (C::Choose1, "take first"),
            (C::DrawBox, "box"),
            (C::DrawPoints, "points"),
            (C::Confirm, "confirm"),
        ],
        Step::Masks => &[
            (C::Brush, "brush"),
            (C::BrushSmaller, ""),
            (C::BrushLarger, "size"),
            (C::Eraser, "erase"),
            (C::HideMasks, "hide"),
            (C::Trust, "trust"),
            (C::PropagateForward, "propagate"),
            (C::NextProblem, "next problem"),
            (C::Confirm, "confirm"),
        ],
        Step::Template => &[
            (C::TemplateHere, "cut here"),
            (C::NudgeLeft, ""),
            (C::NudgeRight, "nudge"),
            (C::PlacementSmaller, ""),
            (C::PlacementLarger, "scale"),
            (C::Confirm, "confirm"),
        ],
        Step::Hands => &[
            (C::LeftHand, ""),
            (C::RightHand, "hand"),
            (C::SwapSides, "swap"),
            (C::InvalidHand, "invalid"),
            (C::InterpolateHand, "interpolate"),
            (C::Confirm, "confirm"),
        ],
        Step::Retarget => &[(C::FitBeta, "fit β"), (C::ResetRetarget, "reset"), (C::Confirm, "confirm")],
        Step::Composite => &[
            (C::OrderAuto, "auto"),
            (C::OrderRobot, "robot"),
            (C::OrderObject, "object"),
            (C::OrderThumb, "thumb"),
            (C::BeforeAfter, "before or after"),
            (C::Confirm, "confirm"),
        ],
        Step::Review => {
            &[(C::Accept, "accept"), (C::Reject, "reject"), (C::Flag, "flag"), (C::NextClip, "next clip")]
        }
    }
}

/// Key caps with their words, as many as fit.
fn hints(ui: &mut Ui, cx: &Context<'_>, keys: &[(UiCommand, &str)]) {
    ui.spacing_mut().item_spacing.x = 4.0;
    for (command, word) in keys {
        let Some(key) = command.keys().first() else { continue };
        // About seven points a letter in both fonts.
        let needed = 7.0 * (key_text(ui.ctx(), key).len() + word.len()) as f32 + 28.0;
        if ui.available_width() < needed {
            break;
        }
        key_caps(ui, cx.tokens, key).on_hover_text(command.tooltip());
        if !word.is_empty() {
            ui.label(small(cx.tokens, *word));
            ui.add_space(8.0);
        }
    }
}

/// What a stage does, in words.
fn stage_words(stage: &str) -> &str {
    match stage {
        "clip" => "Reading the clip",
        "landmarks" => "Finding hands",
        "select" => "Finding the object",
        "arms" => "Masking arms",
        "object" => "Masking the object",
        "template" => "Placing the template",
        "inpaint" => "Cleaning the background",
        "hands" => "Fitting hands",
        "retarget" => "Moving the robot",
        "render" | "composite" => "Composing frames",
        "export" => "Writing results",
        other => other,
    }
}

/// Drawn right to left.
fn work(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    match &workspace.work {
        Work::Idle => {}
        Work::Running { stage, share, left, paused } => {
            command_icon_button(ui, cx, Icon::Stop, UiCommand::Cancel);
            let hold = if *paused { Icon::Play } else { Icon::Pause };
            command_icon_button(ui, cx, hold, UiCommand::Pause);
            let words = if *paused { "Held" } else { stage_words(stage) };
            progress(ui, cx.tokens, words, *share, left.filter(|_| !paused));
        }
        Work::Cancelled => {
            again(ui, cx);
            ui.label(small(cx.tokens, "Work stopped, what was found stays"));
        }
        Work::Failed(failure) => {
            again(ui, cx);
            fault(ui, cx.tokens, &failure_words(failure));
        }
    }
}

fn failure_words(failure: &WorkFailure) -> String {
    match &failure.stage {
        Some(stage) => format!("{} ended early: {}", stage_words(stage), failure.message),
        None => failure.message.clone(),
    }
}

fn again(ui: &mut Ui, cx: &mut Context<'_>) {
    command_icon_button(ui, cx, Icon::Retry, UiCommand::Rerun);
}

fn fault(ui: &mut Ui, tokens: &Tokens, words: &str) {
    let label = Label::new(RichText::new(words).small().color(tokens.alarm)).truncate();
    let width = ui.available_width().min(480.0);
    ui.scope(|ui| {
        ui.set_max_width(width);
        ui.add(label).on_hover_text(words);
    });
    Icon::Warning.show(ui, tokens.alarm);
}

/// What goes on, a bar, per cent, time left; drawn right to left.
fn progress(ui: &mut Ui, tokens: &Tokens, words: &str, share: f64, left: Option<f64>) {
    let share = share.clamp(0.0, 1.0);
    if let Some(left) = left.filter(|left| left.is_finite() && *left >= 0.0) {
        let words = duration_words(Duration::from_secs_f64(left.min(1e6).ceil()));
        ui.label(small(tokens, format!("{words} left")));
    }
    let per_cent = format!("{:.0} %", (100.0 * share).floor());
    ui.label(RichText::new(per_cent).small().color(tokens.text));
    let (rect, response) = ui.allocate_exact_size(vec2(96.0, 6.0), Sense::hover());
    response.widget_info(|| {
        let mut info = WidgetInfo::labeled(Role::ProgressIndicator, true, words);
        info.value = Some(share);
        info
    });
    ui.painter().rect_filled(rect, CornerRadius::same(3), tokens.line);
    let mut full = rect;
    full.set_width((rect.width() * share as f32).max(4.0));
    ui.painter().rect_filled(full, CornerRadius::same(3), tokens.accent);
    ui.label(small(tokens, words));
}

/// Drawn right to left.
fn exporting(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    if let Some((share, left)) = workspace.exporting {
        if IconButton::new(Icon::Stop, "Stop the export").show(ui).clicked() {
            cx.ask(Action::Ask(Request::CancelExport));
        }
        return progress(ui, cx.tokens, "Exporting", share, left);
    }
    match &workspace.exported {
        None => {}
        Some(Ok(folder)) => {
            let name = folder
                .file_name()
                .map_or_else(|| folder.display().to_string(), |name| name.display().to_string());
            ui.label(small(cx.tokens, format!("Exported to {name}")))
                .on_hover_text(folder.display().to_string());
            Icon::Check.show(ui, cx.tokens.accent);
        }
        Some(Err(failure)) => fault(ui, cx.tokens, &format!("Not exported: {}", failure.message)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_said_as_people_say_them() {
        let words = |seconds| duration_words(Duration::from_secs(seconds));
        assert_eq!([words(8), words(61), words(3 * 3600 + 300)], ["8 s", "1 min", "3 h 5 min"]);
    }
}
