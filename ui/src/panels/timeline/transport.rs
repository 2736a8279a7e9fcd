//! Play, step, speed; frame and time, shown and typed; the selection; the next problem.

use agenticfocus::clip::{FrameIndex, STANDARD_FPS};
use egui::{Align, Button, Key, Layout, Response, RichText, TextEdit, Ui, WidgetInfo, accesskit::Role, vec2};

use crate::{
    action::Action,
    state::{Context, PlaySpeed},
    theme::{Tokens, number_font},
    ui_command::UiCommand,
    widgets::{Icon, command_icon_button, icon_button, small},
};

/// The row above the filmstrip.
#[derive(Debug, Default)]
pub(super) struct Transport {
    frame_text: String,
    time_text: String,
    /// The frame field takes the keyboard when it is drawn next.
    pub wants_focus: bool,
}

impl Transport {
    /// Draws it; `problems` frames want a look.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>, problems: usize) {
        let size = vec2(ui.available_width(), Tokens::ROW);
        ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            buttons(ui, cx);
            ui.add_space(8.0);
            self.fields(ui, cx);
            ui.add_space(12.0);
            selection(ui, cx);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| next_problem(ui, cx, problems));
        });
    }

    fn fields(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let (playhead, last) =
            cx.workspace.map_or((FrameIndex(0), FrameIndex(0)), |w| (w.playhead, w.last_frame()));
        let known = cx.workspace.is_some_and(|workspace| workspace.frame_count() > 0);
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.label(small(cx.tokens, "frame"));
        let shown = if known { playhead.0.to_string() } else { String::new() };
        let field = typed(ui, known, &mut self.frame_text, &shown, 48.0, "Frame");
        let field = field.on_hover_text("Type a frame and press Enter (G)");
        if std::mem::take(&mut self.wants_focus) && known {
            field.request_focus();
        }
        if let Some(frame) = entered(ui, &field).then(|| self.frame_text.trim().parse().ok()).flatten() {
            cx.ask(Action::Seek(FrameIndex(frame).min(last)));
        }
        let total = if known { format!("/ {}", last.0) } else { "/ –".to_owned() };
        ui.label(RichText::new(total).font(number_font()).color(cx.tokens.muted));
        ui.add_space(8.0);
        let shown =
            if known { format!("{:.2}", f64::from(playhead.0) / STANDARD_FPS) } else { String::new() };
        let field = typed(ui, known, &mut self.time_text, &shown, 56.0, "Time in seconds");
        let field = field.on_hover_text("Type a time and press Enter: 4.57 or 1:04.5");
        if let Some(seconds) = entered(ui, &field).then(|| parse_time(&self.time_text)).flatten() {
            let frame = (seconds * STANDARD_FPS).round().clamp(0.0, f64::from(last.0)) as u32;
            cx.ask(Action::Seek(FrameIndex(frame)));
        }
        ui.label(small(cx.tokens, "s"));
    }
}

fn buttons(ui: &mut Ui, cx: &mut Context<'_>) {
    command_icon_button(ui, cx, Icon::First, UiCommand::FirstFrame);
    command_icon_button(ui, cx, Icon::Previous, UiCommand::PreviousFrame);
    let play = if cx.options.playing { Icon::Pause } else { Icon::Play };
    command_icon_button(ui, cx, play, UiCommand::PlayPause);
    command_icon_button(ui, cx, Icon::Next, UiCommand::NextFrame);
    command_icon_button(ui, cx, Icon::Last, UiCommand::LastFrame);
    speed(ui, cx);
}

fn speed(ui: &mut Ui, cx: &mut Context<'_>) {
    let text = RichText::new(cx.options.speed.text()).font(number_font());
    let button = Button::new(text).frame_when_inactive(false).min_size(vec2(36.0, Tokens::ROW));
    let response = ui.add(button);
    let name = format!("Speed {}", cx.options.speed.text());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    egui::Popup::menu(&response).width(64.0).show(|ui| {
        for speed in PlaySpeed::ALL {
            let text = RichText::new(speed.text()).font(number_font());
            let choice =
                Button::selectable(cx.options.speed == speed, text).min_size(vec2(64.0, Tokens::ROW));
            if ui.add(choice).clicked() {
                cx.options.speed = speed;
            }
        }
    });
    response.on_hover_text("How fast the clip plays");
}

