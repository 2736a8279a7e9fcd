//! Why a clip could not be opened.

use std::path::PathBuf;

use crate::{geometry::PinholeError, progress::Cancelled};

/// Why a clip could not be opened; one line that says what and where.
#[derive(Debug, thiserror::Error)]
pub enum ClipError {
    /// The path is not a file that can be read.
    #[error("{path}: cannot read the clip: {reason}")]
    Unreadable {
        /// The clip.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Not a video that FFmpeg decodes.
    #[error("{path}: not a video that can be decoded: {reason}")]
    NotVideo {
        /// The clip.
        path: PathBuf,
        /// What FFmpeg says.
        reason: String,
    },
    /// Only sound, subtitles or a cover picture.
    #[error("{path}: has no video stream (found: {found})")]
    NoVideoStream {
        /// The clip.
        path: PathBuf,
        /// The streams it has.
        found: String,
    },
    /// A video stream without one frame that decodes.
    #[error("{path}: no frame could be decoded{reason}")]
    NoFrames {
        /// The clip.
        path: PathBuf,
        /// What FFmpeg says, after a colon, or nothing.
        reason: String,
    },
    /// Nothing lies between `start` and `end`.
    #[error("{path}: no frame between start = {start} s and end = {end} s; the clip lasts {duration:.3} s")]
    EmptyRange {
        /// The clip.
        path: PathBuf,
        /// Asked for, seconds.
        start: f64,
        /// Asked for, seconds.
        end: f64,
        /// What there is, seconds.
        duration: f64,
    },
    /// More pixels or frames than are accepted.
    #[error("{path}: {what} = {found} is beyond the limit of {limit}")]
    TooLarge {
        /// The clip.
        path: PathBuf,
        /// What is too large.
        what: &'static str,
        /// What was found.
        found: u64,
        /// What is accepted.
        limit: u64,
    },
    /// The camera in the request makes no sense.
    #[error("{path}: camera: {source}")]
    Camera {
        /// The clip.
        path: PathBuf,
        /// What is wrong with it.
        source: PinholeError,
    },
    /// The decoder stood still.
    #[error("{path}: the decoder gave nothing for {seconds} s after {frames} frames; try again")]
    Stalled {
        /// The clip.
        path: PathBuf,
        /// How long it was waited for.
        seconds: u64,
        /// Frames until then.
        frames: u64,
    },
    /// The decoder was killed from outside.
    #[error("{path}: the decoder was killed by signal {signal} after {frames} frames; try again")]
    Killed {
        /// The clip.
        path: PathBuf,
        /// The signal.
        signal: i32,
        /// Frames until then.
        frames: u64,
    },
    /// `ffmpeg` or `ffprobe` cannot be started.
    #[error("cannot start {program}: {source}; install FFmpeg (apt-get install ffmpeg)")]
    Program {
        /// The program.
        program: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Reading the clip or writing the scratch file failed.
    #[error("{path}: {doing}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What was being done.
        doing: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// No longer wanted.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl ClipError {
    /// The exit code that names this failure: 65 bad input, 74 I/O, 75 temporary, 130 cancelled.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Unreadable { .. }
            | Self::NotVideo { .. }
            | Self::NoVideoStream { .. }
            | Self::NoFrames { .. }
            | Self::EmptyRange { .. }
            | Self::TooLarge { .. }
            | Self::Camera { .. } => 65,
            Self::Program { .. } | Self::Io { .. } => 74,
            Self::Stalled { .. } | Self::Killed { .. } => 75,
            Self::Cancelled(_) => 130,
        }
    }
}
