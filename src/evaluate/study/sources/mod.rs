//! Where episodes come from.

mod find;
mod record;
mod world_motion;

use std::path::{Path, PathBuf};

use crate::{
    geometry::{Pinhole, Size},
    hands::import::{self, ImportError, ImportParams},
    synth::{EpisodeSpec, SynthError, error_model::ErrorModel, error_model::estimated_track, motion_truth},
};

use super::Episode;

pub use find::find_sources;

/// The episodes of a study, loaded one by one when their turn comes.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    episodes: Vec<Source>,
    notes: Vec<String>,
    error_model: ErrorModel,
}

#[derive(Clone, Debug)]
enum Source {
    /// Motion and errors of a seed.
    Synthetic(EpisodeSpec),
    /// A hand track in a file.
    Track { name: String, path: PathBuf },
    /// A captured hand in world axes.
    World { name: String, path: PathBuf },
    /// A finished clip: its record, and the hand track that its session keeps.
    Record { name: String, record: PathBuf, tracks: Vec<PathBuf> },
}

/// Why an episode cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// A file cannot be read.
    #[error("cannot read {path}: {source}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A hand track cannot be read.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A file holds something else.
    #[error("{path}: {what}")]
    Content {
        /// The file.
        path: PathBuf,
        /// What was found, and what was expected.
        what: String,
    },
    /// A folder holds nothing to evaluate.
    #[error(
        "{0} holds no hand track: expected folders with record.npz, .npz or .json hand tracks (see models/README.md)"
    )]
    Nothing(PathBuf),
    /// A synthetic episode cannot be made.
    #[error(transparent)]
    Synth(#[from] SynthError),
}

impl SourceError {
    /// Whether the input itself is bad, rather than reading it.
    pub const fn is_bad_input(&self) -> bool {
        match self {
            Self::Io { .. } | Self::Import(ImportError::Io { .. }) => false,
            Self::Import(_) | Self::Content { .. } | Self::Nothing(_) | Self::Synth(_) => true,
        }
    }
}

impl Sources {
    /// Adds `count` synthetic episodes, seeds from `seed` on, each of `frames` frames where that is stated.
    pub fn add_synthetic(&mut self, count: u32, seed: u64, frames: Option<u32>) {
        for number in 0..u64::from(count) {
            let mut spec = EpisodeSpec { seed: seed + number, ..EpisodeSpec::default() };
            spec.frames = frames.unwrap_or(spec.frames);
            self.episodes.push(Source::Synthetic(spec));
        }
    }

    /// Number of episodes.
    pub const fn len(&self) -> usize {
        self.episodes.len()
    }

    /// Whether there is none.
    pub const fn is_empty(&self) -> bool {
        self.episodes.is_empty()
    }

    /// What a reader should know about what was found.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Seeds of the synthetic episodes.
    pub fn seeds(&self) -> Vec<u64> {
        let seed = |source: &Source| match source {
            Source::Synthetic(spec) => Some(spec.seed),
            _ => None,
        };
        self.episodes.iter().filter_map(seed).collect()
    }

    /// The errors that lie over synthetic episodes.
    pub const fn error_model(&self) -> &ErrorModel {
        &self.error_model
    }

    /// Episode number `index`.
    ///
    /// # Errors
    /// When it cannot be read or made.
    ///
    /// # Panics
    /// When there are not as many.
    pub fn load(&self, index: usize) -> Result<Episode, SourceError> {
        match &self.episodes[index] {
            Source::Synthetic(spec) => {
                let truth = motion_truth(spec)?;
                let track = estimated_track(&truth, &self.error_model);
                Ok(Episode::with_truth(format!("seed{:04}", spec.seed), track, &truth))
            }
            Source::Track { name, path } => Ok(Episode::of_track(name.clone(), read_track(path)?)),
            Source::World { name, path } => Ok(Episode::of_track(name.clone(), world_motion::read(path)?)),
            Source::Record { name, record, tracks } => record::read(name, record, tracks),
        }
    }
}

/// A hand track by itself, resampled to 30 FPS. Keypoints are seen by a camera that nothing here depends on.
fn read_track(path: &Path) -> Result<crate::hands::HandTrack, SourceError> {
    Ok(import::read_whole(path, &any_camera(), &ImportParams::default())?)
}

/// A camera for tracks that come without one: only the pixels of keypoints depend on it.
fn any_camera() -> Pinhole {
    Pinhole { fx: 600.0, fy: 600.0, cx: 319.5, cy: 239.5, size: Size::new(640, 480) }
}

fn io(path: &Path) -> impl FnOnce(std::io::Error) -> SourceError {
    let path = path.to_owned();
    move |source| SourceError::Io { path, source }
}
