//! What every command does, a file for each kind.

mod hands;
mod look;
mod masks;
mod object;
mod place;
mod retarget;

use agenticfocus::{
    clip::FrameIndex,
    engine::Request,
    session::{Command, Entry, ReviewState, Step},
};
use egui::{Context, ViewportCommand};

use super::{OperatorApp, dialogs::Purpose};
use crate::{
    canvas::Canvas,
    panels::Shell,
    state,
    ui_command::{Scope, UiCommand as C},
    widgets::blocked,
};

impl OperatorApp {
    /// Carries a command out, or says why not.
    pub(super) fn perform(&mut self, ctx: &Context, command: C) {
        let mut actions = Vec::new();
        let why_not = blocked(&self.context(&mut actions), command);
        if let Some(reason) = why_not {
            self.say(&format!("{}: {}", command.text(), lower_first(&reason)));
            return;
        }
        if self.panels_perform(ctx, command) {
            return;
        }
        match command.scope() {
            Scope::Global => self.perform_global(ctx, command),
            Scope::Step(Step::Object) => self.perform_object(command),
            Scope::Step(Step::Masks) => self.perform_masks(command),
            Scope::Step(Step::Template) => self.perform_template(command),
            Scope::Step(Step::Hands) => self.perform_hands(command),
            Scope::Step(Step::Retarget) => self.perform_retarget(command),
            Scope::Step(Step::Composite) => self.perform_composite(command),
            Scope::Step(Step::Review) => match command {
                C::Accept => self.accept(),
                C::Reject => {
                    self.judge(|reason, note| ReviewState::Rejected { reason, note }, "not usable");
                }
                _ => self.judge(|reason, note| ReviewState::Flagged { reason, note }, "look again"),
            },
        }
    }

    /// Gives canvas and shell the first chance: they know what is being drawn and typed.
    fn panels_perform(&mut self, ctx: &Context, command: C) -> bool {
        let mut canvas: Canvas = std::mem::take(&mut self.canvas);
        let mut shell: Shell = std::mem::take(&mut self.shell);
        let mut actions = Vec::new();
        let mut cx = self.context(&mut actions);
        let done = canvas.perform(command, &mut cx) || shell.perform(command, &mut cx);
        (self.canvas, self.shell) = (canvas, shell);
        for action in actions {
            self.carry_out(ctx, action);
        }
        done
    }

    /// What panels see.
    pub(super) fn context<'a>(
        &'a mut self,
        actions: &'a mut Vec<crate::action::Action>,
    ) -> state::Context<'a> {
        state::Context {
            workspace: self.workspace.as_ref(),
            queue: &self.queue,
            options: &mut self.options,
            pictures: &mut self.pictures,
            tokens: &self.tokens,
            recent: self.recent.paths(),
            demo: self.demo.as_deref(),
            actions,
        }
    }

    fn perform_global(&mut self, ctx: &Context, command: C) {
        match command {
            C::Open => self.ask_for(Purpose::OpenFile),
            C::OpenFolder => self.ask_for(Purpose::OpenFolder),
            C::NextClip => self.open_next(),
            C::Undo => self.step_history(Entry::Undo),
            C::Redo => self.step_history(Entry::Redo),
            C::Confirm => self.confirm(),
            C::Checkpoint => self.engine.send(Request::RetrySave),
            C::SaveElsewhere => self.ask_for(Purpose::SaveElsewhere),
            C::Pause => {
                let held = matches!(
                    self.workspace.as_ref().map(|workspace| &workspace.work),
                    Some(state::Work::Running { paused: true, .. })
                );
                self.ask(Request::Pause(!held));
            }
            C::Cancel => self.stop_work(),
            C::Rerun => self.work(),
            C::Export => self.ask(Request::Export),
            C::Quit => ctx.send_viewport_cmd(ViewportCommand::Close),
            C::PreviousFrame => self.seek_by(-1),
            C::NextFrame => self.seek_by(1),
            C::BackTen => self.seek_by(-10),
            C::OnTen => self.seek_by(10),
            C::FirstFrame => self.seek(FrameIndex(0)),
            C::LastFrame => self.seek(FrameIndex(u32::MAX)),
            C::PreviousEdit => {
                self.seek_among(&self.edited_frames(), false, "No edited frame before this one")
            }
            C::NextEdit => self.seek_among(&self.edited_frames(), true, "No edited frame after this one"),
            C::PreviousProblem => {
                self.seek_among(&self.problems(), false, "No frame before this one wants a look");
            }
            C::NextProblem => self.seek_among(&self.problems(), true, "No frame after this one wants a look"),
            other => self.perform_step(other),
        }
    }

    fn perform_step(&mut self, command: C) {
        let step = match command {
            C::NextStep => return self.walk_steps(true),
            C::PreviousStep => return self.walk_steps(false),
            C::StepObject => Step::Object,
            C::StepMasks => Step::Masks,
            C::StepTemplate => Step::Template,
            C::StepHands => Step::Hands,
            C::StepRetarget => Step::Retarget,
            C::StepComposite => Step::Composite,
            C::StepReview => Step::Review,
            other => return self.perform_look(other),
        };
        self.set_step(step);
    }

    fn ask_for(&mut self, purpose: Purpose) {
        let start = self.queue.path.clone().or_else(|| self.recent.paths().first().cloned());
        let folder =
            start.as_deref().map(|path| if path.is_dir() { path } else { path.parent().unwrap_or(path) });
        self.dialogs.ask(purpose, folder);
    }

    /// Takes the answer of a dialog.
    pub(super) fn hear_dialogs(&mut self) {
        match self.dialogs.answer() {
            Some((Purpose::SaveElsewhere, folder)) => self.engine.send(Request::SaveElsewhere(folder)),
            Some((_, path)) => self.open_path(path),
            None => {}
        }
    }

    fn stop_work(&mut self) {
        self.engine.send(Request::Cancel);
        if let Some(workspace) = &mut self.workspace {
            if workspace.exporting.is_some() {
                self.engine.send(Request::CancelExport);
            }
            // The masks that came stay on screen; the next propagation begins where it is told.
            if matches!(workspace.work, state::Work::Running { .. }) {
                workspace.work = state::Work::Cancelled;
            }
        }
    }

    /// Exports the session; masks that wait to be spread are spread by the export.
    pub(super) fn start_export(&mut self) {
        let Some(workspace) = &mut self.workspace else { return };
        workspace.exporting = Some((0.0, None));
        workspace.exported = None;
        self.engine.send(Request::Export);
    }

    fn problems(&self) -> Vec<FrameIndex> {
        self.workspace.as_ref().map(state::Workspace::problems).unwrap_or_default()
    }

    /// The selected frames, or the one on screen.
    pub(super) fn selected_frames(&self) -> (FrameIndex, FrameIndex) {
        let here = self.workspace.as_ref().map_or(FrameIndex(0), |workspace| workspace.playhead);
        self.options.selection.unwrap_or((here, here))
    }

    /// A change made of several, where there is any.
    pub(super) fn change_together(&mut self, mut commands: Vec<Command>) {
        match commands.len() {
            0 => {}
            1 => self.change(commands.remove(0), Vec::new()),
            _ => self.change(Command::Together(commands), Vec::new()),
        }
    }
}

fn lower_first(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}
