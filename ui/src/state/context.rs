//! What every panel is handed.

use std::path::{Path, PathBuf};

use agenticfocus::engine::QueueItem;

use super::{Options, Pictures, Queue, Workspace};
use crate::{action::Action, theme::Tokens};

/// The window's state as a panel sees it: panels read the workspace, change options of their own, and ask for
/// everything else by pushing actions, which are carried out once after all panels were drawn.
#[derive(Debug)]
pub struct Context<'a> {
    /// The open session.
    pub workspace: Option<&'a Workspace>,
    /// The clips beside it.
    pub queue: &'a Queue,
    /// How the operator looks at things.
    pub options: &'a mut Options,
    /// Pictures from the engine.
    pub pictures: &'a mut Pictures,
    /// Colours and sizes.
    pub tokens: &'a Tokens,
    /// Files that were opened, the newest first.
    pub recent: &'a [PathBuf],
    /// A session to try the window with, where there is one.
    pub demo: Option<&'a Path>,
    /// What is to be done.
    pub actions: &'a mut Vec<Action>,
}

impl Context<'_> {
    /// Asks for `action`.
    pub fn ask(&mut self, action: Action) {
        self.actions.push(action);
    }

    /// The queue's item that is open.
    pub fn open_item(&self) -> Option<&QueueItem> {
        let id = &self.workspace?.document().clip.id;
        self.queue.items.iter().find(|item| item.id == *id)
    }
}
