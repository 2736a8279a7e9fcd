//! Closing the window: not while changes would be lost without a word.

use agenticfocus::engine::SaveState;
use egui::{Context, ViewportCommand};

use super::OperatorApp;

impl OperatorApp {
    /// Holds the first wish to close while changes are not on disk; the second one is obeyed, unless there are more
    /// changes by then.
    pub(super) fn guard_closing(&mut self, ctx: &Context) {
        if !ctx.input(|input| input.viewport().close_requested()) {
            return;
        }
        let Some(workspace) = &self.workspace else { return };
        let SaveState::NotSaved { saved, reason, .. } = &workspace.save else { return };
        let sent = workspace.changes_sent;
        if self.told_unsaved.replace(sent) == Some(sent) {
            return;
        }
        let lost = match sent.saturating_sub(*saved) {
            1 => "1 change is".to_owned(),
            count => format!("{count} changes are"),
        };
        let text = format!(
            "{lost} not saved: {reason}. Free space or save elsewhere; close again to drop what is not"
        );
        ctx.send_viewport_cmd(ViewportCommand::CancelClose);
        self.say(&text);
    }
}
