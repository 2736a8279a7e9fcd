//! Stage graph, cache, progress, cancellation; the batch over many clips.

pub mod batch;
mod exit;
mod installation;
mod job;
mod manifest;

pub use exit::ExitCode;
pub use installation::{Installation, PartReport, StageBackend};
pub use job::{ClipJob, JobError, RawObjectPrompt, jobs_from_inputs};
pub use manifest::{
    Manifest, ManifestCamera, ManifestClip, ManifestError, ManifestHands, ManifestObject, ManifestParams,
};
