//! The clips of the folder that was opened.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use agenticfocus::{engine::QueueItem, image::Rgb8, session::ReviewState};

/// A folder's clips.
#[derive(Clone, Debug, Default)]
pub struct Queue {
    /// The folder or manifest; `None` before one was opened.
    pub path: Option<PathBuf>,
    /// Its clips, sorted by name.
    pub items: Vec<QueueItem>,
}

impl Queue {
    /// Takes the picture of the item that opens `item`, if `path` is still the queue on screen.
    pub fn take_thumbnail(&mut self, path: &Path, item: &Path, picture: Arc<Rgb8>) {
        if self.path.as_deref() == Some(path)
            && let Some(item) = self.items.iter_mut().find(|known| known.path == item)
        {
            item.thumbnail = Some(picture);
        }
    }

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
