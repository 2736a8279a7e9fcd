//! `agenticfocus clip-worker OUT`: one clip in a process of its own, spoken to by the batch.

use std::{
    io::{Read as _, Write as _},
    path::Path,
    sync::Mutex,
};

use super::{Failure, Outcome, batch::cancel_on_signals};
use crate::pipeline::{
    ClipFailure, ClipJob, ExitCode, Installation, Listener, RunOptions, Stage,
    batch::{ClipOutcome, WorkerMessage, write_failure},
    run_clip,
};

pub(super) fn run(out: &Path, threads: usize, options: RunOptions, installation: &Installation) -> Outcome {
    // Without its batch nobody would hear the result: end with it.
    rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL))
        .map_err(std::io::Error::from)?;
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .map_err(|error| Failure::new(ExitCode::Internal, error))?;
    let mut text = Vec::new();
    std::io::stdin().read_to_end(&mut text)?;
    let job: ClipJob = serde_json::from_slice(&text).map_err(|error| Failure::new(ExitCode::Usage, error))?;
    let cancel = cancel_on_signals()?;
    let speaker = Speaker { out: Mutex::new(std::io::stdout()) };
    let result = run_clip(&job, out, installation, options, &speaker, &cancel);
    let (outcome, skipped) = match result {
        Ok(run) => (run.outcome, run.skipped),
        Err(failure) => (failed(&job, out, failure)?, false),
    };
    let exit = outcome.exit;
    speaker.say(&WorkerMessage::Finished {
        outcome: Box::new(outcome),
        skipped,
        peak_memory_mib: peak_memory_mib(),
    });
    Ok(exit)
}

fn failed(job: &ClipJob, out: &Path, failure: ClipFailure) -> Result<ClipOutcome, Failure> {
    let outcome = ClipOutcome {
        id: job.id.clone(),
        exit: failure.exit,
        stage: failure.stage.map(|stage| stage.name().to_owned()),
        message: Some(failure.message),
        inputs: String::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        frames: None,
        flags: Vec::new(),
    };
    // A cancelled clip has not failed: it is simply not done.
    if outcome.exit != ExitCode::Cancelled {
        write_failure(&out.join(&job.id), &outcome)?;
    }
    Ok(outcome)
}

/// Says messages on standard output, one JSON object a line.
struct Speaker {
    out: Mutex<std::io::Stdout>,
}

impl Speaker {
    fn say(&self, message: &WorkerMessage) {
        let Ok(mut text) = serde_json::to_string(message) else { return };
        text.push('\n');
        let mut out = self.out.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        // When the batch is gone this process is killed anyway.
        out.write_all(text.as_bytes()).and_then(|()| out.flush()).ok();
    }
}

impl Listener for Speaker {
    fn progress(&self, stage: Stage, done: usize, total: usize, share: f64) {
        self.say(&WorkerMessage::Progress { stage: stage.name().to_owned(), done, total, share });
    }

    fn note(&self, text: &str) {
        self.say(&WorkerMessage::Note { text: text.to_owned() });
    }
}

/// This process's largest resident size plus that of its largest child (estimator, encoders), MiB.
fn peak_memory_mib() -> Option<f64> {
    let own = nix::sys::resource::getrusage(nix::sys::resource::UsageWho::RUSAGE_SELF).ok()?;
    let children = nix::sys::resource::getrusage(nix::sys::resource::UsageWho::RUSAGE_CHILDREN).ok()?;
    // Linux counts in KiB.
    Some((own.max_rss() + children.max_rss()) as f64 / 1024.0)
}
