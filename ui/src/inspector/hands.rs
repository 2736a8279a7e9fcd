//! Both hands: what is known of them, and what a person says about them.

use agenticfocus::{
    clip::{CameraSpec, FrameIndex},
    engine::ModelUse,
    geometry::Side,
    hands::{HandState, HandTrack},
    session::{Command, RetargetSettings},
};
use egui::{Color32, RichText, Ui};

use super::{
    edits::without_swap,
    parts::{
        Edit, Parameter, Share, bar_of_shares, choice_button, fact, frame_with_cross, go_to_frame, hint,
        made_by, mark, model_fault, section, sign, unavailable,
    },
};
use crate::{
    action::Action,
    state::{Context, Workspace},
    theme::Tokens,
    ui_command::UiCommand,
    widgets::{Icon, command_button},
};

/// Hand length where nothing is known, millimetres: the mean of adults.
const MEAN_HAND_LENGTH_MM: f64 = 187.0;

pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    section(ui, cx, "Hand to correct", |ui, cx| {
        which(ui, cx);
        back_end(ui, cx, workspace);
    });
    for side in Side::BOTH {
        section(ui, cx, title_of(side), |ui, cx| one_hand(ui, cx, workspace, side));
    }
    section(ui, cx, "Correct", |ui, cx| {
        hint(
            ui,
            cx.tokens,
            &format!("{} hand, {}", title_of_side(cx.options.side), frames_in_words(cx, workspace)),
        );
        ui.add_enabled_ui(workspace.is_writable(), |ui| {
            ui.horizontal_wrapped(|ui| {
                command_button(ui, cx, UiCommand::SwapSides);
                command_button(ui, cx, UiCommand::InvalidHand);
                if cx.options.selection.is_some() {
                    command_button(ui, cx, UiCommand::InterpolateHand);
                } else {
                    unavailable(ui, UiCommand::InterpolateHand, "Select frames on the timeline first");
                }
                command_button(ui, cx, UiCommand::ForgetHand);
            });
        });
        swaps(ui, cx, workspace);
        edits(ui, cx, workspace);
    });
    section(ui, cx, "Scale", |ui, cx| scale(ui, cx, workspace));
}

/// Who found the hands, and why a learned model did not.
fn back_end(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let fault = workspace.found.model_faults.get(&ModelUse::Hands);
    match &workspace.found.hands {
        Some(track) => made_by(ui, cx.tokens, &track.backend, fault),
        None => fault.into_iter().for_each(|fault| model_fault(ui, cx.tokens, fault)),
    }
}

fn title_of(side: Side) -> &'static str {
    match side {
        Side::Left => "Left hand",
        Side::Right => "Right hand",
    }
}

fn title_of_side(side: Side) -> &'static str {
    match side {
        Side::Left => "Left",
        Side::Right => "Right",
    }
}

/// Colour and letter of a side.
pub(super) fn mark_of(tokens: &Tokens, side: Side) -> (Color32, &'static str) {
    match side {
        Side::Left => (tokens.left, "L"),
        Side::Right => (tokens.right, "R"),
    }
}

/// The frames that commands mean: the selection, or the one on screen.
pub(super) fn frames_meant(cx: &Context<'_>, workspace: &Workspace) -> (FrameIndex, FrameIndex) {
    cx.options.selection.unwrap_or((workspace.playhead, workspace.playhead))
}

/// The same in words.
pub(super) fn frames_in_words(cx: &Context<'_>, workspace: &Workspace) -> String {
    match frames_meant(cx, workspace) {
        (first, last) if first == last => format!("frame {}", first.0),
        (first, last) => format!("frames {} to {}", first.0, last.0),
    }
}

fn which(ui: &mut Ui, cx: &mut Context<'_>) {
    let width = 0.5 * (ui.available_width() - ui.spacing().item_spacing.x);
    ui.horizontal(|ui| {
        let side = cx.options.side;
        choice_button(ui, cx, UiCommand::LeftHand, "Left", side == Side::Left, width);
        choice_button(ui, cx, UiCommand::RightHand, "Right", side == Side::Right, width);
    });
}

