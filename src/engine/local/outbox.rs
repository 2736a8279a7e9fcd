//! Where the engine's threads put what they have to tell.

use std::sync::mpsc;

use super::Waker;
use crate::engine::Event;

/// Sends events and wakes whoever reads them.
#[derive(Clone)]
pub(super) struct Outbox {
    sender: mpsc::Sender<Event>,
    waker: Waker,
}

impl Outbox {
    pub(super) fn new(sender: mpsc::Sender<Event>, waker: Waker) -> Self {
        Self { sender, waker }
    }

    pub(super) fn tell(&self, event: Event) {
        // Nobody listens any more only while the program ends.
        if self.sender.send(event).is_ok() {
            (self.waker)();
        }
    }

    pub(super) fn note(&self, text: &str) {
        self.tell(Event::Note(text.to_owned()));
    }
}
