//! Why something could not be exported.

use std::{io, path::PathBuf};

use crate::geometry::Size;

/// Why something could not be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
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
    /// `ffmpeg` or `ffprobe` cannot be started.
    #[error("cannot start {program}: {source}; install FFmpeg (apt-get install ffmpeg)")]
    Program {
        /// The program.
        program: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// The encoder failed.
    #[error("{path}: the video encoder failed after {frames} frames: {reason}")]
    Encoder {
        /// The video.
        path: PathBuf,
        /// Frames until then.
        frames: usize,
        /// What it says.
        reason: String,
    },
    /// The video does not hold what was pushed.
    #[error("{path}: holds {found}, expected {expected}")]
    WrongVideo {
        /// The video.
        path: PathBuf,
        /// What was pushed.
        expected: String,
        /// What `ffprobe` counts.
        found: String,
    },
    /// A picture of another size.
    #[error("{path}: a {found} picture came where {expected} was expected")]
    WrongSize {
        /// The video or picture.
        path: PathBuf,
        /// The size it was opened with.
        expected: Size,
        /// What came.
        found: Size,
    },
    /// Parts of the record have different lengths.
    #[error("record: {name} has {found} rows, expected {expected}")]
    WrongLength {
        /// The part.
        name: &'static str,
        /// Rows of the clip.
        expected: usize,
        /// Rows of the part.
        found: usize,
    },
    /// A value that no reader could use.
    #[error("record: {name} is not finite in row {row}")]
    NotFinite {
        /// The part.
        name: &'static str,
        /// The row.
        row: usize,
    },
    /// A clip id that is no plain file name.
    #[error("clip id {0:?}: expected 1 to 100 letters, digits, '.', '_' or '-', not starting with '.'")]
    BadId(String),
}

impl ExportError {
    /// The exit code that names this failure: 65 for a bad id, 74 for I/O, 1 for the rest.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::BadId(_) => 65,
            Self::Io { .. } | Self::Program { .. } | Self::Encoder { .. } | Self::WrongVideo { .. } => 74,
            Self::WrongSize { .. } | Self::WrongLength { .. } | Self::NotFinite { .. } => 1,
        }
    }

    pub(super) fn io(path: &std::path::Path, doing: &'static str, source: io::Error) -> Self {
        Self::Io { path: path.to_owned(), doing, source }
    }
}