/// A field that shows `shown` until somebody types into it.
fn typed(ui: &mut Ui, enabled: bool, text: &mut String, shown: &str, width: f32, name: &str) -> Response {
    let id = ui.make_persistent_id(name);
    let focused = ui.memory(|memory| memory.has_focus(id));
    let returned = ui.memory(|memory| memory.had_focus_last_frame(id));
    if !focused && !returned && text != shown {
        shown.clone_into(text);
    }
    let edit = TextEdit::singleline(text)
        .id(id)
        .font(number_font())
        .desired_width(width)
        .align(egui::Align2::RIGHT_CENTER)
        .margin(egui::Margin::symmetric(6, 3));
    let response = ui.add_enabled(enabled, edit);
    if response.gained_focus() {
        select_all(ui, id, text);
    }
    response.widget_info(|| {
        let mut info = WidgetInfo::text_edit(enabled, "", text.as_str(), "");
        info.label = Some(name.to_owned());
        info
    });
    response
}

/// Typing replaces what stands in the field.
fn select_all(ui: &Ui, id: egui::Id, text: &str) {
    use egui::text::{CCursor, CCursorRange};
    let mut state = TextEdit::load_state(ui.ctx(), id).unwrap_or_default();
    let all = CCursorRange::two(CCursor::new(0), CCursor::new(text.chars().count()));
    state.cursor.set_char_range(Some(all));
    TextEdit::store_state(ui.ctx(), id, state);
}

fn entered(ui: &Ui, field: &Response) -> bool {
    field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter))
}

/// Seconds from `4.57`, `4.57 s`, `1:04.5`.
fn parse_time(text: &str) -> Option<f64> {
    let text = text.trim().trim_end_matches('s').trim().replace(',', ".");
    let mut seconds = 0.0;
    for part in text.split(':') {
        let value: f64 = part.trim().parse().ok()?;
        seconds = seconds * 60.0 + value;
    }
    (seconds.is_finite() && seconds >= 0.0).then_some(seconds)
}

fn selection(ui: &mut Ui, cx: &mut Context<'_>) {
    let Some((first, last)) = cx.options.selection else { return };
    let count = last.0 - first.0 + 1;
    let frames = if count == 1 { "1 frame".to_owned() } else { format!("{count} frames") };
    ui.label(small(cx.tokens, format!("selected {}–{} · {frames}", first.0, last.0)));
    if icon_button(ui, Icon::Cross, "Select nothing").clicked() {
        cx.options.selection = None;
    }
}

/// Right to left: the button to the next problem, to the one before, and how many there are.
fn next_problem(ui: &mut Ui, cx: &mut Context<'_>, problems: usize) {
    if cx.workspace.is_none_or(|workspace| workspace.frame_count() == 0) {
        return;
    }
    if problems == 0 {
        ui.label(small(cx.tokens, "No frame needs a look"));
        return;
    }
    command_icon_button(ui, cx, Icon::Right, UiCommand::NextProblem);
    command_icon_button(ui, cx, Icon::Left, UiCommand::PreviousProblem);
    let words = if problems == 1 {
        "1 frame needs a look".to_owned()
    } else {
        format!("{problems} frames need a look")
    };
    ui.label(RichText::new(words).small().color(cx.tokens.alarm));
    Icon::Warning.show(ui, cx.tokens.alarm);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_as_people_write_them() {
        assert_eq!(parse_time("4.57"), Some(4.57));
        assert_eq!(parse_time(" 4,5 s "), Some(4.5));
        assert_eq!(parse_time("1:04.5"), Some(64.5));
        assert_eq!(parse_time("-1"), None);
        assert_eq!(parse_time("soon"), None);
    }
}
