//! What the window has to tell the operator: stays until it is closed or a better one comes.

use std::time::{Duration, Instant};

use super::OperatorApp;

/// Messages shown at a time.
const SHOWN: usize = 3;
/// How long a note of the engine's stays.
const NOTE_TIME: Duration = Duration::from_secs(5);

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// What happened, to what, and what to do.
    pub text: String,
    /// When it goes by itself; `None` where somebody has to close it.
    until: Option<Instant>,
}

impl Message {
    pub(super) fn new(text: String) -> Self {
        Self { text, until: None }
    }
}

impl OperatorApp {
    /// Tells the operator something that they have to know: it stays until it is closed.
    pub(super) fn say(&mut self, text: &str) {
        self.show_message(Message::new(text.to_owned()));
    }

    /// Tells the operator how things go: it goes by itself.
    pub(super) fn mention(&mut self, text: &str) {
        let until = Some(Instant::now() + NOTE_TIME);
        self.show_message(Message { text: text.to_owned(), until });
    }

    fn show_message(&mut self, message: Message) {
        if self.messages.last().is_some_and(|last| last.text == message.text) {
            return;
        }
        self.messages.push(message);
        let surplus = self.messages.len().saturating_sub(SHOWN);
        self.messages.drain(..surplus);
    }

    /// Drops what had its time.
    pub(super) fn drop_old_messages(&mut self, ctx: &egui::Context) {
        let now = Instant::now();
        self.messages.retain(|message| message.until.is_none_or(|until| until > now));
        if let Some(next) = self.messages.iter().filter_map(|message| message.until).min() {
            ctx.request_repaint_after(next - now);
        }
    }
}
