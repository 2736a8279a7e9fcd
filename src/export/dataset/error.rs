//! Why a dataset could not be made.

use std::{io, path::PathBuf};

use crate::{export::ExportError, progress::Cancelled};

/// Why a dataset could not be made.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The file system failed.
    #[error("{path}: cannot {doing}: {source}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was being done.
        doing: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// A finished clip's folder does not hold what a run leaves.
    #[error("{path}: {what}; run the batch on this clip again")]
    Clip {
        /// The file.
        path: PathBuf,
        /// What was found and what was expected.
        what: String,
    },
    /// Nothing to export.
    #[error("{input}: no finished clip there; expected a clip's folder or the output folder of a batch")]
    NoClips {
        /// The input.
        input: PathBuf,
    },
    /// The folder holds another dataset.
    #[error("{out}: holds a dataset with {what} {found}, asked for {asked}; give another folder")]
    Other {
        /// The dataset's folder.
        out: PathBuf,
        /// What differs.
        what: &'static str,
        /// What is there.
        found: String,
        /// What was asked for.
        asked: String,
    },
    /// The folder holds something that is no dataset of this program.
    #[error("{out}: is not empty and was not made by this command; give another folder")]
    Foreign {
        /// The folder.
        out: PathBuf,
    },
    /// The notes of an earlier export are damaged.
    #[error("{path}: {what}; remove the dataset and export it again")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A clip that is in the dataset was made anew since.
    #[error(
        "{folder}: clip {id} is episode {episode} already, made from an older run; export into another folder"
    )]
    Changed {
        /// The clip's folder.
        folder: PathBuf,
        /// Its id.
        id: String,
        /// Its episode.
        episode: usize,
    },
    /// Somebody else writes there.
    #[error("{out}: another export is writing there; wait for it to end")]
    Busy {
        /// The dataset's folder.
        out: PathBuf,
    },
    /// A table could not be written or read.
    #[error("{path}: {source}")]
    Table {
        /// The file.
        path: PathBuf,
        /// Why.
        source: parquet::errors::ParquetError,
    },
    /// A video, picture or record could not be read or written.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// It was cancelled; what is whole stays.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl DatasetError {
    /// The exit code of the command line: bad input, usage, or a failing system.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Io { .. } | Self::Table { .. } => 74,
            Self::Clip { .. } | Self::NoClips { .. } | Self::Damaged { .. } | Self::Changed { .. } => 65,
            Self::Other { .. } | Self::Foreign { .. } => 2,
            Self::Busy { .. } => 75,
            Self::Export(error) => error.exit_code(),
            Self::Cancelled(_) => 130,
        }
    }

    pub(super) fn io(path: &std::path::Path, doing: &'static str) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, doing, source }
    }

    pub(super) fn clip(path: &std::path::Path, what: impl Into<String>) -> Self {
        Self::Clip { path: path.to_owned(), what: what.into() }
    }
}
