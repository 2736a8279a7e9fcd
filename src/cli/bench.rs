//! `agenticfocus bench`.

use super::{
    Failure, Outcome,
    args::BenchArguments,
    batch::{cancel_on_signals, worker_arguments},
    progress::SimpleProgress,
};
use crate::pipeline::{BenchOptions, ExitCode, Installation, Listener, Stage, run_bench};

pub(super) fn run(arguments: &BenchArguments) -> Outcome {
    let cancel = cancel_on_signals()?;
    let scratch = tempfile::tempdir()?;
    let out = arguments.out.clone().unwrap_or_else(|| scratch.path().to_owned());
    let options = BenchOptions {
        seed: arguments.seed,
        episodes: arguments.episodes,
        memory_growth: !arguments.quick,
        out,
        worker: (std::env::current_exe()?, worker_arguments(1)),
    };
    let progress = SimpleProgress::new("bench", &cancel);
    let figures = run_bench(&options, &Installation::locate(), &Notes, &progress, &cancel)
        .map_err(|failure| Failure::new(failure.exit, failure.message))?;
    drop(progress);
    if arguments.json {
        println!("{:#}", figures.to_json());
    } else {
        let last = arguments.seed + u64::from(arguments.episodes.max(1)) - 1;
        println!("seeds {} to {last}; seeds below 3100 may have been used for tuning\n", arguments.seed);
        println!("{}", figures.to_table());
    }
    Ok(ExitCode::Done)
}

/// Prints notes to standard error, where they leave the JSON alone.
struct Notes;

impl Listener for Notes {
    fn progress(&self, _stage: Stage, _done: usize, _total: usize, _share: f64) {}

    fn note(&self, text: &str) {
        eprintln!("bench: {text}");
    }
}
