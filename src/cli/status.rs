//! `agenticfocus status DIR`.

use std::path::Path;

use super::{Failure, Outcome};
use crate::pipeline::{ExitCode, batch::folder_status};

pub(super) fn run(out: &Path, json: bool) -> Outcome {
    let rows = folder_status(out).map_err(|error| {
        Failure::new(ExitCode::from(&error), format_args!("cannot list {}: {error}", out.display()))
    })?;
    if json {
        let text = serde_json::to_string_pretty(&rows).map_err(|e| Failure::new(ExitCode::Internal, e))?;
        println!("{text}");
        return Ok(ExitCode::Done);
    }
    let width = rows.iter().map(|row| row.id.len()).max().unwrap_or(2).max(4);
    println!("{:width$}  {:18}  {:>6}  note", "clip", "state", "frames");
    for row in &rows {
        let state = row.exit.map_or("pending", ExitCode::word);
        let frames = row.frames.map(|frames| frames.to_string()).unwrap_or_default();
        let note = row.message.clone().unwrap_or_else(|| row.flags.join(", "));
        println!("{:width$}  {state:18}  {frames:>6}  {note}", row.id);
    }
    Ok(ExitCode::Done)
}
