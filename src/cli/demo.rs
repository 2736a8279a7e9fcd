//! `agenticfocus demo`: a synthetic episode through the whole pipeline.

use std::path::Path;

use super::{
    Failure, Outcome,
    batch::{cancel_on_signals, run_jobs, worker_arguments},
    progress::SimpleProgress,
};
use crate::{
    pipeline::{ExitCode, episode_job},
    synth::{Episode, EpisodeSpec, generate},
};

pub(super) fn run(out: &Path, seed: u64, frames: Option<u32>) -> Outcome {
    let cancel = cancel_on_signals()?;
    let mut spec = EpisodeSpec { seed, ..EpisodeSpec::default() };
    spec.frames = frames.unwrap_or(spec.frames);
    let folder = out.join("synthetic");
    if !is_there(&folder, &spec) {
        println!("making a synthetic episode (seed {seed}, {} frames) in {}", spec.frames, folder.display());
        let progress = SimpleProgress::new("episode", &cancel);
        generate(&spec, &folder, &progress).map_err(|error| Failure::from_error(&error))?;
    }
    let episode = Episode::load(&folder).map_err(|error| Failure::from_error(&error))?;
    let job = episode_job(&episode, "episode").map_err(|error| Failure::from_error(&error))?;
    println!("running the pipeline on it");
    let summary = run_jobs(&[job], out.to_owned(), worker_arguments(1), 1)?;
    if summary.exit == ExitCode::Done {
        let result = out.join("episode");
        println!("\nthe demonstration is in {}:", result.display());
        println!("  composite.mp4     the robot in the person's place");
        println!("  record.npz        joint angles, commands, wrists, fingertips, 30 rows a second");
        println!("  report.json       quality, frame by frame");
        println!("  debug/            masks, background and layers as videos");
        println!("the session is {}; run it again with:", out.join("episode.afs").display());
        println!("  agenticfocus --batch {} --out DIR", out.join("episode.afs").display());
        println!("{:.0} s in all", summary.seconds);
    }
    Ok(summary.exit)
}

/// Whether the very episode is in `folder` already.
fn is_there(folder: &Path, spec: &EpisodeSpec) -> bool {
    Episode::load(folder).is_ok_and(|episode| episode.truth.spec == *spec)
}
