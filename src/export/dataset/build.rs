//! The export itself: clip by clip, each whole before the next begins.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::{
    ClipFate, DatasetError, DatasetFormat, DatasetOptions, DatasetReport, DatasetRow,
    clip::{FinishedClip, Found, find},
    coco, davis,
    ledger::{EpisodeNote, Ledger, Provenance},
    lerobot::{self, Version},
    unitree, video,
};
use crate::progress::Watch;

/// Puts the finished clips of `inputs` (their folders, or output folders of batches) into the dataset `out`, which
/// is made where it is missing and lengthened where it is there.
///
/// Clips that failed, and rejected ones unless asked for, are left out and named in the report.
///
/// # Errors
/// When `out` holds something else, an input holds no clip, a clip's folder is damaged or was made anew since its
/// export, the file system fails, or `watch` cancels. Episodes that are whole by then stay.
pub fn export_dataset(
    inputs: &[PathBuf],
    out: &Path,
    options: &DatasetOptions,
    watch: &dyn Watch,
) -> Result<DatasetReport, DatasetError> {
    let found = find(inputs)?;
    let mut ledger = Ledger::open(out, options.format, options.thumb_order)?;
    let total = found.len();
    let mut clips = Vec::with_capacity(total);
    for (number, found) in found.into_iter().enumerate() {
        watch.check()?;
        clips.push(take(found, out, &mut ledger, options)?);
        watch.advance(number + 1, total);
    }
    match options.format {
        DatasetFormat::LerobotV3 => lerobot::write_metadata(out, &ledger, Version::V30)?,
        DatasetFormat::LerobotV21 => lerobot::write_metadata(out, &ledger, Version::V21)?,
        DatasetFormat::UnitreeJson | DatasetFormat::Coco | DatasetFormat::Davis => {}
    }
    let (episodes, frames) = (ledger.episodes.len(), ledger.frames());
    Ok(DatasetReport { format: options.format, out: out.to_owned(), clips, episodes, frames })
}

/// One clip's line of the report, after what it says was done.
fn take(
    found: Found,
    out: &Path,
    ledger: &mut Ledger,
    options: &DatasetOptions,
) -> Result<DatasetRow, DatasetError> {
    let clip = match found {
        Found::Finished(clip) => clip,
        Found::Unfinished { folder, id, reason } => {
            let fate = ClipFate::LeftOut { reason };
            return Ok(DatasetRow { id, folder, frames: None, fate, notes: Vec::new() });
        }
    };
    let row = |fate: ClipFate, notes: Vec<String>| DatasetRow {
        id: clip.id.clone(),
        folder: clip.folder.clone(),
        frames: Some(clip.frames()),
        fate,
        notes,
    };
    if let Some(episode) = ledger.episode_of(&clip)? {
        return Ok(row(ClipFate::Present { episode }, ledger.episodes[episode].notes.clone()));
    }
    if let Some(reason) = clip.rejected.as_ref().filter(|_| !options.include_rejected) {
        let reason = format!("rejected: {reason} (--include-rejected takes it all the same)");
        return Ok(row(ClipFate::LeftOut { reason }, Vec::new()));
    }
    let episode = ledger.episodes.len();
    let note = match options.format {
        DatasetFormat::LerobotV3 => lerobot::write_episode(out, ledger, &clip, Version::V30)?,
        DatasetFormat::LerobotV21 => lerobot::write_episode(out, ledger, &clip, Version::V21)?,
        DatasetFormat::UnitreeJson => unitree_episode(out, ledger, &clip)?,
        DatasetFormat::Coco => {
            let size = coco::write_clip(&clip, &out.join("annotations").join(format!("{}.json", clip.id)))?;
            plain_note(&clip, size)
        }
        DatasetFormat::Davis => {
            let folder = out.join("Annotations").join(&clip.id);
            let size = whole_folder(&folder, |part| davis::write_clip(&clip, part))?;
            plain_note(&clip, size)
        }
    };
    let notes = note.notes.clone();
    ledger.add(note)?;
    Ok(row(ClipFate::Written { episode }, notes))
}

fn unitree_episode(out: &Path, ledger: &Ledger, clip: &FinishedClip) -> Result<EpisodeNote, DatasetError> {
    let size = video::checked(clip)?.size;
    let task = folder_name(clip.task());
    // Its converter counts the episodes of a task from one on.
    let earlier = ledger.episodes.iter().filter(|note| folder_name(&note.task) == task).count();
    let folder = out.join(&task).join(format!("episode_{:04}", earlier + 1));
    whole_folder(&folder, |part| unitree::write_episode(clip, size, ledger.head.thumb_order, part))?;
    Ok(plain_note(clip, size))
}

/// A task sentence as a folder's name.
fn folder_name(task: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let name: String = task.chars().map(plain).take(60).collect();
    let name = name.trim_matches('_');
    if name.is_empty() { "task".to_owned() } else { name.to_owned() }
}

fn plain_note(clip: &FinishedClip, size: crate::geometry::Size) -> EpisodeNote {
    EpisodeNote {
        id: clip.id.clone(),
        key: clip.key.clone(),
        frames: clip.frames(),
        task: clip.task().to_owned(),
        size,
        notes: Vec::new(),
        provenance: Provenance::of(clip),
        stats: std::collections::BTreeMap::new(),
        pictures: None,
    }
}

/// Lets `fill` fill a folder beside `folder` and puts it in its place.
fn whole_folder<T>(
    folder: &Path,
    fill: impl FnOnce(&Path) -> Result<T, DatasetError>,
) -> Result<T, DatasetError> {
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let part = folder.with_file_name(format!(".part-{name}"));
    // Both may be there from a run that was killed before it could note the episode.
    for old in [&part, folder] {
        if old.exists() {
            fs::remove_dir_all(old).map_err(DatasetError::io(old, "remove what a killed export left"))?;
        }
    }
    fs::create_dir_all(&part).map_err(DatasetError::io(&part, "create the folder"))?;
    let filled = fill(&part).inspect_err(|_| {
        // The error that matters is the first one.
        let _ = fs::remove_dir_all(&part);
    })?;
    fs::rename(&part, folder).map_err(DatasetError::io(folder, "put the folder in place"))?;
    Ok(filled)
}
