//! Why a clip failed: the stage, the class, one line.

use std::{error::Error, fmt, io};

use super::{ExitCode, Stage};
use crate::{
    clip::{ClipError, FrameError},
    progress::Cancelled,
    session::SessionError,
};

/// Why a clip failed.
#[derive(Debug)]
pub struct ClipFailure {
    /// Where.
    pub stage: Option<Stage>,
    /// What kind.
    pub exit: ExitCode,
    /// One line that says what and where.
    pub message: String,
}

impl ClipFailure {
    /// Bad input with a message of our own.
    pub fn bad_input(message: impl fmt::Display) -> Self {
        Self { stage: None, exit: ExitCode::BadInput, message: message.to_string() }
    }

    /// The class of `error`: what its chain of causes says, `otherwise` where it says nothing.
    pub fn from_error(error: &(dyn Error + 'static), otherwise: ExitCode) -> Self {
        let mut message = error.to_string();
        let mut exit = None;
        let mut next = Some(error);
        while let Some(cause) = next {
            exit = exit.or_else(|| class_of(cause));
            let text = cause.to_string();
            if !message.contains(&text) {
                message = format!("{message}: {text}");
            }
            next = cause.source();
        }
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        Self { stage: None, exit: exit.unwrap_or(otherwise), message }
    }

    /// The same failure, said to be of `stage`.
    #[must_use]
    pub fn in_stage(mut self, stage: Stage) -> Self {
        self.stage.get_or_insert(stage);
        self
    }
}

fn class_of(error: &(dyn Error + 'static)) -> Option<ExitCode> {
    if error.is::<Cancelled>() || error.to_string() == Cancelled.to_string() {
        return Some(ExitCode::Cancelled);
    }
    if let Some(error) = error.downcast_ref::<ClipError>() {
        return Some(ExitCode::from_status(i32::from(error.exit_code())));
    }
    if error.is::<FrameError>() {
        return Some(ExitCode::InputOutput);
    }
    if let Some(error) = error.downcast_ref::<SessionError>() {
        return match error {
            SessionError::Io { source, .. } => Some(ExitCode::from(source)),
            SessionError::Locked(_) => Some(ExitCode::Temporary),
            _ => Some(ExitCode::BadInput),
        };
    }
    error.downcast_ref::<io::Error>().map(ExitCode::from)
}

impl From<io::Error> for ClipFailure {
    fn from(error: io::Error) -> Self {
        Self::from_error(&error, ExitCode::InputOutput)
    }
}

impl From<SessionError> for ClipFailure {
    fn from(error: SessionError) -> Self {
        Self::from_error(&error, ExitCode::InputOutput)
    }
}

impl From<ClipError> for ClipFailure {
    fn from(error: ClipError) -> Self {
        Self::from_error(&error, ExitCode::BadInput)
    }
}