fn one_hand(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace, side: Side) {
    let tokens = cx.tokens;
    let (colour, letter) = mark_of(tokens, side);
    let Some(track) = &workspace.found.hands else {
        return hint(ui, tokens, "Not estimated yet");
    };
    let Some(hand) = track.hands[side].get(workspace.playhead.as_usize()) else { return };
    ui.horizontal(|ui| {
        mark(ui, tokens, colour, letter);
        let (icon, words) = state_in_words(hand.state);
        icon.show(ui, tokens.muted);
        ui.label(RichText::new(words).color(tokens.text));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let trust =
                if hand.is_valid() { format!("{:.0} %", 100.0 * hand.confidence) } else { "–".to_owned() };
            ui.label(RichText::new(trust).strong().color(tokens.text))
                .on_hover_text("Confidence on this frame");
        });
    });
    let shares = shares_of(track, side);
    bar_of_shares(
        ui,
        tokens,
        &[
            Share { share: shares[0], colour, hatched: false },
            Share { share: shares[1], colour, hatched: true },
        ],
    );
    let [seen, bridged, absent] = shares.map(|share| format!("{:.0} %", 100.0 * share));
    hint(ui, tokens, &format!("Over the clip: seen {seen}, bridged {bridged}, absent {absent}"));
}

fn state_in_words(state: HandState) -> (Icon, &'static str) {
    match state {
        HandState::Observed => (Icon::Dot, "seen"),
        HandState::Bridged => (Icon::HalfRing, "bridged over a gap"),
        HandState::Invalid => (Icon::Ring, "not usable"),
    }
}

/// Shares of the clip on which a hand is seen, bridged and absent.
fn shares_of(track: &HandTrack, side: Side) -> [f64; 3] {
    let frames = &track.hands[side];
    let share =
        |state| frames.iter().filter(|hand| hand.state == state).count() as f64 / frames.len().max(1) as f64;
    [share(HandState::Observed), share(HandState::Bridged), share(HandState::Invalid)]
}

fn swaps(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    for (index, range) in workspace.document().sides_swapped.iter().enumerate() {
        let (first, last) = (range.first.0, range.last.0);
        let text = format!("left and right exchanged to {last}");
        let name = format!("Take back the exchange on frames {first} to {last}");
        if frame_with_cross(ui, cx, range.first, &text, &name) {
            cx.ask(Action::Change(without_swap(workspace.document(), index)));
        }
    }
}

fn edits(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let side = cx.options.side;
    let edits = &workspace.document().hand_edits[side];
    if edits.is_empty() {
        return;
    }
    hint(
        ui,
        cx.tokens,
        &match edits.len() {
            1 => "1 frame corrected by you".to_owned(),
            count => format!("{count} frames corrected by you"),
        },
    );
    let frames: Vec<_> = edits.iter().collect();
    egui::ScrollArea::vertical().id_salt("hand_edits").max_height(96.0).auto_shrink([false, true]).show_rows(
        ui,
        24.0,
        frames.len(),
        |ui, rows| {
            for (frame, edit) in &frames[rows] {
                let what = if edit.invalid {
                    "not usable".to_owned()
                } else {
                    match edit.keypoints.len() {
                        1 => "1 joint moved".to_owned(),
                        count => format!("{count} joints moved"),
                    }
                };
                let width = ui.available_width();
                go_to_frame(ui, cx, **frame, &what, width);
            }
        },
    );
}

