//! The window: takes the engine's events and the operator's keys, draws the panels, carries out what they ask.

mod close;
mod dialogs;
mod edit;
mod events;
mod keys;
mod layout;
mod messages;
mod navigate;
mod perform;
mod play;
mod remember;
mod steps;

use std::{path::PathBuf, sync::Arc};

use agenticfocus::{
    engine::{Engine, Request, Revision},
    session::Document,
};
use egui::Ui;

use crate::{
    action::Action,
    canvas::Canvas,
    inspector::Inspector,
    panels::Shell,
    state::{Options, Pictures, Queue, Workspace},
    theme::{self, ThemeChoice, Tokens},
};

pub use dialogs::{Dialogs, NativeDialogs, Purpose};
pub use messages::Message;
pub use remember::window_file;

/// The operator's window.
pub struct OperatorApp {
    engine: Box<dyn Engine>,
    dialogs: Box<dyn Dialogs>,
    workspace: Option<Workspace>,
    /// What is being opened.
    opening: Option<PathBuf>,
    queue: Queue,
    options: Options,
    pictures: Pictures,
    tokens: Tokens,
    /// The theme and scale the style was made for.
    styled: Option<(ThemeChoice, bool)>,
    shell: Shell,
    canvas: Canvas,
    inspector: Inspector,
    messages: Vec<Message>,
    /// The document the engine works for, by its revision.
    working: Option<(Revision, Arc<Document>)>,
    play: play::Play,
    recent: remember::Recent,
    /// Where the window keeps itself; `None` where it does not.
    memory: Option<remember::Memory>,
    /// A session to try the window with.
    demo: Option<PathBuf>,
    /// Up to which change the operator was told that closing drops what is not on disk.
    told_unsaved: Option<u64>,
    /// Whether a control had the keyboard in the last frame.
    held_keyboard: bool,
}

impl std::fmt::Debug for OperatorApp {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OperatorApp").field("options", &self.options).finish_non_exhaustive()
    }
}

impl OperatorApp {
    /// A window over `engine`; `dialogs` asks the operator for files.
    pub fn new(engine: Box<dyn Engine>, dialogs: Box<dyn Dialogs>) -> Self {
        Self {
            engine,
            dialogs,
            workspace: None,
            opening: None,
            queue: Queue::default(),
            options: Options::default(),
            pictures: Pictures::default(),
            tokens: Tokens::dark(),
            styled: None,
            shell: Shell::default(),
            canvas: Canvas::default(),
            inspector: Inspector::default(),
            messages: Vec::new(),
            working: None,
            play: play::Play::default(),
            recent: remember::Recent::default(),
            memory: None,
            demo: None,
            told_unsaved: None,
            held_keyboard: false,
        }
    }

    /// Opens a clip, a session, or a folder or manifest as the queue.
    pub fn open(&mut self, path: PathBuf) {
        self.open_path(path);
    }

    /// Whether something is being opened.
    pub fn is_opening(&self) -> bool {
        self.opening.is_some()
    }

    /// The open session.
    pub fn workspace(&self) -> Option<&Workspace> {
        self.workspace.as_ref()
    }

    /// Shows a frame in a step.
    pub fn look_at(&mut self, frame: agenticfocus::clip::FrameIndex, step: agenticfocus::session::Step) {
        self.seek(frame);
        self.set_step(step);
    }

    /// How the operator looks at things.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// As [`Self::options`], to be changed from outside: for scripts and tests.
    pub fn options_mut(&mut self) -> &mut Options {
        &mut self.options
    }

    /// Whether the source picture of `frame` is here.
    pub fn has_source(&self, frame: agenticfocus::clip::FrameIndex) -> bool {
        self.pictures.has_source(frame)
    }

    /// Whether the composite of `frame` for that document is here.
    pub fn has_composite(&self, frame: agenticfocus::clip::FrameIndex, revision: Revision) -> bool {
        self.pictures.has_composite(frame, revision)
    }

    /// The clips of the folder that was opened.
    pub fn queue(&self) -> &Queue {
        &self.queue
    }

    /// The pictures that are here.
    pub fn pictures(&mut self) -> &mut Pictures {
        &mut self.pictures
    }

    /// What the window told the operator and was not closed yet.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// Carries out one action, as if a panel had asked for it.
    pub fn act(&mut self, ctx: &egui::Context, action: Action) {
        self.carry_out(ctx, action);
    }

    /// Hears the engine and passes wishes on, without drawing.
    pub fn pump(&mut self) {
        self.hear_engine();
        for request in self.pictures.wishes() {
            self.engine.send(Request::Show(request));
        }
    }

    /// Draws one frame.
    pub fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.style(&ctx);
        self.hear_engine();
        self.hear_dialogs();
        self.drop_old_messages(&ctx);
        self.guard_closing(&ctx);
        self.take_dropped_files(&ctx);
        let mut actions = self.take_keys(&ctx);
        self.keep_playing(&ctx);
        self.lay_out(ui, &mut actions);
        for action in actions {
            self.carry_out(&ctx, action);
        }
        for request in self.pictures.wishes() {
            self.engine.send(Request::Show(request));
        }
        self.remember(&ctx);
    }

    /// Makes egui's style from the tokens, where the theme changed.
    fn style(&mut self, ctx: &egui::Context) {
        let tokens = self.options.theme.tokens(ctx);
        let wanted = (self.options.theme, tokens.dark);
        if self.styled != Some(wanted) {
            theme::apply(ctx, &tokens);
            self.tokens = tokens;
            self.styled = Some(wanted);
        }
        if (ctx.zoom_factor() - self.options.zoom).abs() > 1e-3 {
            ctx.set_zoom_factor(self.options.zoom);
        }
    }

    fn take_dropped_files(&mut self, ctx: &egui::Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = dropped {
            self.open_path(path);
        }
    }

    fn carry_out(&mut self, ctx: &egui::Context, action: Action) {
        match action {
            Action::Run(command) => self.perform(ctx, command),
            Action::Change(command) => self.change(command, Vec::new()),
            Action::Preview(command) => self.preview(command),
            Action::ChangeMask { layer, frame, mask } => self.change_mask(layer, frame, &mask),
            Action::ChangeTemplateMask { mask } => self.change_template_mask(&mask),
            Action::Seek(frame) => self.seek(frame),
            Action::SetStep(step) => self.set_step(step),
            Action::Open(path) => self.open_path(path),
            Action::Ask(request) => self.ask(request),
        }
    }

    /// Passes a request on, noting what the window has to remember about it.
    fn ask(&mut self, request: Request) {
        match &request {
            Request::Pause(held) => {
                if let Some(crate::state::Work::Running { paused, .. }) =
                    self.workspace.as_mut().map(|workspace| &mut workspace.work)
                {
                    *paused = *held;
                }
            }
            Request::Segment { frame, positive, negative, .. } => {
                if let Some(workspace) = &mut self.workspace {
                    workspace.draft = Some(crate::state::Draft {
                        frame: *frame,
                        positive: positive.clone(),
                        negative: negative.clone(),
                        ..crate::state::Draft::default()
                    });
                }
            }
            Request::Export => self.start_export(),
            _ => {}
        }
        if !matches!(request, Request::Export) {
            self.engine.send(request);
        }
    }
}
