//! Stage graph, cache, progress, cancellation; the batch over many clips.

pub mod batch;
mod bench;
mod cache;
mod exit;
mod failure;
mod installation;
mod job;
mod manifest;
mod reporter;
mod run;
mod stage;

pub use bench::{BenchOptions, episode_job, run_bench};
pub use cache::{Cache, Key};
pub use exit::ExitCode;
pub use failure::ClipFailure;
pub use installation::{Installation, PartReport, StageBackend};
pub use job::{ClipJob, JobError, RawObjectPrompt, jobs_from_inputs};
pub use manifest::{
    Manifest, ManifestCamera, ManifestClip, ManifestError, ManifestHands, ManifestObject, ManifestParams,
};
pub use reporter::Listener;
pub use run::{Background, ClipRun, Understood, run_clip, shown_arms, understand_clip};
pub use stage::Stage;
