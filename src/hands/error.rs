//! What can go wrong in the hand stage.

use std::path::PathBuf;

use crate::{clip::FrameError, onnx::OnnxError, progress::Cancelled};

/// Why there is no hand track.
#[derive(Debug, thiserror::Error)]
pub enum HandsError {
    /// The estimator could not be started.
    #[error(
        "cannot start the hand estimator {program}: {source}; `agenticfocus doctor` tells what to install"
    )]
    Start {
        /// The program that was to run.
        program: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The estimator ended or closed its output before the clip was done.
    #[error("the hand estimator {program} ended ({status}) while {doing}{stderr}")]
    Ended {
        /// The program.
        program: PathBuf,
        /// How it ended.
        status: String,
        /// What the host was waiting for.
        doing: String,
        /// Its last words, each on a line of its own, or nothing.
        stderr: String,
    },
    /// The estimator took too long.
    #[error("the hand estimator {program} gave no answer within {seconds} s while {doing}{stderr}")]
    TimedOut {
        /// The program.
        program: PathBuf,
        /// The limit that was passed.
        seconds: f64,
        /// What the host was waiting for.
        doing: String,
        /// Its last words.
        stderr: String,
    },
    /// The estimator speaks another protocol or version.
    #[error("the hand estimator {program} speaks {found:?}, expected {expected:?}: see models/README.md")]
    Protocol {
        /// The program.
        program: PathBuf,
        /// What it said.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// The estimator sent something that is no answer.
    #[error("the hand estimator {program} sent a bad answer while {doing}: {reason}")]
    Answer {
        /// The program.
        program: PathBuf,
        /// What the host was waiting for.
        doing: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A parameter is out of bounds.
    #[error("{name} = {value}: expected {expected}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What is accepted.
        expected: &'static str,
    },
    /// The hand network failed.
    #[error("the hand network failed: {0}")]
    Network(#[from] OnnxError),
    /// A frame of the clip could not be read.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// OpenCV refused.
    #[error("OpenCV failed in the hand stage: {0}")]
    Vision(#[from] opencv::Error),
    /// Nobody wants the result any more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl HandsError {
    /// What the network broke down on, where it was the network.
    pub fn of_model(&self) -> Option<&OnnxError> {
        if let Self::Network(error) = self { Some(error) } else { None }
    }
}
