//! One clip to be done: where it comes from and what was said about it.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::manifest::{
    Manifest, ManifestClip, ManifestError, ManifestObject, hole_dilation, retarget_settings,
};
use crate::{
    retarget::Method,
    select::vlm::VlmWish,
    session::{ClipReference, Document},
};

/// An object as a manifest points at it: pixels as decoded, a frame of the source's own rate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RawObjectPrompt {
    /// What it is called.
    pub label: String,
    /// Source frame.
    pub source_frame: u32,
    /// `[x0, y0, x1, y1]`, where given.
    pub bounds: Option<[f64; 4]>,
    /// Points on the object.
    pub points: Vec<[f64; 2]>,
    /// Points beside it.
    pub negative: Vec<[f64; 2]>,
}

/// One clip or session of a batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClipJob {
    /// The clip's id: the name of its output folder.
    pub id: String,
    /// A session to obey instead of creating one.
    pub session: Option<PathBuf>,
    /// What a new session starts from.
    pub document: Document,
    /// The manifest's object.
    pub object: Option<RawObjectPrompt>,
    /// What the manifest says about asking a model for the object.
    #[serde(default)]
    pub vlm: VlmWish,
    /// A retargeting method for this run, whatever the session says; the session stays as it is.
    #[serde(default)]
    pub method: Option<Method>,
}

impl ClipJob {
    /// `document` as this run takes it.
    pub fn taken(&self, document: &Document) -> Document {
        let mut taken = document.clone();
        if self.method.is_some() {
            taken.retarget.method = self.method;
        }
        taken
    }
}

/// Why inputs were refused before any work began.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// A manifest.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// A folder.
    #[error("cannot list {path}: {source}")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Nothing to do.
    #[error("{0}: no clips, sessions or manifest found in it")]
    Empty(PathBuf),
    /// Two clips would write to one folder.
    #[error("two inputs have the id {0:?}: give them different ids in a manifest")]
    DuplicateId(String),
    /// An id that is not a plain file name.
    #[error("id {0:?}: expected 1 to 100 letters, digits, '.', '_' or '-', not starting with '.'")]
    BadId(String),
}

const VIDEO_EXTENSIONS: [&str; 12] =
    ["mp4", "mov", "mkv", "avi", "webm", "m4v", "mpg", "mpeg", "wmv", "flv", "ts", "3gp"];

/// Expands what the user named: clips, sessions (`.afs`), folders, manifests (`.toml`, `.jsonl`).
///
/// # Errors
/// When a manifest or folder cannot be read, or ids clash. A clip that is missing or unreadable is
/// not an error here: it fails alone.
pub fn jobs_from_inputs(inputs: &[PathBuf]) -> Result<Vec<ClipJob>, JobError> {
    let mut jobs = Vec::new();
    for input in inputs {
        expand(input, &mut jobs)?;
    }
    let mut seen = BTreeSet::new();
    for job in &jobs {
        check_id(&job.id)?;
        if !seen.insert(job.id.as_str()) {
            return Err(JobError::DuplicateId(job.id.clone()));
        }
    }
    Ok(jobs)
}

fn expand(input: &Path, jobs: &mut Vec<ClipJob>) -> Result<(), JobError> {
    let extension = input.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if extension == "afs" {
        jobs.push(session_job(input));
    } else if extension == "toml" || extension == "jsonl" {
        let folder = input.parent().unwrap_or(Path::new("."));
        for clip in Manifest::read(input)?.clip {
            jobs.push(manifest_job(input, folder, &clip)?);
        }
    } else if input.is_dir() {
        let before = jobs.len();
        for entry in sorted_entries(input)? {
            let extension = entry.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
            if extension == "afs" {
                jobs.push(session_job(&entry));
            } else if VIDEO_EXTENSIONS.contains(&extension.as_str()) {
                jobs.push(clip_job(&entry));
            }
        }
        if jobs.len() == before {
            return Err(JobError::Empty(input.to_owned()));
        }
    } else {
        jobs.push(clip_job(input));
    }
    Ok(())
}

