//! The end of a clip: what the machine checked, what the person decides, where the results go.

mod checklist;

pub use checklist::{ChecklistItem, Verdict, checklist};

use agenticfocus::{
    engine::Request,
    session::{Command, ReviewState},
};
use egui::{Button, Label, ProgressBar, RichText, TextEdit, Ui, vec2};

use super::parts::{hint, primary_button, section, sign, small_button};
use crate::{
    action::Action,
    state::{Context, Workspace},
    ui_command::UiCommand,
    widgets::{Icon, command_button, review_glyph, review_words},
};

/// Reasons people give most often, one click each.
const REASONS: [&str; 6] =
    ["wrong object", "masks", "hands lost", "robot misses", "background", "not the task"];

/// What is being typed.
#[derive(Debug, Default)]
pub(super) struct ReviewInspector {
    /// The words, and the decision they started from: another one (by undo, say) brings its own.
    words: Option<(ReviewState, Words)>,
}

#[derive(Clone, Debug, Default)]
struct Words {
    reason: String,
    note: String,
}

impl ReviewInspector {
    /// What there is to know before a decision, and what is to be said with one.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
        section(ui, cx, "Checked by the machine", |ui, cx| {
            for item in checklist(workspace) {
                check(ui, cx, &item);
            }
        });
        section(ui, cx, "Decision", |ui, cx| {
            let review = &workspace.document().review;
            let glyph = review_glyph(cx.tokens, review);
            sign(ui, cx.tokens, glyph.icon, glyph.colour, &review_words(review));
            ui.add_enabled_ui(workspace.is_writable(), |ui| explain(ui, self.words(review)));
        });
    }

    /// The decisions and the export, which are always in sight.
    pub(super) fn decide(&mut self, ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
        ui.spacing_mut().item_spacing = vec2(8.0, 4.0);
        ui.add_enabled_ui(workspace.is_writable(), |ui| {
            primary_button(ui, cx, UiCommand::Accept, ui.available_width());
            self.refuse(ui, cx, workspace);
        });
        export(ui, cx, workspace);
    }

    /// What is being typed about the decision as it stands.
    fn words(&mut self, review: &ReviewState) -> &mut Words {
        if self.words.as_ref().is_some_and(|(from, _)| from != review) {
            self.words = None;
        }
        let (_, words) = self.words.get_or_insert_with(|| (review.clone(), words_of(review)));
        words
    }

    /// A reason, and what is decided for it.
    fn refuse(&mut self, ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
        let review = &workspace.document().review;
        let words = self.words(review);
        let mut decision = None;
        ui.horizontal(|ui| {
            let width = 64.0;
            let room = ui.available_width() - 2.0 * (width + ui.spacing().item_spacing.x);
            let field = TextEdit::singleline(&mut words.reason)
                .hint_text("Reason")
                .align(egui::Align2::LEFT_CENTER)
                .min_size(vec2(room, 24.0))
                .desired_width(room - 8.0);
            ui.add(field).accessible_name("Reason");
            let (reason, note) = (words.reason.trim().to_owned(), words.note.trim().to_owned());
            let mut button = |command: UiCommand| {
                let button = Button::new(command.text()).min_size(vec2(width, 24.0));
                ui.add_enabled(!reason.is_empty(), button)
                    .on_hover_text(command.tooltip())
                    .on_disabled_hover_text("Give a reason first")
                    .clicked()
            };
            if button(UiCommand::Reject) {
                decision = Some(ReviewState::Rejected { reason: reason.clone(), note: note.clone() });
            }
            if button(UiCommand::Flag) {
                decision = Some(ReviewState::Flagged { reason: reason.clone(), note: note.clone() });
            }
        });
        if let Some(decision) = decision.filter(|decision| decision != review) {
            cx.ask(Action::Change(Command::SetReview(decision)));
        }
    }
}

/// Reasons at one click, and room for more.
fn explain(ui: &mut Ui, words: &mut Words) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 4.0);
        for reason in REASONS {
            let button = Button::selectable(words.reason == reason, reason).frame_when_inactive(true);
            if ui.add(button).accessible_name(format!("Reason: {reason}")).clicked() {
                reason.clone_into(&mut words.reason);
            }
        }
    });
    let note = TextEdit::multiline(&mut words.note)
        .hint_text("Note, if there is more to say")
        .desired_rows(2)
        .desired_width(f32::INFINITY);
    ui.add(note).accessible_name("Note");
}

fn words_of(review: &ReviewState) -> Words {
    match review.clone() {
        ReviewState::Rejected { reason, note } | ReviewState::Flagged { reason, note } => {
            Words { reason, note }
        }
        _ => Words::default(),
    }
}

fn check(ui: &mut Ui, cx: &mut Context<'_>, item: &ChecklistItem) {
    let tokens = cx.tokens;
    let (icon, colour) = match item.verdict {
        Verdict::Good => (Icon::Check, tokens.accent),
        Verdict::Look => (Icon::Warning, tokens.alarm),
        Verdict::Open => (Icon::Ring, tokens.muted),
    };
    ui.horizontal_top(|ui| {
        icon.show(ui, colour);
        ui.vertical(|ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            let name = RichText::new(item.name).color(tokens.text);
            match item.step {
                Some(step) => {
                    let go = format!("Go to {}", item.name.to_lowercase());
                    let link = ui.add(Label::new(name).sense(egui::Sense::click()));
                    let link = link.on_hover_cursor(egui::CursorIcon::PointingHand).on_hover_text(&go);
                    let enabled = link.enabled();
                    link.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Link, enabled, &go));
                    if link.clicked() {
                        cx.ask(Action::SetStep(step));
                    }
                }
                None => drop(ui.label(name)),
            }
            ui.label(RichText::new(&item.found).size(11.0).color(tokens.muted));
        });
    });
    ui.add_space(2.0);
}

fn export(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    if let Some((share, left)) = workspace.exporting {
        let left = left.map_or_else(String::new, |left| format!(" · {left:.0} s left"));
        let text = format!("{:.0} %{left}", 100.0 * share);
        ui.add(ProgressBar::new(share as f32).desired_height(20.0).corner_radius(4.0).text(text))
            .accessible_name("Progress of the export");
        if ui.button("Stop the export").on_hover_text("Nothing half written is left behind").clicked() {
            cx.ask(Action::Ask(Request::CancelExport));
        }
        return;
    }
    let tokens = cx.tokens;
    ui.horizontal(|ui| {
        command_button(ui, cx, UiCommand::Export);
        if workspace.exported.is_none() {
            hint(ui, tokens, "Now, or leave it to the batch");
        }
    });
    match &workspace.exported {
        None => {}
        Some(Ok(folder)) => {
            let path = folder.display().to_string();
            sign(ui, tokens, Icon::Check, tokens.accent, "Video, record and masks are in");
            ui.horizontal(|ui| {
                if small_button(ui, "Copy", "Copy the folder's path").clicked() {
                    ui.ctx().copy_text(path.clone());
                }
                let shown = RichText::new(&path).monospace().color(tokens.text);
                ui.add(Label::new(shown).truncate()).on_hover_text(&path);
            });
        }
        Some(Err(failure)) => {
            sign(ui, tokens, Icon::Warning, tokens.alarm, &format!("Not exported: {}", failure.message));
        }
    }
}
