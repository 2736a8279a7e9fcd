//! Choosing the object.

use agenticfocus::session::Command;

use super::super::OperatorApp;
use crate::ui_command::UiCommand as C;

impl OperatorApp {
    pub(super) fn perform_object(&mut self, command: C) {
        match command {
            C::Choose1 => self.choose(0),
            C::Choose2 => self.choose(1),
            C::Choose3 => self.choose(2),
            C::Choose4 => self.choose(3),
            C::Choose5 => self.choose(4),
            C::NoObject => self.change(Command::SetObject(None), Vec::new()),
            // The canvas draws boxes and takes points.
            _ => {}
        }
    }

    /// Takes a proposal and shows the frame it was made on.
    fn choose(&mut self, at: usize) {
        let Some(workspace) = &self.workspace else { return };
        let Some(proposal) = workspace.document().proposals.get(at).cloned() else {
            self.say(&format!("There is no proposal {}", at + 1));
            return;
        };
        let frame = proposal.frame;
        self.change(Command::SetObject(Some(proposal.taken_by_person())), Vec::new());
        self.seek(frame);
    }
}
