//! Why a model gave no answer.

use std::time::Duration;

use crate::{
    clip::{FrameError, FrameIndex},
    progress::Cancelled,
};

/// Why a model gave no answer. Never holds the key, nor more of what a server wrote than a line.
#[derive(Debug, thiserror::Error)]
pub enum VlmError {
    /// The work is no longer wanted.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A frame could not be read.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A frame could not be compressed.
    #[error("{frame} could not be compressed for the model: {source}")]
    Picture {
        /// Which.
        frame: FrameIndex,
        /// OpenCV's reason.
        source: opencv::Error,
    },
    /// The question could not be written.
    #[error("the question could not be written: {0}")]
    Encode(#[from] serde_json::Error),
    /// The key cannot be sent.
    #[error("AGENTICFOCUS_VLM_KEY holds characters that no header can carry: set it to the key alone")]
    Key,
    /// No thread to wait on.
    #[error("no thread to ask the model with: {0}")]
    Thread(std::io::Error),
    /// No connection.
    #[error("{host} cannot be reached ({reason}): is the server running?")]
    Connect {
        /// The server.
        host: String,
        /// What the system said.
        reason: String,
    },
    /// No answer in time.
    #[error("{host} gave no answer within {} s: raise --vlm-timeout, or take a smaller model", limit.as_secs_f64())]
    Timeout {
        /// The server.
        host: String,
        /// The limit.
        limit: Duration,
    },
    /// It wants to be asked later than anybody waits.
    #[error("{host} is busy ({status}) and wants to be asked again in {} s: run it again later", wait.as_secs())]
    Busy {
        /// The server.
        host: String,
        /// What it answered.
        status: u16,
        /// How long it wants to be left alone.
        wait: Duration,
    },
    /// It refused.
    #[error("{host} refused the question ({status}{}): {said}", hint(*status))]
    Refused {
        /// The server.
        host: String,
        /// The HTTP status.
        status: u16,
        /// What it said, one line.
        said: String,
    },
    /// It answers with more than an answer.
    #[error("{host} sent more than {} MiB: that is no answer", limit >> 20)]
    TooLarge {
        /// The server.
        host: String,
        /// The limit, bytes.
        limit: u64,
    },
    /// It speaks another protocol.
    #[error("{host} does not speak the chat protocol ({reason}): does the address end in /v1?")]
    Protocol {
        /// The server.
        host: String,
        /// What was missing.
        reason: String,
    },
}

const fn hint(status: u16) -> &'static str {
    match status {
        401 | 403 => ", set AGENTICFOCUS_VLM_KEY",
        404 => ", is the model loaded there, and does the address end in /v1?",
        300..=399 => ", it moved: give the address it moved to",
        413 => ", the pictures are too large for it",
        _ => "",
    }
}
