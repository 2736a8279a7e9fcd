//! `agenticfocus --batch INPUT... --out DIR`.

use std::{
    path::PathBuf,
    sync::{Arc, atomic::AtomicBool},
};

use super::{Failure, Outcome, args::BatchArguments, progress::BatchProgress};
use crate::pipeline::{
    ClipJob, ExitCode,
    batch::{BatchOptions, BatchSummary, run_batch},
    jobs_from_inputs,
};

pub(super) fn run(arguments: &BatchArguments) -> Outcome {
    let out = arguments
        .out
        .clone()
        .ok_or_else(|| Failure::new(ExitCode::Usage, "--batch needs --out DIR; see --help"))?;
    let jobs = jobs_from_inputs(&arguments.batch).map_err(|error| Failure::new(ExitCode::Usage, error))?;
    let shard = arguments.shard.unwrap_or_default();
    let mut jobs: Vec<ClipJob> = jobs.into_iter().filter(|job| shard.contains(&job.id)).collect();
    for job in &mut jobs {
        job.method = arguments.method;
    }
    let settings = arguments.vlm.installation().vlm;
    for job in &jobs {
        settings.plan(&job.vlm).map_err(|error| Failure::new(ExitCode::Usage, error))?;
    }
    let at_a_time = usize::from(arguments.jobs);
    let mut worker = worker_arguments(at_a_time.min(jobs.len()));
    worker.extend(arguments.layers.then(|| "--layers".to_owned()));
    worker.extend(arguments.vlm.words());
    worker.extend(arguments.models.words());
    let summary = run_jobs(&jobs, out, worker, at_a_time)?;
    if arguments.json {
        let text = serde_json::to_string_pretty(&summary)
            .map_err(|error| Failure::new(ExitCode::Internal, error))?;
        println!("{text}");
    } else {
        let done = summary.clips.iter().filter(|clip| clip.exit == ExitCode::Done).count();
        eprintln!("{done} of {} clips done in {:.0} s", summary.clips.len(), summary.seconds);
    }
    Ok(summary.exit)
}

/// Runs `jobs` in worker processes of this very program, with progress on standard error.
pub(super) fn run_jobs(
    jobs: &[ClipJob],
    out: PathBuf,
    worker_arguments: Vec<String>,
    at_a_time: usize,
) -> Result<BatchSummary, Failure> {
    let cancel = cancel_on_signals()?;
    let worker = std::env::current_exe()?;
    let options = BatchOptions { out, jobs: at_a_time, worker, worker_arguments };
    let progress = BatchProgress::new();
    Ok(run_batch(jobs, &options, &cancel, &|event| progress.hear(&event))?)
}

/// A flag that Ctrl-C and a polite kill raise; a second Ctrl-C ends the program at once.
pub(super) fn cancel_on_signals() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        let status = i32::from(ExitCode::Cancelled.status());
        signal_hook::flag::register_conditional_shutdown(signal, status, Arc::clone(&flag))?;
        signal_hook::flag::register(signal, Arc::clone(&flag))?;
    }
    Ok(flag)
}

/// Arguments of a worker of which `at_a_time` share this machine.
pub(super) fn worker_arguments(at_a_time: usize) -> Vec<String> {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let threads = (cores / at_a_time.max(1)).max(1).to_string();
    ["clip-worker", "--threads", &threads].map(str::to_owned).to_vec()
}
