//! Files that were opened.

use std::path::{Path, PathBuf};

/// Paths kept.
const KEPT: usize = 10;

/// Files that were opened, the newest first; absolute, so that they mean the same wherever the window starts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::app) struct Recent(Vec<PathBuf>);

impl Recent {
    pub(in crate::app) fn new(paths: impl IntoIterator<Item = PathBuf>) -> Self {
        let mut kept: Vec<PathBuf> = Vec::new();
        for path in paths {
            if path.is_absolute() && !kept.contains(&path) && kept.len() < KEPT {
                kept.push(path);
            }
        }
        Self(kept)
    }

    pub(in crate::app) fn add(&mut self, path: &Path) {
        let path = absolute(path);
        self.0.retain(|known| *known != path);
        self.0.insert(0, path);
        self.0.truncate(KEPT);
    }

    /// Drops what could not be opened.
    pub(in crate::app) fn forget(&mut self, path: &Path) {
        let path = absolute(path);
        self.0.retain(|known| *known != path);
    }

    pub(in crate::app) fn paths(&self) -> &[PathBuf] {
        &self.0
    }
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}