fn scale(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let settings = workspace.document().retarget;
    let fitted = workspace.found.hands.as_ref().map(|track| track.hand_length);
    let metres = settings.hand_length.or_else(|| fitted.and_then(|fitted| fitted.right.or(fitted.left)));
    let length = metres.map_or(MEAN_HAND_LENGTH_MM, |metres| 1e3 * metres);
    let row = Parameter {
        name: "Length",
        hint: "Wrist to tip of the middle finger, stretched out; depth grows with it",
        unit: " mm",
        range: 140.0..=230.0,
        limits: 100.0..=300.0,
        decimals: 0,
    };
    if let Some(value) = settled(ui, cx, workspace, &row, length, settings.hand_length.is_some()) {
        let hand_length = value.map(|millimetres| 1e-3 * millimetres);
        if hand_length != settings.hand_length {
            cx.ask(Action::Change(Command::SetRetarget(RetargetSettings { hand_length, ..settings })));
        }
    }
    if let Some(fitted) = fitted {
        let text =
            |side| fitted[side].map_or("–".to_owned(), |metres: f64| format!("{:.0} mm", 1e3 * metres));
        fact(ui, cx.tokens, "Fitted", &format!("left {}, right {}", text(Side::Left), text(Side::Right)));
    }
    if let Some(clip) = &workspace.found.clip {
        let camera = clip.intrinsics;
        let across = 2.0 * (0.5 * f64::from(camera.size.width) / camera.fx).atan().to_degrees();
        field_of_view(ui, cx, workspace, across);
        fact(ui, cx.tokens, "Focal length", &format!("{:.0} px, {across:.0}° across", camera.fx));
        camera_source(ui, cx.tokens, &clip.intrinsics_source);
    }
}

/// The camera's field of view, where no calibration says more.
fn field_of_view(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace, across: f64) {
    let given = match workspace.document().camera {
        CameraSpec::Intrinsics { .. } => return,
        CameraSpec::HorizontalFov(degrees) => Some(degrees),
        CameraSpec::Unknown => None,
    };
    let row = Parameter {
        name: "View",
        hint: "The camera's horizontal field of view, as filmed",
        unit: "°",
        range: 40.0..=130.0,
        limits: 1.0..=179.0,
        decimals: 0,
    };
    if let Some(value) = settled(ui, cx, workspace, &row, given.unwrap_or(across), given.is_some())
        && value != given
    {
        let camera = value.map_or(CameraSpec::Unknown, CameraSpec::HorizontalFov);
        cx.ask(Action::Change(Command::SetCamera(camera)));
    }
}

/// A number for which much is computed anew, too much to follow a slider: only where it comes to rest counts.
/// `Some(None)` puts it back to its default.
fn settled(
    ui: &mut Ui,
    cx: &Context<'_>,
    workspace: &Workspace,
    row: &Parameter<'_>,
    value: f64,
    changed: bool,
) -> Option<Option<f64>> {
    let id = ui.scope_id().with(row.name);
    let shown = ui.data(|data| data.get_temp(id)).unwrap_or(value);
    let edit = ui.add_enabled_ui(workspace.is_writable(), |ui| row.show(ui, cx.tokens, shown, changed)).inner;
    if let Edit::Preview(value) = edit {
        ui.data_mut(|data| data.insert_temp(id, value));
    } else if !ui.input(|input| input.pointer.any_down()) {
        ui.data_mut(|data| data.remove::<f64>(id));
    }
    match edit {
        Edit::None | Edit::Preview(_) => None,
        Edit::Keep(value) => Some(Some(value)),
        Edit::Reset => Some(None),
    }
}

fn camera_source(ui: &mut Ui, tokens: &Tokens, source: &CameraSpec) {
    match source {
        CameraSpec::Intrinsics { .. } => hint(ui, tokens, "Calibration given for this clip"),
        CameraSpec::HorizontalFov(degrees) => {
            hint(ui, tokens, &format!("Field of view of {degrees:.0}° given for this clip"));
        }
        CameraSpec::Unknown => {
            let degrees = agenticfocus::clip::DEFAULT_FOV_DEG;
            let text = format!("Nothing known of the camera: {degrees:.0}° taken, depth may be off");
            sign(ui, tokens, Icon::Warning, tokens.alarm, &text);
        }
    }
}
