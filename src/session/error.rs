//! What can go wrong with a session.

use std::path::PathBuf;

use super::{ApplyError, LockHolder, MaskId};

/// Why a session could not be opened, read or changed.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The file system failed.
    #[error("cannot {action} {path}: {source}")]
    Io {
        /// What was tried.
        action: &'static str,
        /// On what.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Not a session.
    #[error("{path} is not a session: {reason}")]
    NotASession {
        /// The folder.
        path: PathBuf,
        /// What is missing.
        reason: String,
    },
    /// Written by a newer program.
    #[error(
        "{path} has format version {found}, this program reads up to {supported}: open it with a newer agenticfocus"
    )]
    NewerVersion {
        /// The folder.
        path: PathBuf,
        /// Its version.
        found: u64,
        /// Ours.
        supported: u32,
    },
    /// A command of another version.
    #[error(
        "journal line {line} holds a command this program does not know ({reason}): open it with a newer agenticfocus"
    )]
    UnknownCommand {
        /// Counted from 1.
        line: u64,
        /// What the parser said.
        reason: String,
    },
    /// Damage before the last line.
    #[error("journal line {line} is damaged ({reason}); the lines before it are whole")]
    Damaged {
        /// Counted from 1.
        line: u64,
        /// What was found.
        reason: String,
    },
    /// Lines that were acknowledged are gone.
    #[error(
        "the journal ends at {found}, but the snapshot has seen {expected}: restore journal.jsonl from a backup"
    )]
    JournalShort {
        /// Lines the snapshot knew.
        expected: u64,
        /// Lines there are.
        found: u64,
    },
    /// Somebody else has it.
    #[error("the session is open in {0}: close it there, or open it read-only")]
    Locked(LockHolder),
    /// Opened for reading.
    #[error("the session is open read-only")]
    ReadOnly,
    /// A mask is missing or damaged.
    #[error("mask {id}: {reason}")]
    Mask {
        /// Which.
        id: MaskId,
        /// What was found.
        reason: String,
    },
    /// A value could not be written as JSON.
    #[error("cannot encode: {0}")]
    Encode(serde_json::Error),
    /// A command was refused.
    #[error(transparent)]
    Refused(#[from] ApplyError),
}
