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
        Ok(self.apply_revertibly(entry)?.is_some())
    }

    /// As [`Self::apply`], with what takes the entry back as if it had never been; `None` when there was
    /// nothing to undo or redo.
    pub(super) fn apply_revertibly(&mut self, entry: Entry) -> Result<Option<Applied>, ApplyError> {
        Ok(Some(match entry {
            Entry::Create(document) => {
                Applied::Create(Box::new(std::mem::replace(self, Self::new(*document))))
            }
            Entry::Do(command) => {
                let inverse = self.document.apply(command)?;
                self.undo.push(inverse);
                Applied::Do { redo: std::mem::take(&mut self.redo) }
            }
            Entry::Found(command) => Applied::Found(self.document.apply(command)?),
            Entry::Undo => {
                if !self.step(Way::Back)? {
                    return Ok(None);
                }
                Applied::Undo
            }
            Entry::Redo => {
                if !self.step(Way::Again)? {
                    return Ok(None);
                }
                Applied::Redo
            }
        }))
    }

    /// Takes back the entry that was applied last and never was.
    pub(super) fn revert(&mut self, applied: Applied) -> Result<(), ApplyError> {
        match applied {
            Applied::Create(before) => *self = *before,
            Applied::Do { redo } => {
                if let Some(inverse) = self.undo.pop() {
                    self.document.apply(inverse)?;
                }
                self.redo = redo;
            }
            Applied::Found(inverse) => {
                self.document.apply(inverse)?;
            }
            Applied::Undo => {
                self.step(Way::Again)?;
            }
            Applied::Redo => {
                self.step(Way::Back)?;
            }
        }
        Ok(())
    }

    fn step(&mut self, way: Way) -> Result<bool, ApplyError> {
        let (from, to) = match way {
            Way::Back => (&mut self.undo, &mut self.redo),
            Way::Again => (&mut self.redo, &mut self.undo),
        };
        let Some(command) = from.pop() else { return Ok(false) };
        to.push(self.document.apply(command)?);
        Ok(true)
    }
}

#[derive(Clone, Copy)]
enum Way {
    Back,
    Again,
}

/// What takes an entry back that could not be written down.
#[derive(Debug)]
pub(super) enum Applied {
    Create(Box<History>),
    Do { redo: Vec<Command> },
    Found(Command),
    Undo,
    Redo,
}
