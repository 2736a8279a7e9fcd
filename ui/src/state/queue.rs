//! The clips of the folder that was opened.

use std::path::PathBuf;

use agenticfocus::{engine::QueueItem, session::ReviewState};

/// A folder's clips.
#[derive(Clone, Debug, Default)]
pub struct Queue {
    /// The folder or manifest; `None` before one was opened.
    pub path: Option<PathBuf>,
    /// Its clips, sorted by name.
    pub items: Vec<QueueItem>,
}

impl Queue {
    /// The next clip after `id` (from the start without one, and around the end) that nobody decided about.
    pub fn next_unreviewed(&self, id: Option<&str>) -> Option<&QueueItem> {
        let at = id.and_then(|id| self.items.iter().position(|item| item.id == id));
        let start = at.map_or(0, |at| at + 1);
        let order = (start..self.items.len()).chain(0..start.min(self.items.len()));
        order
            .map(|index| &self.items[index])
            .filter(|item| Some(item.id.as_str()) != id && item.fault.is_none())
            .find(|item| matches!(item.review, ReviewState::Unreviewed | ReviewState::NeedsReview { .. }))
    }
}
