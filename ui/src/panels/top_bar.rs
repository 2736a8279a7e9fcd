//! The bar at the top: menu, what is open, the method's steps with their progress, undo.

use agenticfocus::session::Step;
use egui::{
    Align, Button, Label, Layout, Popup, Rect, RichText, Sense, Ui, WidgetInfo, accesskit::Role,
    containers::menu::SubMenuButton, vec2,
};

use crate::{
    action::Action,
    state::{Context, StepState},
    theme::{ThemeChoice, Tokens},
    ui_command::UiCommand,
    widgets::{
        Chip, Icon, command_icon_button, command_menu_button, path_button, step_glyph, step_name, step_words,
    },
};

/// Room between two step chips, with the chevron in it, points.
const BETWEEN: f32 = 14.0;

/// Width of the menu of recent files, points.
const RECENT: f32 = 320.0;

/// The bar at the top.
#[derive(Debug, Default)]
pub struct TopBar;

impl TopBar {
    /// Draws it.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            menu(ui, cx);
            ui.add_space(4.0);
            let mut chips = chips_of(cx);
            let mut width = width_of(ui, &chips);
            if width > ui.available_width() - 160.0 {
                // With large text there is no room for all words: the glyphs stay, the words of the step on screen too.
                for chip in &mut chips {
                    chip.short = chip.step != cx.options.step;
                }
                width = width_of(ui, &chips);
            }
            let tools = 3.0 * Tokens::ROW + 2.0 * 4.0 + 12.0;
            let room = (ui.available_width() - width - tools - 16.0).max(0.0);
            title(ui, cx, room);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                command_icon_button(ui, cx, Icon::Search, UiCommand::Palette);
                command_icon_button(ui, cx, Icon::Redo, UiCommand::Redo);
                command_icon_button(ui, cx, Icon::Undo, UiCommand::Undo);
                ui.add_space(8.0);
                let size = vec2(width.min(ui.available_width()), Tokens::ROW);
                ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
                    steps(ui, cx, chips);
                });
            });
        });
    }
}

/// A step's chip with the words that say its state.
struct StepChip {
    step: Step,
    state: StepState,
    name: String,
    /// Drawn without its word.
    short: bool,
}

fn width_of(ui: &Ui, chips: &[StepChip]) -> f32 {
    chips.iter().map(|chip| chip.width(ui)).sum::<f32>() + 6.0 * BETWEEN
}

impl StepChip {
    fn chip<'a>(&'a self, tokens: &'a Tokens) -> Chip<'a> {
        let glyph = step_glyph(tokens, self.state);
        let count = match self.state {
            StepState::NeedsLook(count) => Some(count),
            _ => None,
        };
        let text = if self.short { "" } else { step_name(self.step) };
        Chip::new(tokens, text).named(&self.name).glyph(glyph.icon, glyph.colour).count(count).clickable()
    }

    fn width(&self, ui: &Ui) -> f32 {
        self.chip(&Tokens::dark()).size(ui).x
    }
}

fn chips_of(cx: &Context<'_>) -> Vec<StepChip> {
    Step::ALL
        .into_iter()
        .map(|step| {
            let state = cx.workspace.map_or(StepState::NotRun, |workspace| workspace.step_state(step));
            let name = format!("{}: {}", step_name(step), step_words(state));
            StepChip { step, state, name, short: false }
        })
        .collect()
}

fn steps(ui: &mut Ui, cx: &mut Context<'_>, chips: Vec<StepChip>) {
    ui.spacing_mut().item_spacing.x = 0.0;
    let open = cx.workspace.is_some();
    for (at, chip) in chips.iter().enumerate() {
        if at > 0 {
            let (rect, _) = ui.allocate_exact_size(vec2(BETWEEN, Tokens::ROW), Sense::hover());
            let colour = cx.tokens.muted.gamma_multiply(if open { 1.0 } else { 0.45 });
            Icon::Right.paint_at(ui.painter(), rect.center(), 9.0, colour);
        }
        let chosen = open && cx.options.step == chip.step;
        let response = ui.add_enabled(open, chip.chip(cx.tokens).chosen(chosen));
        if response.clicked() {
            cx.ask(Action::SetStep(chip.step));
        }
        let what = step_command(chip.step);
        let key = what.keys().first().map(|key| crate::widgets::key_text(ui.ctx(), key)).unwrap_or_default();
        response
            .on_hover_text(format!("{} ({key})\n{}", what.tooltip(), step_words(chip.state)))
            .on_disabled_hover_text("No clip open");
    }
}

