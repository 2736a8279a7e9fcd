//! Confirming steps: the rhythm in which a clip is finished by keyboard.

use agenticfocus::session::{Author, Command, ReviewState, Step};

use super::OperatorApp;

impl OperatorApp {
    /// Confirms the step on screen and goes to the next thing that needs a person.
    pub(super) fn confirm(&mut self) {
        let step = self.options.step;
        if step == Step::Review {
            self.accept();
            return;
        }
        let Some(workspace) = &self.workspace else { return };
        let mut commands = Vec::new();
        if step == Step::Object {
            let document = workspace.document();
            let choice = document.object.clone().or_else(|| workspace.found.choice.clone());
            // Confirmed, the machine's proposal becomes the operator's word.
            if let Some(choice) = choice.filter(|choice| choice.author != Author::Human) {
                commands.push(Command::SetObject(Some(choice.taken_by_person())));
            }
            if matches!(document.review, ReviewState::NeedsReview { .. }) {
                commands.push(Command::SetReview(ReviewState::Unreviewed));
            }
        }
        if !workspace.document().confirmed.contains(&step) {
            commands.push(Command::SetConfirmed { step, confirmed: true });
        }
        if !commands.is_empty() {
            self.change(Command::Together(commands), Vec::new());
        }
        let next = self.next_open_step(step);
        self.set_step(next);
    }

    /// The clip is good: on to the next one.
    pub(super) fn accept(&mut self) {
        self.change(Command::SetReview(ReviewState::Accepted), Vec::new());
        self.update_queue_review();
        if !self.queue.items.is_empty() {
            self.open_next();
        }
    }

    /// Sets a verdict with the reason and note that stand in the review already.
    pub(super) fn judge(&mut self, verdict: fn(String, String) -> ReviewState, reason: &str) {
        let Some(workspace) = &self.workspace else { return };
        let note = match &workspace.document().review {
            ReviewState::Rejected { note, .. } | ReviewState::Flagged { note, .. } => note.clone(),
            _ => String::new(),
        };
        self.change(Command::SetReview(verdict(reason.to_owned(), note)), Vec::new());
        self.update_queue_review();
    }

    /// Shows the verdict in the queue at once.
    pub(super) fn update_queue_review(&mut self) {
        let Some(workspace) = &self.workspace else { return };
        let document = workspace.document();
        if let Some(item) = self.queue.items.iter_mut().find(|item| item.id == document.clip.id) {
            item.review = document.review.clone();
        }
    }
}
