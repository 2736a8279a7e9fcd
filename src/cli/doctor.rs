//! `agenticfocus doctor`.

use serde::Serialize;

use super::{Failure, Outcome};
use crate::pipeline::{ExitCode, Installation};

#[derive(Serialize)]
struct Report {
    parts: Vec<crate::pipeline::PartReport>,
    stages: Vec<crate::pipeline::StageBackend>,
    ready: bool,
}

pub(super) fn run(json: bool) -> Outcome {
    let installation = Installation::locate();
    let parts = installation.examine();
    let stages = installation.stage_backends(&parts);
    let ready = parts.iter().all(|part| part.found.is_some() || !part.required);
    let report = Report { parts, stages, ready };
    if json {
        let text =
            serde_json::to_string_pretty(&report).map_err(|error| Failure::new(ExitCode::Internal, error))?;
        println!("{text}");
    } else {
        print(&report);
    }
    // A missing part is cured by the printed command: try again then.
    Ok(if ready { ExitCode::Done } else { ExitCode::Temporary })
}

fn print(report: &Report) {
    println!("Parts");
    for part in &report.parts {
        match &part.found {
            Some(found) => println!("  ok       {:22} {found}", part.name),
            None => {
                let word = if part.required { "MISSING" } else { "absent" };
                println!(
                    "  {word:8} {:22} needed for {}; install it with: {}",
                    part.name, part.purpose, part.remedy
                );
            }
        }
    }
    println!("\nStages");
    for stage in &report.stages {
        println!("  {:10} {}", stage.stage, stage.backend);
    }
    println!("\n{}", if report.ready { "ready" } else { "not ready: install what is MISSING above" });
}
