//! `agenticfocus doctor`.

use serde::Serialize;

use super::{Failure, Outcome, models::ModelArguments};
use crate::pipeline::{ExitCode, Installation, ModelReport};

#[derive(Serialize)]
struct Report {
    parts: Vec<crate::pipeline::PartReport>,
    models: Vec<Model>,
    stages: Vec<crate::pipeline::StageBackend>,
    ready: bool,
}

/// A learned model that is there.
#[derive(Serialize)]
struct Model {
    name: String,
    contract: String,
    active: bool,
    /// Why it is not active.
    reason: Option<String>,
    warning: Option<String>,
}

impl From<ModelReport> for Model {
    fn from(found: ModelReport) -> Self {
        let ModelReport { name, contract, state, warning } = found;
        Self {
            name,
            contract,
            active: state.is_ok(),
            reason: state.err().map(|error| error.to_string()),
            warning,
        }
    }
}

pub(super) fn run(json: bool, models: &ModelArguments) -> Outcome {
    let installation = Installation { models: models.options(), ..Installation::locate() };
    let parts = installation.examine();
    let models = installation.examine_models();
    let stages = installation.stage_backends(&parts, &models);
    let ready = parts.iter().all(|part| part.found.is_some() || !part.required);
    let models = models.into_iter().map(Model::from).collect();
    let report = Report { parts, models, stages, ready };
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
    if !report.models.is_empty() {
        println!("\nModels");
    }
    for model in &report.models {
        let word = if model.active { "active" } else { "REFUSED" };
        println!("  {word:8} {:22} {}", model.contract, model.reason.as_deref().unwrap_or(&model.name));
        if let Some(warning) = &model.warning {
            println!("  {:8} {:22} {warning}", "warning", "");
        }
    }
    println!("\nStages");
    for stage in &report.stages {
        println!("  {:10} {}", stage.stage, stage.backend);
    }
    println!("\n{}", if report.ready { "ready" } else { "not ready: install what is MISSING above" });
}
