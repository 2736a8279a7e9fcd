//! How one clip ended, as `done.json` or `failed.json` in its output folder says.

use std::{fs, io, path::Path};

use serde::{Deserialize, Serialize};

use crate::{pipeline::ExitCode, session::write_durably};

/// The content of `done.json` and `failed.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClipOutcome {
    /// The clip's id.
    pub id: String,
    /// How it ended.
    pub exit: ExitCode,
    /// The stage it failed in.
    pub stage: Option<String>,
    /// One line that says what and where.
    pub message: Option<String>,
    /// Hash of everything that went in; a clip with the same hash is not done again.
    pub inputs: String,
    /// The program's version.
    pub version: String,
    /// Rows of the record.
    pub frames: Option<usize>,
    /// Flags of the clip, for example `truncated` or `needs_review`.
    pub flags: Vec<String>,
}

/// What a clip's output folder says.
#[derive(Clone, Debug, PartialEq)]
pub enum ClipState {
    /// Nothing final yet.
    Pending,
    /// Whole.
    Done(ClipOutcome),
    /// Failed.
    Failed(ClipOutcome),
}

/// Reads the outcome of the clip in `folder`.
///
/// # Errors
/// When a file exists but cannot be read. A damaged outcome counts as pending: the clip is done again.
pub fn read_outcome(folder: &Path) -> io::Result<ClipState> {
    let read = |name: &str| match fs::read(folder.join(name)) {
        Ok(bytes) => Ok(serde_json::from_slice::<ClipOutcome>(&bytes).ok()),
        Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            Ok(None)
        }
        Err(error) => Err(error),
    };
    if let Some(outcome) = read("done.json")? {
        return Ok(ClipState::Done(outcome));
    }
    Ok(read("failed.json")?.map_or(ClipState::Pending, ClipState::Failed))
}

/// Writes `failed.json` into `folder`, creating it.
///
/// # Errors
/// When it cannot be written.
pub fn write_failure(folder: &Path, outcome: &ClipOutcome) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    // A result of other inputs must not stand beside the failure of these.
    match fs::remove_file(folder.join("done.json")) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let text = serde_json::to_vec_pretty(outcome).map_err(io::Error::other)?;
    write_durably(&folder.join("failed.json"), &text)
}
