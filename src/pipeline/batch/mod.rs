//! Many clips: one worker process a clip, shards, resume, status.
//!
//! A process a clip keeps a crash in native code (video, OpenGL, inference) from taking other clips along.

mod outcome;
mod schedule;
mod shard;
mod status;

pub use outcome::{ClipOutcome, ClipState, read_outcome, write_failure};
pub use schedule::{BatchEvent, BatchOptions, BatchSummary, WorkerMessage, run_batch};
pub use shard::{Shard, ShardError};
pub use status::{ClipStatus, folder_status};
