//! `agenticfocus import-masks`.

use super::{
    Failure, Outcome,
    args::{ImportMasksArguments, MaskNumbering},
    batch::cancel_on_signals,
    progress::SimpleProgress,
};
use crate::{
    pipeline::{ExitCode, FrameNumbering, LayerLabels, import_masks},
    session::Session,
};

pub(super) fn run(arguments: &ImportMasksArguments) -> Outcome {
    let (mut session, _) = Session::open(&arguments.session).map_err(|error| Failure::from_error(&error))?;
    let labels = LayerLabels {
        object: arguments.object_label,
        arms: arguments.arms_label,
        both: arguments.both_label,
    };
    let numbering = match arguments.frames {
        MaskNumbering::Timeline => FrameNumbering::Timeline,
        MaskNumbering::Source => FrameNumbering::Source,
    };
    let cancel = cancel_on_signals()?;
    let progress = SimpleProgress::new("import-masks", &cancel);
    let report = import_masks(&mut session, &arguments.masks, numbering, &labels, &progress)
        .map_err(|failure| Failure::new(failure.exit, failure.message))?;
    session.save_snapshot().map_err(|error| Failure::from_error(&error))?;
    println!(
        "{}: the object's mask on {} frames, the arms' on {}, from {}",
        arguments.session.display(),
        report.object,
        report.arms,
        arguments.masks.display()
    );
    for (label, count) in &report.others {
        println!(
            "not imported: label {label}, {count} times; see --object-label, --arms-label, --both-label"
        );
    }
    if let (Some(first), Some(last)) = (report.outside.first(), report.outside.last()) {
        let count = report.outside.len();
        println!("not imported: {count} frames outside the clip, {first} to {last}; see --frames");
    }
    Ok(ExitCode::Done)
}
