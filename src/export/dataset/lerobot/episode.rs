//! One episode: its table and its video.

use std::{collections::BTreeMap, path::Path, sync::Arc};

use arrow_array::{ArrayRef, Float32Array, Int64Array};

use super::{ANNOTATION, FPS, Version, table};
use crate::{
    export::dataset::{
        DatasetError, FeatureStats, ThumbOrder,
        clip::{FinishedClip, Rows},
        file, images,
        ledger::{EpisodeNote, Ledger, Provenance, task_index},
        video,
    },
    geometry::Size,
    robot::ACTUATED_DOF,
};

/// Writes the next episode of `ledger` into the dataset `out`; its pictures get `size`, or where there is none yet,
/// give it.
pub(in super::super) fn write_episode(
    out: &Path,
    ledger: &Ledger,
    clip: &FinishedClip,
    version: Version,
) -> Result<EpisodeNote, DatasetError> {
    let episode = ledger.episodes.len();
    let found = video::checked(clip)?;
    let size: Size = ledger.episodes.first().map_or(found.size, |first| first.size);
    let mut notes = Vec::new();
    file::write_whole(&out.join(version.video(episode)), |part| {
        notes.extend(video::place(clip, &found, size, part)?);
        Ok(())
    })?;
    let rows = Arranged::new(clip.rows()?, ledger.head.thumb_order);
    let place = Place {
        episode,
        from: ledger.frames(),
        task: task_index(&ledger.tasks(), clip.task()),
        frames: clip.frames(),
    };
    let columns = columns(&rows, &place, version);
    table::write(&out.join(version.table(episode)), columns, None)?;
    Ok(EpisodeNote {
        id: clip.id.clone(),
        key: clip.key.clone(),
        frames: clip.frames(),
        task: clip.task().to_owned(),
        size,
        notes,
        provenance: Provenance::of(clip),
        stats: rows.stats(&place),
        pictures: Some(images::histograms(clip)?),
    })
}

/// State and action as trainers take them.
struct Arranged {
    state: Vec<[f32; ACTUATED_DOF]>,
    action: Vec<[f32; ACTUATED_DOF]>,
}

/// Where the episode stands in the dataset.
struct Place {
    episode: usize,
    /// Index of its first frame.
    from: usize,
    task: usize,
    frames: usize,
}

impl Place {
    /// A column of the table that follows from the place alone.
    fn column(&self, of: impl Fn(usize) -> usize) -> Vec<i64> {
        (0..self.frames).map(|frame| of(frame) as i64).collect()
    }

    /// Every such column with its name.
    fn columns(&self) -> [(&'static str, Vec<i64>); 4] {
        [
            ("frame_index", self.column(|frame| frame)),
            ("episode_index", self.column(|_| self.episode)),
            ("index", self.column(|frame| self.from + frame)),
            ("task_index", self.column(|_| self.task)),
        ]
    }

    /// Seconds, as the loader asks the video for them.
    fn timestamps(&self) -> Vec<f32> {
        (0..self.frames).map(|frame| frame as f32 / FPS as f32).collect()
    }
}

impl Arranged {
    fn new(rows: Rows, order: ThumbOrder) -> Self {
        let arranged =
            |rows: Vec<[f64; ACTUATED_DOF]>| rows.into_iter().map(|row| order.arrange(row)).collect();
        Self { state: arranged(rows.state), action: arranged(rows.action) }
    }

    fn stats(&self, place: &Place) -> BTreeMap<String, FeatureStats> {
        let vectors = |rows: &[[f32; ACTUATED_DOF]]| {
            let column = |at: usize| rows.iter().map(|row| row[at]).collect();
            FeatureStats::of_columns((0..ACTUATED_DOF).map(column).collect())
        };
        let mut stats = BTreeMap::from([
            ("observation.state".to_owned(), vectors(&self.state)),
            ("action".to_owned(), vectors(&self.action)),
            ("timestamp".to_owned(), FeatureStats::of_columns(vec![place.timestamps()])),
        ]);
        for (name, values) in place.columns() {
            let values = values.into_iter().map(|value| value as f32).collect();
            stats.insert(name.to_owned(), FeatureStats::of_columns(vec![values]));
        }
        stats
    }
}

fn columns(rows: &Arranged, place: &Place, version: Version) -> Vec<table::Column> {
    let mut columns: Vec<table::Column> = vec![
        ("observation.state".to_owned(), table::lists(rows.state.iter())),
        ("action".to_owned(), table::lists(rows.action.iter())),
        ("timestamp".to_owned(), Arc::new(Float32Array::from(place.timestamps())) as ArrayRef),
    ];
    for (name, values) in place.columns() {
        columns.push((name.to_owned(), Arc::new(Int64Array::from(values)) as ArrayRef));
    }
    if version == Version::V21 {
        let task = place.column(|_| place.task);
        columns.push((ANNOTATION.to_owned(), Arc::new(Int64Array::from(task)) as ArrayRef));
    }
    columns
}
