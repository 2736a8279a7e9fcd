//! Passes on what a run tells.

use std::{
    sync::{Mutex, PoisonError},
    time::Instant,
};

use super::scene::Shared;
use crate::{
    engine::{Event, Finding, ModelUse, Revision},
    pipeline::{ClipFailure, Decisions, Listener, Stage},
    session::{Author, Command},
};

/// Seconds left of work that began `elapsed` seconds ago with `from` done and has `share` done now.
pub(super) fn seconds_left(elapsed: f64, from: f64, share: f64) -> Option<f64> {
    let done = share - from;
    // The first moments say nothing about the rest.
    (done > 0.02 && elapsed > 1.0).then(|| elapsed * (1.0 - share) / done)
}

/// Hears a run for one document.
pub(super) struct WorkListener<'a> {
    shared: &'a Shared,
    revision: Revision,
    began: Mutex<Option<(Instant, f64)>>,
}

impl<'a> WorkListener<'a> {
    pub(super) fn new(shared: &'a Shared, revision: Revision) -> Self {
        Self { shared, revision, began: Mutex::default() }
    }
}

impl Listener for WorkListener<'_> {
    fn progress(&self, stage: Stage, _done: usize, _total: usize, share: f64) {
        let (began, from) = *self
            .began
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get_or_insert_with(|| (Instant::now(), share));
        self.shared.at_stage(stage);
        let left = seconds_left(began.elapsed().as_secs_f64(), from, share);
        self.shared.tell(Event::Progress { stage: stage.name(), share, left });
        self.shared.wait_while_paused();
    }

    fn note(&self, text: &str) {
        self.shared.outbox.note(text);
    }

    fn found(&self, finding: Finding) {
        let is_clip = matches!(finding, Finding::Clip(_));
        self.shared.tell(Event::Found { revision: self.revision, finding });
        if is_clip {
            self.shared.clip_is_there();
        }
    }

    fn model(&self, purpose: ModelUse, fault: Option<&str>) {
        self.shared.tell(Event::Model { purpose, fault: fault.map(str::to_owned) });
    }

    fn wants_every_mask(&self) -> bool {
        true
    }
}

/// Passes the machine's decisions on to who keeps the session.
pub(super) struct PassedOn<'a> {
    pub(super) shared: &'a Shared,
    pub(super) revision: Revision,
}

impl Decisions for PassedOn<'_> {
    fn decide(&mut self, author: Author, command: Command) -> Result<(), ClipFailure> {
        self.shared.tell(Event::Decided { revision: self.revision, author, command });
        Ok(())
    }
}
