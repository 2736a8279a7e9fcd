//! Where a run's own decisions go: the proposed object, the clip's hash.

use super::ClipFailure;
use crate::session::{Author, Command, Entry, Session};

/// Keeps what the machine decides about a clip while it works on it.
pub trait Decisions {
    /// Keeps `command`, which the run has applied to its own copy of the document or is about to.
    ///
    /// # Errors
    /// When it cannot be kept.
    fn decide(&mut self, author: Author, command: Command) -> Result<(), ClipFailure>;
}

impl Decisions for Session {
    /// In the journal, where this session may be written to.
    fn decide(&mut self, author: Author, command: Command) -> Result<(), ClipFailure> {
        if self.is_writable() {
            self.take(author, Entry::Found(command))?;
        }
        Ok(())
    }
}
