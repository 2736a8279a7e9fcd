//! The state of every clip below an output folder.

use std::{fs, io, path::Path};

use serde::Serialize;

use super::{ClipState, read_outcome};
use crate::pipeline::ExitCode;

/// One clip's state, as `agenticfocus status` prints it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClipStatus {
    /// The clip's id.
    pub id: String,
    /// `None` while nothing final is there.
    pub exit: Option<ExitCode>,
    /// Rows of the record.
    pub frames: Option<usize>,
    /// What went wrong.
    pub message: Option<String>,
    /// Flags of the clip.
    pub flags: Vec<String>,
}

/// Lists the clips of `out` in the order of their ids.
///
/// # Errors
/// When the folder cannot be read.
pub fn folder_status(out: &Path) -> io::Result<Vec<ClipStatus>> {
    let mut rows = Vec::new();
    for entry in fs::read_dir(out)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_session = Path::new(&name).extension().is_some_and(|extension| extension == "afs");
        if name.starts_with('.') || is_session || !entry.file_type()?.is_dir() {
            continue;
        }
        rows.push(match read_outcome(&entry.path())? {
            ClipState::Pending => {
                ClipStatus { id: name, exit: None, frames: None, message: None, flags: Vec::new() }
            }
            ClipState::Done(outcome) | ClipState::Failed(outcome) => ClipStatus {
                id: name,
                exit: Some(outcome.exit),
                frames: outcome.frames,
                message: outcome.message,
                flags: outcome.flags,
            },
        });
    }
    rows.sort_by(|a, b| a.id.cmp(&b.id));
    Ok(rows)
}
