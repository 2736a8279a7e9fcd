//! Finding episodes below the paths that were given.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use super::{Source, SourceError, Sources, io, read_track, world_motion};

/// Folders are searched this deep.
const DEEPEST: usize = 4;

/// The episodes in `paths`, files or folders, in order of their names.
///
/// A folder with `record.npz` is a finished clip; its hand track is looked for in the cache of the session beside it.
/// Other `.npz` and `.json` files are hand tracks where they hold one; a JSON file with `joints_world` is a captured
/// hand in world axes. What is found in a folder and holds no hands is left out with a note; what was named itself must
/// hold some.
///
/// # Errors
/// When a path cannot be read, or holds nothing to evaluate.
pub fn find_sources(paths: &[PathBuf]) -> Result<Sources, SourceError> {
    let mut sources = Sources::default();
    for path in paths {
        let before = sources.len();
        if fs::metadata(path).map_err(io(path))?.is_dir() {
            search(path, DEEPEST, &mut sources)?;
        } else {
            let name = stem(path);
            let source = if world_motion::is_one(path) {
                Source::World { name, path: path.clone() }
            } else {
                read_track(path)?;
                Source::Track { name, path: path.clone() }
            };
            sources.episodes.push(source);
        }
        if sources.len() == before {
            return Err(SourceError::Nothing(path.clone()));
        }
    }
    make_names_unique(&mut sources.episodes);
    Ok(sources)
}

fn search(folder: &Path, deeper: usize, sources: &mut Sources) -> Result<(), SourceError> {
    let mut entries = Vec::new();
    for entry in fs::read_dir(folder).map_err(io(folder))? {
        entries.push(entry.map_err(io(folder))?.path());
    }
    entries.sort();
    let record = folder.join("record.npz");
    if record.is_file() {
        let tracks = cached_tracks(folder);
        if tracks.is_empty() {
            let at = folder.display();
            sources.notes.push(format!("{at}: left out, no hand track in the cache of its session"));
        } else {
            sources.episodes.push(Source::Record { name: stem(folder), record, tracks });
        }
        return Ok(());
    }
    for path in entries {
        if path.is_dir() {
            let is_session = path.extension().is_some_and(|extension| extension == "afs");
            if deeper > 0 && !is_session {
                search(&path, deeper - 1, sources)?;
            }
        } else if world_motion::is_one(&path) {
            sources.episodes.push(Source::World { name: stem(&path), path });
        } else if matches!(path.extension().and_then(|e| e.to_str()), Some("npz" | "json")) {
            match read_track(&path) {
                Ok(_) => sources.episodes.push(Source::Track { name: stem(&path), path }),
                Err(error) => sources.notes.push(format!("left out: {error}")),
            }
        }
    }
    Ok(())
}

/// Hand tracks in the caches of the sessions that may belong to the clip folder, in order.
fn cached_tracks(folder: &Path) -> Vec<PathBuf> {
    let beside = folder.with_file_name(format!("{}.afs", stem(folder)));
    let mut found = Vec::new();
    if let Ok(entries) = fs::read_dir(beside.join("cache")) {
        for path in entries.flatten().map(|entry| entry.path()) {
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            if name.starts_with("hands-") && name.ends_with(".json") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn stem(path: &Path) -> String {
    let name = if path.is_dir() { path.file_name() } else { path.file_stem() };
    name.map_or_else(|| "track".to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Episodes of one name get numbers, in order.
fn make_names_unique(episodes: &mut [Source]) {
    let mut taken = BTreeSet::new();
    for source in episodes {
        let name = match source {
            Source::Synthetic(_) => continue,
            Source::Track { name, .. } | Source::World { name, .. } | Source::Record { name, .. } => name,
        };
        let mut number = 1;
        let first = name.clone();
        while !taken.insert(name.clone()) {
            number += 1;
            *name = format!("{first}-{number}");
        }
    }
}
