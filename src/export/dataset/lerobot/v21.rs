//! Metadata of LeRobot v2.1: JSON Lines.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::{Placed, VIDEO, Version, info, modality, stats};
use crate::export::dataset::{DatasetError, file, ledger::Ledger};

pub(super) fn write(out: &Path, ledger: &Ledger) -> Result<(), DatasetError> {
    let meta = out.join("meta");
    let tasks: Vec<Value> = ledger
        .tasks()
        .iter()
        .enumerate()
        .map(|(index, task)| json!({ "task_index": index, "task": task }))
        .collect();
    file::write_lines(&meta.join("tasks.jsonl"), &tasks)?;
    let placed = Placed::all(ledger);
    let episodes: Vec<Value> = placed.iter().map(|placed| episode(placed, ledger)).collect();
    file::write_lines(&meta.join("episodes.jsonl"), &episodes)?;
    let all: Vec<Value> = placed.iter().map(episode_stats).collect();
    file::write_lines(&meta.join("episodes_stats.jsonl"), &all)?;
    file::write_json(&meta.join("modality.json"), &modality::modality())?;
    // Last: a loader looks here first.
    file::write_json(&meta.join("info.json"), &info::info(ledger, Version::V21))
}

fn episode(placed: &Placed<'_>, ledger: &Ledger) -> Value {
    let note = placed.note;
    json!({
        "episode_index": placed.episode,
        "tasks": [note.task],
        "length": note.frames,
        "agenticfocus": {
            "id": note.id,
            "provenance": note.provenance,
            "brainco_thumb_order": ledger.head.thumb_order.name(),
        },
    })
}

fn episode_stats(placed: &Placed<'_>) -> Value {
    let note = placed.note;
    let mut all: Map<String, Value> =
        note.stats.iter().map(|(name, stats)| (name.clone(), stats::of_vector(stats))).collect();
    let task = all.get("task_index").cloned();
    all.extend(task.map(|task| (super::ANNOTATION.to_owned(), task)));
    let pictures = stats::of_pictures(std::iter::once(note));
    all.insert(VIDEO.to_owned(), stats::of_channels(&pictures));
    json!({ "episode_index": placed.episode, "stats": all })
}
