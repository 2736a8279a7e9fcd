//! A finished clip's folder as an episode's source.

use std::{
    fs,
    path::{Path, PathBuf},
};

use npyz::npz::NpzArchive;
use serde::Deserialize;

use super::DatasetError;
use crate::{
    export::RecordDescription,
    robot::ACTUATED_DOF,
    session::{ReviewState, Session},
};

/// A clip that ran to its end.
#[derive(Debug)]
pub(super) struct FinishedClip {
    pub folder: PathBuf,
    pub id: String,
    /// Names everything that went into it.
    pub key: String,
    pub description: RecordDescription,
    pub rejected: Option<String>,
}

/// State and action of every frame, in the record's order.
#[derive(Debug)]
pub(super) struct Rows {
    pub state: Vec<[f64; ACTUATED_DOF]>,
    pub action: Vec<[f64; ACTUATED_DOF]>,
}

/// A folder of the input.
#[derive(Debug)]
pub(super) enum Found {
    Finished(Box<FinishedClip>),
    /// It is no episode, for this reason.
    Unfinished {
        folder: PathBuf,
        id: String,
        reason: String,
    },
}

/// `done.json` or `failed.json`.
#[derive(Deserialize)]
struct Outcome {
    id: String,
    #[serde(default)]
    inputs: String,
    #[serde(default)]
    message: Option<String>,
}

/// `report.json`, as far as it is needed here.
#[derive(Deserialize)]
struct Report {
    document: ReportDocument,
}

#[derive(Deserialize)]
struct ReportDocument {
    #[serde(default)]
    review: ReviewState,
}

/// The clips below `inputs`, in the order given; within a folder by name. A folder that is named twice counts once.
pub(super) fn find(inputs: &[PathBuf]) -> Result<Vec<Found>, DatasetError> {
    let mut folders: Vec<PathBuf> = Vec::new();
    for input in inputs {
        let before = folders.len();
        let input = fs::canonicalize(input).map_err(DatasetError::io(input, "open the input"))?;
        if is_clip(&input) {
            folders.push(input.clone());
        } else {
            let entries = fs::read_dir(&input).map_err(DatasetError::io(&input, "list the folder"))?;
            let mut below = Vec::new();
            for entry in entries {
                let path = entry.map_err(DatasetError::io(&input, "list the folder"))?.path();
                let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
                if !hidden && is_clip(&path) {
                    below.push(path);
                }
            }
            below.sort();
            folders.extend(below);
        }
        if folders.len() == before {
            return Err(DatasetError::NoClips { input });
        }
    }
    let mut seen = std::collections::BTreeSet::new();
    folders.retain(|folder| seen.insert(folder.clone()));
    folders.iter().map(|folder| read(folder)).collect()
}

fn is_clip(folder: &Path) -> bool {
    folder.join("done.json").is_file() || folder.join("failed.json").is_file()
}

fn read(folder: &Path) -> Result<Found, DatasetError> {
    let done = folder.join("done.json");
    if !done.is_file() {
        let outcome: Outcome = read_json(&folder.join("failed.json"))?;
        let reason = format!("the clip failed: {}", outcome.message.unwrap_or_default());
        return Ok(Found::Unfinished { folder: folder.to_owned(), id: outcome.id, reason });
    }
    let outcome: Outcome = read_json(&done)?;
    let description: RecordDescription = read_json(&folder.join("record.json"))?;
    let rejected = match review(folder)? {
        ReviewState::Rejected { reason, .. } => Some(reason),
        _ => None,
    };
    let clip = FinishedClip {
        folder: folder.to_owned(),
        id: outcome.id,
        key: outcome.inputs,
        description,
        rejected,
    };
    Ok(Found::Finished(Box::new(clip)))
}

/// What a person said about the clip: in the session beside it, else at the time of the run.
fn review(folder: &Path) -> Result<ReviewState, DatasetError> {
    let mut session = folder.as_os_str().to_owned();
    session.push(".afs");
    let session = PathBuf::from(session);
    if session.join("session.json").is_file() {
        let (opened, _) = Session::open_read_only(&session)
            .map_err(|error| DatasetError::clip(&session, error.to_string()))?;
        return Ok(opened.document().review.clone());
    }
    Ok(read_json::<Report>(&folder.join("report.json"))?.document.review)
}

fn read_json<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T, DatasetError> {
    let bytes = fs::read(path).map_err(DatasetError::io(path, "read the file"))?;
    serde_json::from_slice(&bytes).map_err(|error| DatasetError::clip(path, error.to_string()))
}

impl FinishedClip {
    /// Frames, as its description says; [`rows`](Self::rows) checks it.
    pub fn frames(&self) -> usize {
        self.description.rows
    }

    /// What is done in it; its id where nobody said.
    pub fn task(&self) -> &str {
        let task = self.description.meta.task.trim();
        if task.is_empty() { &self.id } else { task }
    }

    /// Its mixed-reality video.
    pub fn video(&self) -> PathBuf {
        self.folder.join("composite.mp4")
    }

    /// Its action/state record.
    pub fn rows(&self) -> Result<Rows, DatasetError> {
        let path = self.folder.join("record.npz");
        let file = fs::File::open(&path).map_err(DatasetError::io(&path, "open the record"))?;
        let mut archive =
            NpzArchive::new(file).map_err(|error| DatasetError::clip(&path, format!("no npz: {error}")))?;
        let mut rows = |name: &str| -> Result<Vec<[f64; ACTUATED_DOF]>, DatasetError> {
            let damaged = |what: String| DatasetError::clip(&path, format!("{name}: {what}"));
            let array = archive.by_name(name).map_err(|error| damaged(error.to_string()))?;
            let array = array.ok_or_else(|| damaged("no such array, expected a record".to_owned()))?;
            let expected = [self.frames() as u64, ACTUATED_DOF as u64];
            if array.shape() != expected {
                return Err(damaged(format!("has shape {:?}, expected {expected:?}", array.shape())));
            }
            let values: Vec<f64> = array.into_vec().map_err(|error| damaged(error.to_string()))?;
            if let Some(bad) = values.iter().position(|value| !value.is_finite()) {
                return Err(damaged(format!("row {} is not finite", bad / ACTUATED_DOF)));
            }
            Ok(values.as_chunks::<ACTUATED_DOF>().0.to_vec())
        };
        Ok(Rows { state: rows("state")?, action: rows("action")? })
    }
}
