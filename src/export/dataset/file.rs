//! Files that are there whole or not at all.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
};

use serde::Serialize;

use super::DatasetError;

/// Lets `write` fill a file beside `path`, flushes it and puts it in its place.
pub(super) fn write_whole(
    path: &Path,
    write: impl FnOnce(&Path) -> Result<(), DatasetError>,
) -> Result<(), DatasetError> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(DatasetError::io(folder, "create the folder"))?;
    }
    let part = part_of(path);
    let written = write(&part).and_then(|()| {
        let file = File::open(&part).map_err(DatasetError::io(&part, "open the file"))?;
        file.sync_all().map_err(DatasetError::io(&part, "flush the file"))?;
        fs::rename(&part, path).map_err(DatasetError::io(path, "put the file in place"))
    });
    if written.is_err() {
        // The error that matters is the first one.
        let _ = fs::remove_file(&part);
    }
    written
}

/// Keeps the ending: encoders choose the container by it.
fn part_of(path: &Path) -> PathBuf {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    path.with_file_name(format!(".part-{name}"))
}

/// Writes `value` as indented JSON with a final newline.
pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), DatasetError> {
    let mut text = serde_json::to_vec_pretty(value)
        .map_err(|error| DatasetError::io(path, "write the file")(error.into()))?;
    text.push(b'\n');
    write_bytes(path, &text)
}

/// Writes one JSON value a line.
pub(super) fn write_lines<T: Serialize>(path: &Path, values: &[T]) -> Result<(), DatasetError> {
    let mut text = Vec::new();
    for value in values {
        serde_json::to_writer(&mut text, value)
            .map_err(|error| DatasetError::io(path, "write the file")(error.into()))?;
        text.push(b'\n');
    }
    write_bytes(path, &text)
}

fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), DatasetError> {
    // What is the same already keeps its file.
    if fs::read(path).is_ok_and(|there| there == bytes) {
        return Ok(());
    }
    write_whole(path, |part| fs::write(part, bytes).map_err(DatasetError::io(part, "write the file")))
}
