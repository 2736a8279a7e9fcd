//! The external estimator: one process a clip, JSON lines over its standard input and output.
//!
//! The protocol is documented in `models/README.md`.

mod process;
mod protocol;
mod stderr_tail;

pub use process::EstimatorCommand;
pub(super) use process::{EstimatorProcess, Request};
pub(super) use protocol::Mode;
pub use protocol::PROTOCOL;
