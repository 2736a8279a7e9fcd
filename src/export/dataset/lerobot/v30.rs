//! Metadata of LeRobot v3.0: tables.

use std::{path::Path, sync::Arc};

use arrow_array::{ArrayRef, Float64Array, Int64Array, StringArray};
use serde_json::{Map, Value, json};

use super::{
    CHUNK, FPS, Placed, VIDEO, Version, info, stats,
    table::{self, Column},
};
use crate::{
    export::dataset::{DatasetError, FeatureStats, file, ledger::Ledger},
    robot::ACTUATED_DOF,
};

pub(super) fn write(out: &Path, ledger: &Ledger) -> Result<(), DatasetError> {
    let meta = out.join("meta");
    write_tasks(&meta.join("tasks.parquet"), &ledger.tasks())?;
    let placed = Placed::all(ledger);
    for placed in &placed {
        let (chunk, number) = (placed.episode / CHUNK, placed.episode % CHUNK);
        let path = meta.join(format!("episodes/chunk-{chunk:03}/file-{number:03}.parquet"));
        // It follows from the episode and those before it: once written it stays.
        if !path.is_file() {
            table::write(&path, episode(placed, ledger), None)?;
        }
    }
    file::write_json(&meta.join("stats.json"), &dataset_stats(out, ledger, &placed)?)?;
    // Last: a loader looks here first.
    file::write_json(&meta.join("info.json"), &info::info(ledger, Version::V30))
}

/// The pandas table that has the sentence as its index; without these metadata a loader silently takes the number
/// for the task.
fn write_tasks(path: &Path, tasks: &[&str]) -> Result<(), DatasetError> {
    let numbers: Vec<i64> = (0..tasks.len() as i64).collect();
    let column = |name: &str, kind: &str, numpy: &str| json!({ "name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy, "metadata": null });
    let pandas = json!({
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [column("task_index", "int64", "int64"), column("task", "unicode", "object")],
        "pandas_version": "2.2.0",
    });
    let columns: Vec<Column> = vec![
        ("task_index".to_owned(), Arc::new(Int64Array::from(numbers)) as ArrayRef),
        ("task".to_owned(), Arc::new(StringArray::from(tasks.to_vec())) as ArrayRef),
    ];
    table::write(path, columns, Some(("pandas", pandas.to_string())))
}

/// The one row of an episode's metadata.
fn episode(placed: &Placed<'_>, ledger: &Ledger) -> Vec<Column> {
    let note = placed.note;
    let (chunk, number) = (placed.episode / CHUNK, placed.episode % CHUNK);
    let mut columns: Vec<Column> = Vec::new();
    let mut add = |name: &str, data: ArrayRef| columns.push((name.to_owned(), data));
    let whole = |value: usize| Arc::new(Int64Array::from(vec![value as i64])) as ArrayRef;
    let real = |value: f64| Arc::new(Float64Array::from(vec![value])) as ArrayRef;
    let text = |value: &str| Arc::new(StringArray::from(vec![value])) as ArrayRef;
    add("episode_index", whole(placed.episode));
    add("tasks", table::list_of(text(&note.task), vec![0, 1]));
    add("length", whole(note.frames));
    add("data/chunk_index", whole(chunk));
    add("data/file_index", whole(number));
    add("dataset_from_index", whole(placed.from));
    add("dataset_to_index", whole(placed.from + note.frames));
    add(&format!("videos/{VIDEO}/chunk_index"), whole(chunk));
    add(&format!("videos/{VIDEO}/file_index"), whole(number));
    add(&format!("videos/{VIDEO}/from_timestamp"), real(0.0));
    add(&format!("videos/{VIDEO}/to_timestamp"), real(note.frames as f64 / f64::from(FPS)));
    add("meta/episodes/chunk_index", whole(chunk));
    add("meta/episodes/file_index", whole(number));
    for (feature, stats) in &note.stats {
        for (name, values) in stats.named() {
            add(&format!("stats/{feature}/{name}"), table::list_row(values));
        }
        add(&format!("stats/{feature}/count"), counted(stats));
    }
    let pictures = stats::of_pictures(std::iter::once(note));
    for (name, values) in pictures.named() {
        add(&format!("stats/{VIDEO}/{name}"), table::channel_row(values));
    }
    add(&format!("stats/{VIDEO}/count"), counted(&pictures));
    let provenance = &note.provenance;
    add("agenticfocus/id", text(&note.id));
    add("agenticfocus/source_file", text(&provenance.source_file));
    add("agenticfocus/source_hash", text(&provenance.source_hash));
    add("agenticfocus/backends", text(&json!(provenance.backends).to_string()));
    add("agenticfocus/versions", text(&json!(provenance.versions).to_string()));
    add("agenticfocus/parameters", text(&json!(provenance.parameters).to_string()));
    add("agenticfocus/brainco_thumb_order", text(ledger.head.thumb_order.name()));
    columns
}

fn counted(stats: &FeatureStats) -> ArrayRef {
    table::list_of(Arc::new(Int64Array::from(vec![stats.count as i64])), vec![0, 1])
}

/// `meta/stats.json`: over all frames of all episodes, exactly.
fn dataset_stats(out: &Path, ledger: &Ledger, placed: &[Placed<'_>]) -> Result<Value, DatasetError> {
    let mut all = Map::new();
    for feature in ["observation.state", "action"] {
        let mut columns = vec![Vec::new(); ACTUATED_DOF];
        for placed in placed {
            table::read_lists(&out.join(Version::V30.table(placed.episode)), feature, &mut columns)?;
        }
        all.insert(feature.to_owned(), stats::of_vector(&FeatureStats::of_columns(columns)));
    }
    type Value32 = fn(&Placed<'_>, usize) -> f32;
    let numbers: [(&str, Value32); 5] = [
        ("timestamp", |_, frame| frame as f32 / FPS as f32),
        ("frame_index", |_, frame| frame as f32),
        ("episode_index", |placed, _| placed.episode as f32),
        ("index", |placed, frame| (placed.from + frame) as f32),
        ("task_index", |placed, _| placed.task as f32),
    ];
    for (feature, value) in numbers {
        let rows =
            placed.iter().flat_map(|placed| (0..placed.note.frames).map(move |frame| value(placed, frame)));
        all.insert(feature.to_owned(), stats::of_vector(&FeatureStats::of_columns(vec![rows.collect()])));
    }
    let pictures = stats::of_pictures(ledger.episodes.iter());
    all.insert(VIDEO.to_owned(), stats::of_channels(&pictures));
    Ok(Value::Object(all))
}
