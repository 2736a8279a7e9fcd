//! Undo and redo, without a limit and across restarts: both are journal entries themselves.

use serde::{Deserialize, Serialize};

use super::{ApplyError, Command, Document};

/// What one journal line does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Entry {
    /// The first line: the document as created.
    Create(Box<Document>),
    /// A command.
    Do(Command),
    /// A command of the machine's own: no step of undo, so that a person takes back only what a person did.
    Found(Command),
    /// Takes back the last command that was not taken back.
    Undo,
    /// Does again what was taken back last.
    Redo,
}

/// A document with the commands that take its changes back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    document: Document,
    undo: Vec<Command>,
    redo: Vec<Command>,
}

impl History {
    /// A history that starts at `document`.
    pub fn new(document: Document) -> Self {
        Self { document, undo: Vec::new(), redo: Vec::new() }
    }

    /// The document now.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// Steps that can be taken back.
    pub fn undo_depth(&self) -> usize {
        self.undo.len()
    }

    /// Steps that can be done again.
    pub fn redo_depth(&self) -> usize {
        self.redo.len()
    }

    /// Applies one entry; `Ok(false)` when there was nothing to undo or redo.
    ///
    /// # Errors
    /// When a command is refused; nothing has changed then.
    pub fn apply(&mut self, entry: Entry) -> Result<bool, ApplyError> {
        match entry {
            Entry::Create(document) => *self = Self::new(*document),
            Entry::Do(command) => {
                let inverse = self.document.apply(command)?;
                self.undo.push(inverse);
                self.redo.clear();
            }
            Entry::Found(command) => {
                self.document.apply(command)?;
            }
            Entry::Undo => {
                let Some(inverse) = self.undo.pop() else { return Ok(false) };
                let again = self.document.apply(inverse)?;
                self.redo.push(again);
            }
            Entry::Redo => {
                let Some(again) = self.redo.pop() else { return Ok(false) };
                let inverse = self.document.apply(again)?;
                self.undo.push(inverse);
            }
        }
        Ok(true)
    }
}
