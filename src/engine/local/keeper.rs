//! Changes on their way to the disk: none is lost while it cannot be written.

use std::{collections::VecDeque, path::Path, time::SystemTime};

use crate::{
    engine::{Change, SaveState},
    session::{Session, SessionError},
};

/// The open session with the changes that still wait.
#[derive(Debug)]
pub(super) struct Keeper {
    session: Session,
    waiting: VecDeque<Change>,
    kept: u64,
    failing: Option<(SystemTime, String)>,
}

impl Keeper {
    pub(super) fn new(session: Session) -> Self {
        Self { session, waiting: VecDeque::new(), kept: 0, failing: None }
    }

    pub(super) fn session(&self) -> &Session {
        &self.session
    }

    /// Whether changes wait.
    pub(super) fn is_behind(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// Takes a change and tries to write it, after those that wait.
    pub(super) fn keep(&mut self, change: Change) -> SaveState {
        self.waiting.push_back(change);
        self.flush()
    }

    /// Writes what waits, in order, until something fails.
    pub(super) fn flush(&mut self) -> SaveState {
        while let Some(change) = self.waiting.front() {
            match write(&mut self.session, change) {
                Ok(()) => {
                    self.waiting.pop_front();
                    self.kept += 1;
                    self.failing = None;
                }
                Err(error) => {
                    let since = self.failing.as_ref().map_or_else(SystemTime::now, |(since, _)| *since);
                    self.failing = Some((since, error.to_string()));
                    break;
                }
            }
        }
        self.state()
    }

    pub(super) fn state(&self) -> SaveState {
        match &self.failing {
            None => SaveState::Saved(self.kept),
            Some((since, reason)) => {
                SaveState::NotSaved { saved: self.kept, since: *since, reason: reason.clone() }
            }
        }
    }

    /// Goes on in `folder`, with everything that was written and everything that waits.
    pub(super) fn move_to(&mut self, folder: &Path) -> Result<SaveState, SessionError> {
        self.session = self.session.copy_to(folder)?;
        Ok(self.flush())
    }

    /// Writes the readable snapshot.
    pub(super) fn snapshot(&self) -> Result<(), SessionError> {
        if self.session.is_writable() { self.session.save_snapshot() } else { Ok(()) }
    }
}

fn write(session: &mut Session, change: &Change) -> Result<(), SessionError> {
    // Masks first: a line that names a mask must find it.
    let store = session.masks();
    for (_, mask) in &change.masks {
        store.put(mask)?;
    }
    session.take(change.author.clone(), change.entry.clone()).map(|_| ())
}
