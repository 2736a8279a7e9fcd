//! What is in a dataset: a note an episode, written last, from which everything that spans episodes is made.

use std::{
    collections::BTreeMap,
    fs::{self, File, TryLockError},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{DatasetError, DatasetFormat, FeatureStats, Histogram, ThumbOrder, clip::FinishedClip, file};
use crate::geometry::Size;

/// The folder of the notes inside a dataset.
const FOLDER: &str = ".agenticfocus";
/// Version of the notes' layout.
const VERSION: u32 = 1;

/// What all episodes of a dataset share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Head {
    pub version: u32,
    pub format: DatasetFormat,
    pub thumb_order: ThumbOrder,
}

/// One episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct EpisodeNote {
    pub id: String,
    /// Names everything that went into the clip.
    pub key: String,
    pub frames: usize,
    pub task: String,
    /// Of the video as it stands in the dataset.
    pub size: Size,
    pub notes: Vec<String>,
    /// Where it comes from, as the record says.
    pub provenance: Provenance,
    /// Of vector features.
    #[serde(default)]
    pub stats: BTreeMap<String, FeatureStats>,
    /// Of the video's three channels, and of how many pictures.
    #[serde(default)]
    pub pictures: Option<(Vec<Histogram>, u64)>,
}

/// Where an episode comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Provenance {
    pub source_file: String,
    pub source_hash: String,
    pub backends: BTreeMap<String, String>,
    pub versions: BTreeMap<String, String>,
    pub parameters: BTreeMap<String, serde_json::Value>,
}

impl Provenance {
    pub fn of(clip: &FinishedClip) -> Self {
        let (source, meta) = (&clip.description.clip, &clip.description.meta);
        Self {
            source_file: source.file.clone(),
            source_hash: source.hash.clone(),
            backends: meta.backends.clone(),
            versions: meta.versions.clone(),
            parameters: meta.parameters.clone(),
        }
    }
}

/// A dataset's notes, held for writing.
#[derive(Debug)]
pub(super) struct Ledger {
    folder: PathBuf,
    pub head: Head,
    pub episodes: Vec<EpisodeNote>,
    /// Held as long as this lives.
    _lock: File,
}

impl Ledger {
    /// Opens the notes of the dataset `out`, or begins them in a new or empty folder.
    pub fn open(out: &Path, format: DatasetFormat, thumb_order: ThumbOrder) -> Result<Self, DatasetError> {
        let folder = out.join(FOLDER);
        let is_new = !folder.is_dir();
        if is_new && out.is_dir() {
            let mut entries = fs::read_dir(out).map_err(DatasetError::io(out, "list the folder"))?;
            if entries.next().is_some() {
                return Err(DatasetError::Foreign { out: out.to_owned() });
            }
        }
        fs::create_dir_all(&folder).map_err(DatasetError::io(&folder, "create the folder"))?;
        let lock = locked(&folder, out)?;
        let asked = Head { version: VERSION, format, thumb_order };
        let path = folder.join("dataset.json");
        if !path.is_file() {
            file::write_json(&path, &asked)?;
        }
        let head: Head = read(&path)?;
        let other = |what, found: String, asked: String| DatasetError::Other {
            out: out.to_owned(),
            what,
            found,
            asked,
        };
        if head.version != VERSION {
            return Err(other("notes of version", head.version.to_string(), VERSION.to_string()));
        }
        if head.format != format {
            return Err(other("format", format!("{:?}", head.format), format!("{format:?}")));
        }
        if head.thumb_order != thumb_order {
            let (found, asked) = (head.thumb_order.name(), thumb_order.name());
            return Err(other("thumb order", found.to_owned(), asked.to_owned()));
        }
        let mut ledger = Self { folder, head, episodes: Vec::new(), _lock: lock };
        while ledger.note(ledger.episodes.len()).is_file() {
            let path = ledger.note(ledger.episodes.len());
            let episode: EpisodeNote = read(&path)?;
            let sound = |histograms: &[Histogram]| {
                histograms.len() == 3 && histograms.iter().all(Histogram::is_sound)
            };
            if episode.pictures.as_ref().is_some_and(|(histograms, _)| !sound(histograms)) {
                let what = "its histograms have not 3 times 256 levels".to_owned();
                return Err(DatasetError::Damaged { path, what });
            }
            ledger.episodes.push(episode);
        }
        Ok(ledger)
    }

    fn note(&self, episode: usize) -> PathBuf {
        self.folder.join(format!("episode_{episode:06}.json"))
    }

    /// The episode made of this clip, if there is one.
    ///
    /// # Errors
    /// When it was made from an older run of the clip.
    pub fn episode_of(&self, clip: &FinishedClip) -> Result<Option<usize>, DatasetError> {
        let Some(episode) = self.episodes.iter().position(|note| note.id == clip.id) else { return Ok(None) };
        if self.episodes[episode].key == clip.key {
            return Ok(Some(episode));
        }
        Err(DatasetError::Changed { folder: clip.folder.clone(), id: clip.id.clone(), episode })
    }

    /// Notes that the next episode is whole.
    pub fn add(&mut self, note: EpisodeNote) -> Result<(), DatasetError> {
        file::write_json(&self.note(self.episodes.len()), &note)?;
        self.episodes.push(note);
        Ok(())
    }

    /// Frames of all episodes.
    pub fn frames(&self) -> usize {
        self.episodes.iter().map(|episode| episode.frames).sum()
    }

    /// The task sentences in the order in which they appear first.
    pub fn tasks(&self) -> Vec<&str> {
        let mut tasks: Vec<&str> = Vec::new();
        for episode in &self.episodes {
            if !tasks.contains(&episode.task.as_str()) {
                tasks.push(&episode.task);
            }
        }
        tasks
    }
}

/// The place of `task` among [`Ledger::tasks`], which an episode to come may lengthen by one.
pub(super) fn task_index(tasks: &[&str], task: &str) -> usize {
    tasks.iter().position(|other| *other == task).unwrap_or(tasks.len())
}

fn locked(folder: &Path, out: &Path) -> Result<File, DatasetError> {
    let path = folder.join("lock");
    let lock = File::create(&path).map_err(DatasetError::io(&path, "create the file"))?;
    match lock.try_lock() {
        Ok(()) => Ok(lock),
        Err(TryLockError::WouldBlock) => Err(DatasetError::Busy { out: out.to_owned() }),
        Err(TryLockError::Error(error)) => Err(DatasetError::io(&path, "lock the file")(error)),
    }
}

fn read<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T, DatasetError> {
    let bytes = fs::read(path).map_err(DatasetError::io(path, "read the file"))?;
    serde_json::from_slice(&bytes)
        .map_err(|error| DatasetError::Damaged { path: path.to_owned(), what: error.to_string() })
}
