//! The command line: argument parsing and printing only.

mod args;
mod batch;
mod bench;
mod demo;
mod doctor;
mod eval;
mod export;
mod import_masks;
mod models;
mod progress;
mod robot;
mod status;
mod synth;
mod ui;
mod vlm;
mod worker;

use std::process::ExitCode as ProcessExit;

use clap::Parser as _;

use crate::pipeline::{ExitCode, Installation, RunOptions};
use args::{Arguments, Verb};

pub use models::ModelArguments;

/// What a subcommand comes back with: an exit code, or a line for standard error and its code.
type Outcome = Result<ExitCode, Failure>;

/// A line for the user and the code that goes with it.
#[derive(Debug)]
struct Failure {
    exit: ExitCode,
    message: String,
}

impl Failure {
    fn new(exit: ExitCode, message: impl std::fmt::Display) -> Self {
        Self { exit, message: message.to_string() }
    }
}

impl Failure {
    /// With the class that the error's chain of causes says, internal where it says nothing.
    fn from_error(error: &(dyn std::error::Error + 'static)) -> Self {
        let failure = crate::pipeline::ClipFailure::from_error(error, ExitCode::Internal);
        Self::new(failure.exit, failure.message)
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::new(ExitCode::from(&error), error)
    }
}

/// Parses the process's arguments, does what they say, and returns the exit status.
pub fn run() -> ProcessExit {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let status = if error.use_stderr() { ExitCode::Usage } else { ExitCode::Done };
            // A closed pipe (`--help | head`) is no reason to fail.
            error.print().ok();
            return ProcessExit::from(status.status());
        }
    };
    let exit = match dispatch(arguments) {
        Ok(exit) => exit,
        Err(failure) => {
            eprintln!("agenticfocus: {}", failure.message);
            failure.exit
        }
    };
    ProcessExit::from(exit.status())
}

fn dispatch(arguments: Arguments) -> Outcome {
    let Arguments { batch, verb } = arguments;
    match verb {
        Some(Verb::Demo { out, seed, frames }) => demo::run(&out, seed, frames),
        Some(Verb::Synth { episodes, seed, frames, out }) => synth::run(&out, episodes, seed, frames),
        Some(Verb::Bench(arguments)) => bench::run(&arguments),
        Some(Verb::Eval(arguments)) => eval::run(&arguments),
        Some(Verb::Export(arguments)) => export::run(&arguments),
        Some(Verb::ImportMasks(arguments)) => import_masks::run(&arguments),
        Some(Verb::Robot { verb }) => robot::run(&verb),
        Some(Verb::Ui { input, models }) => ui::run(input.as_deref(), &models),
        Some(Verb::ClipWorker { threads, keep_frames, layers, vlm, models, out }) => {
            let installation = Installation { models: models.options(), ..vlm.installation() };
            worker::run(&out, threads, RunOptions { keep_frames, layers }, &installation)
        }
        Some(Verb::Doctor { json, models }) => doctor::run(json, &models),
        Some(Verb::Status { out, json }) => status::run(&out, json),
        None => batch::run(&batch),
    }
}
