//! The headless program, for tests of its own package.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

use std::{
    path::Path,
    process::{Command, Output},
};

/// Runs the batch.
pub fn batch(inputs: &[&Path], out: &Path, more: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_agenticfocus");
    let mut command = Command::new(program);
    command.env("XDG_DATA_HOME", out.join("no-data"));
    command.arg("--batch").args(inputs).arg("--out").arg(out).args(more).output().unwrap()
}
