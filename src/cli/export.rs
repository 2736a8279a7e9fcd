//! `agenticfocus export`.

use super::{
    Failure, Outcome,
    args::{ExportArguments, ExportFormat, ExportThumbOrder},
    batch::cancel_on_signals,
    progress::SimpleProgress,
};
use crate::{
    export::dataset::{ClipFate, DatasetFormat, DatasetOptions, DatasetReport, ThumbOrder, export_dataset},
    pipeline::ExitCode,
};

pub(super) fn run(arguments: &ExportArguments) -> Outcome {
    let options = DatasetOptions {
        format: match arguments.format {
            ExportFormat::LerobotV3 => DatasetFormat::LerobotV3,
            ExportFormat::LerobotV21 => DatasetFormat::LerobotV21,
            ExportFormat::UnitreeJson => DatasetFormat::UnitreeJson,
            ExportFormat::Coco => DatasetFormat::Coco,
            ExportFormat::Davis => DatasetFormat::Davis,
        },
        thumb_order: match arguments.brainco_thumb_order {
            ExportThumbOrder::Hardware => ThumbOrder::Hardware,
            ExportThumbOrder::UnitreeXr => ThumbOrder::UnitreeXr,
        },
        include_rejected: arguments.include_rejected,
    };
    let cancel = cancel_on_signals()?;
    let progress = SimpleProgress::new("export", &cancel);
    let report = export_dataset(&arguments.inputs, &arguments.out, &options, &progress)
        .map_err(|error| Failure::new(ExitCode::from_status(i32::from(error.exit_code())), error))?;
    if arguments.json {
        let text = serde_json::to_string_pretty(&report).map_err(|e| Failure::new(ExitCode::Internal, e))?;
        println!("{text}");
    } else {
        print_table(&report);
    }
    Ok(ExitCode::Done)
}

fn print_table(report: &DatasetReport) {
    let width = report.clips.iter().map(|row| row.id.len()).max().unwrap_or(4).max(4);
    println!("{:width$}  {:>7}  {:>6}  what became of it", "clip", "episode", "frames");
    for row in &report.clips {
        let frames = row.frames.map(|frames| frames.to_string()).unwrap_or_default();
        let (episode, mut fate) = match &row.fate {
            ClipFate::Written { episode } => (episode.to_string(), "written".to_owned()),
            ClipFate::Present { episode } => (episode.to_string(), "there already".to_owned()),
            ClipFate::LeftOut { reason } => ("-".to_owned(), format!("left out: {reason}")),
        };
        for note in &row.notes {
            fate = format!("{fate}; {note}");
        }
        println!("{:width$}  {episode:>7}  {frames:>6}  {fate}", row.id);
    }
    let left_out = report.clips.iter().filter(|row| matches!(row.fate, ClipFate::LeftOut { .. })).count();
    println!(
        "{}: {} episodes, {} frames; {left_out} clips left out",
        report.out.display(),
        report.episodes,
        report.frames
    );
}