fn sorted_entries(folder: &Path) -> Result<Vec<PathBuf>, JobError> {
    let error = |source| JobError::Folder { path: folder.to_owned(), source };
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(error)? {
        entries.push(entry.map_err(error)?.path());
    }
    entries.sort();
    Ok(entries)
}

fn absolute(path: &Path) -> String {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    absolute.to_string_lossy().into_owned()
}

/// The file's stem with everything that is not a plain file name's letter replaced.
fn id_from(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let id: String = stem.chars().map(plain).take(100).collect();
    let id = id.trim_start_matches('.').to_owned();
    if id.is_empty() { "clip".to_owned() } else { id }
}

fn check_id(id: &str) -> Result<(), JobError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    let fine = !id.is_empty() && id.len() <= 100 && !id.starts_with('.') && id.chars().all(plain);
    if fine { Ok(()) } else { Err(JobError::BadId(id.to_owned())) }
}

fn session_job(path: &Path) -> ClipJob {
    let document = Document::default();
    ClipJob {
        id: id_from(path),
        session: Some(path.to_owned()),
        document,
        object: None,
        vlm: VlmWish::default(),
        method: None,
    }
}

fn clip_job(path: &Path) -> ClipJob {
    let id = id_from(path);
    let clip = ClipReference { id: id.clone(), path: absolute(path), ..ClipReference::default() };
    let document = Document { clip, ..Document::default() };
    ClipJob { id, session: None, document, object: None, vlm: VlmWish::default(), method: None }
}

fn manifest_job(manifest: &Path, folder: &Path, clip: &ManifestClip) -> Result<ClipJob, JobError> {
    let id = clip.id.clone().unwrap_or_else(|| id_from(&clip.path));
    let refuse =
        |message: String| ManifestError::Value { path: manifest.to_owned(), clip: id.clone(), message };
    let mut document = Document {
        clip: ClipReference {
            id: id.clone(),
            path: absolute(&folder.join(&clip.path)),
            content_hash: String::new(),
            rotate: clip.rotate,
            start: clip.start,
            end: clip.end,
        },
        task: clip.task.clone(),
        ..Document::default()
    };
    check_times(clip).map_err(refuse)?;
    if let Some(camera) = &clip.camera {
        let camera = camera.setting().map_err(refuse)?;
        let command = crate::session::Command::SetCamera(camera);
        document.apply(command).map_err(|error| refuse(error.to_string()))?;
    }
    let dilation = crate::session::Command::SetHoleDilation(hole_dilation(clip));
    document.apply(dilation).map_err(|error| refuse(error.to_string()))?;
    let settings = crate::session::Command::SetRetarget(retarget_settings(clip));
    document.apply(settings).map_err(|error| refuse(error.to_string()))?;
    if let Some(track) = clip.hands.as_ref().and_then(|hands| hands.track.as_ref()) {
        document.hand_track = Some(absolute(&folder.join(track)));
    }
    let object = clip.object.as_ref().map(raw_prompt).transpose().map_err(refuse)?;
    let vlm = clip.vlm.clone().unwrap_or_default();
    Ok(ClipJob { id: id.clone(), session: None, document, object, vlm, method: None })
}

fn check_times(clip: &ManifestClip) -> Result<(), String> {
    let (start, end) = (clip.start.unwrap_or(0.0), clip.end.unwrap_or(f64::MAX));
    let fine = start.is_finite() && start >= 0.0 && end.is_finite() && end > start;
    if fine {
        Ok(())
    } else {
        Err(format!("start = {start}, end = {end}: expected 0 ≤ start < end seconds"))
    }
}

fn raw_prompt(object: &ManifestObject) -> Result<RawObjectPrompt, String> {
    if object.bounds.is_none() && object.points.is_empty() {
        return Err("object: expected a box or at least one point".to_owned());
    }
    let numbers = object.bounds.iter().flatten().chain(object.points.iter().flatten());
    if !numbers.chain(object.negative.iter().flatten()).all(|number| number.is_finite()) {
        return Err("object: expected finite pixel coordinates".to_owned());
    }
    Ok(RawObjectPrompt {
        label: object.label.clone().unwrap_or_else(|| "object".to_owned()),
        source_frame: object.frame,
        bounds: object.bounds,
        points: object.points.clone(),
        negative: object.negative.clone(),
    })
}
