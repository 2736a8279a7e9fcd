//! Closing the window: not while changes would be lost without a word.

use agenticfocus::engine::SaveState;
use egui::{Context, ViewportCommand};

use super::OperatorApp;

impl OperatorApp {
    /// Holds the first wish to close while changes are not on disk; the second one is obeyed.
    pub(super) fn guard_closing(&mut self, ctx: &Context) {
        if !ctx.input(|input| input.viewport().close_requested()) || self.told_unsaved {
            return;
        }
        let Some(SaveState::NotSaved { saved, reason, .. }) =
            self.workspace.as_ref().map(|workspace| workspace.save.clone())
        else {
            return;
        };
        let sent = self.workspace.as_ref().map_or(0, |workspace| workspace.changes_sent);
        let lost = sent.saturating_sub(saved);
        ctx.send_viewport_cmd(ViewportCommand::CancelClose);
        self.told_unsaved = true;
        self.say(&format!(
            "{lost} changes are not saved: {reason}. Free space or save elsewhere; close again to drop them"
        ));
    }
}
