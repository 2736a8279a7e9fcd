//! Files that survive a crash: sibling, fsync, rename, fsync of the folder.

use std::{
    fs::{self, File},
    io::{self, Write as _},
    path::Path,
};

/// Writes `bytes` to `path` so that after a crash either the old or the new content is there, whole.
///
/// # Errors
/// What the file system says; `path` is untouched then.
pub fn write_durably(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?.to_string_lossy();
    let sibling = folder.join(format!(".{name}.{}.tmp", std::process::id()));
    let written = (|| {
        let mut file = File::create(&sibling)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&sibling, path)?;
        sync_folder(folder)
    })();
    if written.is_err() {
        // The first error is the one to report; a sibling left behind is harmless.
        fs::remove_file(&sibling).ok();
    }
    written
}

/// Makes renames and new names inside `folder` durable.
///
/// # Errors
/// What the file system says.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}
