//! The whole window over an engine that says what the test wants.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::mpsc::{Receiver, Sender, channel},
};

use agenticfocus::{
    engine::{Access, Engine, Event, Opened, Request, Revision},
    session::{Command, Document, Entry, History},
};
use agenticfocus_ui::{
    action::Action,
    app::{Dialogs, OperatorApp, Purpose},
};
use egui::{Key, Modifiers, vec2};
use egui_kittest::{Harness, kittest::Queryable as _};

/// Passes requests on and answers with what the test tells.
struct Puppet {
    requests: Sender<Request>,
    events: Receiver<Event>,
}

impl Engine for Puppet {
    fn send(&self, request: Request) {
        self.requests.send(request).unwrap();
    }

    fn poll(&self) -> Option<Event> {
        self.events.try_recv().ok()
    }
}

/// Nobody is asked for files here.
struct NoDialogs;

impl Dialogs for NoDialogs {
    fn ask(&mut self, _purpose: Purpose, _start: Option<&Path>) {}

    fn answer(&mut self) -> Option<(Purpose, PathBuf)> {
        None
    }
}

/// The whole window over a puppet.
pub struct Window {
    pub harness: Harness<'static, OperatorApp>,
    requests: Receiver<Request>,
    events: Sender<Event>,
}

impl Window {
    pub fn new() -> Self {
        let ((send, requests), (events, hear)) = (channel(), channel());
        let puppet = Puppet { requests: send, events: hear };
        let app = OperatorApp::new(Box::new(puppet), Box::new(NoDialogs));
        let harness = Harness::builder()
            .with_size(vec2(1440.0, 900.0))
            .with_os(egui::os::OperatingSystem::Nix)
            .build_ui_state(|ui, app: &mut OperatorApp| app.show(ui), app);
        Self { harness, requests, events }
    }

    /// With a session in which one change can be taken back.
    pub fn with_session(access: Access) -> Self {
        let mut window = Self::new();
        window.tell(Event::Opened(Box::new(opened(access))));
        window.asked();
        window
    }

    /// With the sample session, and everything about it found out.
    pub fn with_sample() -> Self {
        let mut window = Self::new();
        let (opened, found) = super::sample_session();
        window.tell(Event::Opened(Box::new(opened)));
        let revision = Revision(1);
        for finding in found {
            window.tell(Event::Found { revision, finding });
        }
        window.tell(Event::WorkEnded { revision, result: Ok(()) });
        window.asked();
        window
    }

    pub fn tell(&mut self, event: Event) {
        self.events.send(event).unwrap();
        self.harness.run_steps(3);
    }

    pub fn act(&mut self, action: Action) {
        let ctx = self.harness.ctx.clone();
        self.harness.state_mut().act(&ctx, action);
        self.harness.run_steps(3);
    }

    pub fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(3);
    }

    pub fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.harness.run_steps(3);
    }

    /// What was asked of the engine since the last time.
    pub fn asked(&self) -> Vec<Request> {
        self.requests.try_iter().collect()
    }

    pub fn says(&self, words: &str) -> bool {
        self.harness.query_all_by_label_contains(words).next().is_some()
    }

    pub fn document(&self) -> Document {
        self.harness.state().workspace().unwrap().document().clone()
    }
}

/// A session in which one change can be taken back.
pub fn opened(access: Access) -> Opened {
    let mut history = History::new(Document::default());
    history.apply(Entry::Do(Command::SetTask(Some("pour".to_owned())))).unwrap();
    let folder = PathBuf::from("/clips/cup.afs");
    Opened { folder, history, masks: BTreeMap::new(), access, notes: Vec::new() }
}
