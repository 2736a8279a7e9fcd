//! The command palette: any command by a few letters of its name.

use agenticfocus::session::Step;
use egui::{
    Align, Align2, CornerRadius, FontId, Frame, Id, Key, Layout, Margin, Modal, Modifiers, Rect, RichText,
    ScrollArea, Sense, TextEdit, Ui, WidgetInfo, accesskit::Role, pos2, vec2,
};

use crate::{
    action::Action,
    state::{Context, Options},
    theme::Tokens,
    ui_command::UiCommand,
    widgets::{Icon, blocked_in_its_step, key_text, small, step_name},
};

/// Width of the palette, points.
const WIDTH: f32 = 560.0;
/// Height of a row, points.
const ROW: f32 = 28.0;
/// Rows in sight.
const ROWS: f32 = 12.0;

/// The palette.
#[derive(Debug, Default)]
pub struct Palette {
    text: String,
    chosen: usize,
    was_open: bool,
}

/// How well `pattern` fits `text`: its letters in order, better at the starts of words and side by side;
/// `None` where it does not.
pub fn fuzzy(pattern: &str, text: &str) -> Option<i32> {
    let text: Vec<char> = text.chars().flat_map(char::to_lowercase).collect();
    let (mut at, mut score, mut last) = (0, 0, None);
    for letter in pattern.chars().flat_map(char::to_lowercase).filter(|letter| !letter.is_whitespace()) {
        let starts_word = |index: usize| index == 0 || !text[index - 1].is_alphanumeric();
        let from = |start: usize| (start..text.len()).filter(|index| text[*index] == letter);
        // The letter right behind the last one, else the start of a word, else wherever it comes next.
        let next = from(at)
            .next()
            .filter(|index| last.is_some_and(|last| *index == last + 1))
            .or_else(|| from(at).find(|index| starts_word(*index)))
            .or_else(|| from(at).next())?;
        score += match last {
            Some(last) if next == last + 1 => 8,
            _ if starts_word(next) => 6,
            _ => 0,
        };
        score -= (next - at).min(6) as i32;
        last = Some(next);
        at = next + 1;
    }
    Some(score)
}

/// A command that fits what was typed.
struct Found {
    command: UiCommand,
    /// The step to go to first.
    step: Option<Step>,
    reason: Option<String>,
    score: i32,
}

fn find(cx: &Context<'_>, pattern: &str) -> Vec<Found> {
    let mut found: Vec<Found> = UiCommand::all()
        .filter(|command| *command != UiCommand::Palette)
        .filter_map(|command| {
            let by_name = fuzzy(pattern, command.text()).map(|score| 20 + 2 * score);
            let said = command.tooltip().to_lowercase().contains(&pattern.trim().to_lowercase());
            let score = by_name.or(said.then_some(0))?;
            let step = command.scope().step().filter(|step| *step != cx.options.step);
            Some(Found { command, step, reason: blocked_in_its_step(cx, command), score })
        })
        .collect();
    // What can be done now comes first; the sort is stable, so equals stay in the table's order.
    let rest = pattern.trim().is_empty();
    found.sort_by_key(|found| (found.reason.is_some(), rest && found.step.is_some(), -found.score));
    found
}

impl Palette {
    /// Opens or closes it.
    pub fn toggle(&mut self, options: &mut Options) {
        options.palette_open = !options.palette_open;
    }

