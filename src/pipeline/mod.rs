//! Stage graph, cache, progress, cancellation; the batch over many clips.

pub mod batch;
mod bench;
mod cache;
mod decisions;
mod exit;
mod failure;
mod installation;
mod job;
mod learned;
mod manifest;
mod mask_import;
mod memory;
mod reporter;
mod run;
mod stage;

pub use bench::{BenchOptions, episode_job, run_bench};
pub use cache::{Cache, Key};
pub use decisions::Decisions;
pub use exit::ExitCode;
pub use failure::ClipFailure;
pub use installation::{Installation, PartReport, StageBackend};
pub use job::{ClipJob, JobError, RawObjectPrompt, jobs_from_inputs};
pub use learned::{Findings, ModelOptions, ModelReport};
pub use manifest::{
    Manifest, ManifestCamera, ManifestClip, ManifestError, ManifestHands, ManifestObject, ManifestParams,
};
pub use mask_import::{FrameNumbering, LayerLabels, MaskImportReport, import_masks};
pub use memory::Memory;
pub use reporter::Listener;
pub use run::{
    Background, ClipRun, RunOptions, Understood, run_clip, shown_arms, understand_clip, understand_document,
};
pub(crate) use run::{
    Evidence, FramePixels, LayerPlan, compose_frame, layer_evidence, layers_of, open_session, plan_layers,
    render_robot, robot_renderer,
};
pub use stage::Stage;
