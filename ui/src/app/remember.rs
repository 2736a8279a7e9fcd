//! What the window remembers between starts: panels, sizes, recent files. No part of any session.

use std::path::{Path, PathBuf};

/// Paths kept.
const KEPT: usize = 10;

/// Files that were opened, the newest first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Recent(Vec<PathBuf>);

impl Recent {
    pub(super) fn add(&mut self, path: &Path) {
        self.0.retain(|known| known != path);
        self.0.insert(0, path.to_owned());
        self.0.truncate(KEPT);
    }

    pub(super) fn paths(&self) -> &[PathBuf] {
        &self.0
    }
}