fn step_command(step: Step) -> UiCommand {
    match step {
        Step::Object => UiCommand::StepObject,
        Step::Masks => UiCommand::StepMasks,
        Step::Template => UiCommand::StepTemplate,
        Step::Hands => UiCommand::StepHands,
        Step::Retarget => UiCommand::StepRetarget,
        Step::Composite => UiCommand::StepComposite,
        Step::Review => UiCommand::StepReview,
    }
}

/// Clip and task in at most `room` points, cut with an ellipsis.
fn title(ui: &mut Ui, cx: &Context<'_>, room: f32) {
    let Some(workspace) = cx.workspace else {
        ui.label(RichText::new("AgenticFocus").strong());
        return;
    };
    let document = workspace.document();
    let mut job = egui::text::LayoutJob::default();
    let font = egui::FontId::proportional(Tokens::TEXT);
    let plain = |colour| egui::TextFormat { font_id: font.clone(), color: colour, ..Default::default() };
    job.append(&document.clip.id, 0.0, plain(cx.tokens.text));
    if let Some(task) = &document.task {
        job.append(&format!("  ·  {task}"), 0.0, plain(cx.tokens.muted));
    }
    let full = job.text.clone();
    ui.allocate_ui_with_layout(vec2(room, Tokens::ROW), Layout::left_to_right(Align::Center), |ui| {
        ui.add(Label::new(job).truncate()).on_hover_text(format!("{full}\n{}", document.clip.path));
    });
}

fn menu(ui: &mut Ui, cx: &mut Context<'_>) {
    let button =
        Button::new(Icon::Menu.atom()).frame_when_inactive(false).min_size(egui::Vec2::splat(Tokens::ROW));
    let response = ui.add(button);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Menu"));
    Popup::menu(&response).width(232.0).show(|ui| {
        use UiCommand as C;
        ui.spacing_mut().item_spacing.y = 0.0;
        for group in [
            &[C::Open, C::OpenFolder, C::NextClip][..],
            &[C::Checkpoint, C::SaveElsewhere, C::Export],
            &[C::ToggleQueue, C::ToggleInspector, C::Larger, C::Smaller],
        ] {
            for command in group {
                command_menu_button(ui, cx, *command);
                if *command == C::OpenFolder {
                    recent(ui, cx);
                }
            }
            line(ui, cx.tokens);
        }
        theme(ui, cx);
        line(ui, cx.tokens);
        for command in [C::Palette, C::Keys, C::Quit] {
            command_menu_button(ui, cx, command);
        }
    });
}

/// What was opened before, in a menu of its own: it may be long.
fn recent(ui: &mut Ui, cx: &mut Context<'_>) {
    const TEXT: &str = "Open recent";
    let any = !cx.recent.is_empty();
    let button = Button::new(TEXT)
        .right_text(SubMenuButton::arrow_atom(None))
        .frame_when_inactive(false)
        .min_size(vec2(224.0, Tokens::ROW));
    if !any {
        let response = ui.add_enabled(false, button);
        response.widget_info(|| WidgetInfo::labeled(Role::Button, false, TEXT));
        response.on_disabled_hover_text("Nothing was opened yet");
        return;
    }
    let (response, _) = SubMenuButton::from_button(button).ui(ui, |ui| {
        ui.set_width(RECENT);
        ui.spacing_mut().item_spacing.y = 0.0;
        let paths = cx.recent;
        for path in paths {
            if path_button(ui, cx, path, RECENT).clicked() {
                ui.close();
            }
        }
    });
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, TEXT));
}

fn theme(ui: &mut Ui, cx: &mut Context<'_>) {
    ui.horizontal(|ui| {
        ui.add_space(2.0);
        ui.label(RichText::new("Theme"));
        ui.add_space(8.0);
        for (choice, text) in
            [(ThemeChoice::System, "System"), (ThemeChoice::Dark, "Dark"), (ThemeChoice::Light, "Light")]
        {
            if ui.add(Button::selectable(cx.options.theme == choice, text)).clicked() {
                cx.options.theme = choice;
            }
        }
    });
}

fn line(ui: &mut Ui, tokens: &Tokens) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 9.0), Sense::hover());
    let rect: Rect = rect;
    ui.painter().hline(rect.x_range(), rect.center().y, egui::Stroke::new(1.0, tokens.line));
}
