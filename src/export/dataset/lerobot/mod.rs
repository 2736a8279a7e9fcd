//! LeRobot datasets: a table and a video an episode, metadata made anew from the notes of all episodes.

mod episode;
mod info;
mod modality;
mod stats;
mod table;
mod v21;
mod v30;

use std::path::{Path, PathBuf};

pub(super) use episode::write_episode;

use super::{
    DatasetError,
    ledger::{EpisodeNote, Ledger},
};

/// Frames a second.
const FPS: u32 = 30;
/// Episodes of a folder.
const CHUNK: usize = 1000;
/// The key of the mixed-reality video: the camera of Unitree's own datasets that looks from the robot's head.
const VIDEO: &str = "observation.images.cam_left_high";
/// GR00T's name of the task column.
const ANNOTATION: &str = "annotation.human.task_description";

/// Which codebase version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Version {
    V21,
    V30,
}

impl Version {
    /// The table of an episode, relative to the dataset.
    fn table(self, episode: usize) -> PathBuf {
        let (chunk, file) = (episode / CHUNK, episode % CHUNK);
        match self {
            Self::V21 => format!("data/chunk-{chunk:03}/episode_{episode:06}.parquet").into(),
            Self::V30 => format!("data/chunk-{chunk:03}/file-{file:03}.parquet").into(),
        }
    }

    /// The video of an episode, relative to the dataset.
    fn video(self, episode: usize) -> PathBuf {
        let (chunk, file) = (episode / CHUNK, episode % CHUNK);
        match self {
            Self::V21 => format!("videos/chunk-{chunk:03}/{VIDEO}/episode_{episode:06}.mp4").into(),
            Self::V30 => format!("videos/{VIDEO}/chunk-{chunk:03}/file-{file:03}.mp4").into(),
        }
    }
}

/// Writes everything that spans episodes.
pub(super) fn write_metadata(out: &Path, ledger: &Ledger, version: Version) -> Result<(), DatasetError> {
    if ledger.episodes.is_empty() {
        return Ok(());
    }
    match version {
        Version::V21 => v21::write(out, ledger),
        Version::V30 => v30::write(out, ledger),
    }
}

/// Where an episode stands in the whole.
struct Placed<'a> {
    episode: usize,
    note: &'a EpisodeNote,
    task: usize,
    /// Index of its first frame.
    from: usize,
}

impl<'a> Placed<'a> {
    fn all(ledger: &'a Ledger) -> Vec<Self> {
        let tasks = ledger.tasks();
        let mut from = 0;
        let episodes = ledger.episodes.iter().enumerate();
        episodes
            .map(|(episode, note)| {
                let placed =
                    Self { episode, note, task: super::ledger::task_index(&tasks, &note.task), from };
                from += note.frames;
                placed
            })
            .collect()
    }
}