    /// Draws it over everything, while it is open.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if !cx.options.palette_open {
            self.was_open = false;
            return;
        }
        if !self.was_open {
            (self.text, self.chosen, self.was_open) = (String::new(), 0, true);
        }
        let id = Id::unique("command palette");
        let area = Modal::default_area(id).anchor(Align2::CENTER_TOP, vec2(0.0, 64.0));
        let frame = Frame::new()
            .fill(cx.tokens.panel)
            .stroke(egui::Stroke::new(1.0, cx.tokens.line))
            .corner_radius(CornerRadius::same(2 * Tokens::RADIUS))
            .shadow(ui.visuals().window_shadow)
            .inner_margin(Margin::same(8));
        let modal = Modal::new(id).area(area).frame(frame).show(ui.ctx(), |ui| self.contents(ui, cx));
        if modal.should_close() || modal.inner {
            cx.options.palette_open = false;
        }
    }

    /// Returns whether a command was taken.
    fn contents(&mut self, ui: &mut Ui, cx: &mut Context<'_>) -> bool {
        ui.set_width(WIDTH.min(ui.ctx().content_rect().width() - 48.0));
        ui.spacing_mut().item_spacing.y = 0.0;
        let pressed = |ui: &Ui, key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
        let (up, down, enter) =
            (pressed(ui, Key::ArrowUp), pressed(ui, Key::ArrowDown), pressed(ui, Key::Enter));
        let edit = TextEdit::singleline(&mut self.text)
            .hint_text("Find a command")
            .desired_width(f32::INFINITY)
            .margin(Margin::symmetric(8, 6));
        let field = ui.add(edit);
        field.widget_info(|| {
            let mut info = WidgetInfo::text_edit(true, "", self.text.as_str(), "Find a command");
            info.label = Some("Find a command".to_owned());
            info
        });
        field.request_focus();
        if field.changed() {
            self.chosen = 0;
        }
        ui.add_space(8.0);
        let found = find(cx, &self.text);
        let count = found.len();
        if down && count > 0 {
            self.chosen = (self.chosen + 1) % count;
        }
        if up && count > 0 {
            self.chosen = (self.chosen + count - 1) % count;
        }
        self.chosen = self.chosen.min(count.saturating_sub(1));
        if count == 0 {
            ui.add_space(8.0);
            ui.label(small(cx.tokens, format!("No command is called “{}”", self.text.trim())));
            ui.add_space(8.0);
        }
        let mut taken = enter.then(|| found.get(self.chosen)).flatten();
        let scroll = ScrollArea::vertical().max_height(ROWS * ROW).min_scrolled_height(ROWS * ROW);
        scroll.auto_shrink([false, true]).show(ui, |ui| {
            for (at, one) in found.iter().enumerate() {
                let chosen = at == self.chosen;
                let response = row(ui, cx.tokens, one, chosen);
                if chosen && (up || down) {
                    response.scroll_to_me(None);
                }
                if response.clicked() {
                    taken = Some(one);
                }
            }
        });
        let Some(taken) = taken.filter(|found| found.reason.is_none()) else { return false };
        if let Some(step) = taken.step {
            cx.ask(Action::SetStep(step));
        }
        cx.ask(Action::Run(taken.command));
        true
    }
}

fn row(ui: &mut Ui, tokens: &Tokens, found: &Found, chosen: bool) -> egui::Response {
    let can = found.reason.is_none();
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let text = found.command.text();
    response.widget_info(|| WidgetInfo::selected(Role::Button, can, chosen, text));
    if !ui.is_rect_visible(rect) {
        return response;
    }
    if chosen || response.hovered() {
        let fill = if chosen { tokens.selected } else { tokens.hovered };
        ui.painter().rect_filled(rect, CornerRadius::same(Tokens::RADIUS), fill);
    }
    let colour = if can { tokens.text } else { tokens.muted };
    let place = |text: &str, x: f32, align: Align2, size: f32, colour| {
        ui.painter().text(pos2(x, rect.center().y), align, text, FontId::proportional(size), colour)
    };
    let name = place(text, rect.left() + 8.0, Align2::LEFT_CENTER, Tokens::TEXT, colour);
    let mut right = rect.right() - 8.0;
    if let Some(key) = found.command.keys().first() {
        let keys = key_text(ui.ctx(), key);
        right = place(&keys, right, Align2::RIGHT_CENTER, Tokens::SMALL, tokens.muted).left() - 16.0;
    }
    if let Some(step) = found.step {
        let words = format!("in {}", step_name(step));
        right = place(&words, right, Align2::RIGHT_CENTER, Tokens::SMALL, tokens.muted).left() - 16.0;
    }
    let (about, colour) = match &found.reason {
        Some(reason) => (reason.as_str(), tokens.muted),
        None if found.command.tooltip() == text => ("", tokens.muted),
        None => (found.command.tooltip(), tokens.muted),
    };
    let mut detail = ui.new_child(
        egui::UiBuilder::new()
            .max_rect(Rect::from_min_max(pos2(name.right() + 16.0, rect.top()), pos2(right, rect.bottom())))
            .layout(Layout::left_to_right(Align::Center)),
    );
    if !can {
        Icon::Lock.show(&mut detail, tokens.muted);
    }
    detail.add(egui::Label::new(RichText::new(about).small().color(colour)).truncate());
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_letters_find_a_command() {
        let best = |pattern: &str| {
            UiCommand::all()
                .filter_map(|command| Some((fuzzy(pattern, command.text())?, command)))
                .max_by_key(|(score, command)| (*score, std::cmp::Reverse(*command)))
                .map(|(_, command)| command)
        };
        assert_eq!(best("undo"), Some(UiCommand::Undo));
        assert_eq!(best("prof"), Some(UiCommand::PropagateForward));
        assert_eq!(best("swap l"), Some(UiCommand::SwapSides));
        assert_eq!(best("xyzzy"), None);
    }
}
