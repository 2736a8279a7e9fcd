//! `agenticfocus ui`: starts the desktop program, which this one does not link.

use std::{path::Path, process::Command};

use super::{Failure, ModelArguments, Outcome};
use crate::pipeline::ExitCode;

pub(super) fn run(input: Option<&Path>, models: &ModelArguments) -> Outcome {
    let name = format!("agenticfocus-ui{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe()?.with_file_name(&name);
    let program = if beside.is_file() { beside.into_os_string() } else { name.into() };
    let status = Command::new(&program).args(models.words()).args(input).status().map_err(|error| {
        let program = program.to_string_lossy();
        let hint = "build it with `cargo build -p agenticfocus-ui`, or put it beside this program";
        Failure::new(ExitCode::Usage, format_args!("cannot start {program}: {error}; {hint}"))
    })?;
    Ok(status.code().map_or(ExitCode::Internal, ExitCode::from_status))
}
