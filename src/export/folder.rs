//! The output folder of one clip: made beside its final place, renamed when whole.

use std::{
    fs::{self, File},
    io::Write,
    path::{Path, PathBuf},
};

use serde::Serialize;

use super::ExportError;

/// Longest clip id.
const MAX_ID: usize = 100;

/// Checks that `id` can be a folder's name on every file system and leads nowhere else.
///
/// # Errors
/// When it is empty, longer than 100, starts with a dot, or holds anything but letters, digits,
/// `.`, `_` and `-`.
pub fn check_id(id: &str) -> Result<(), ExportError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    if !id.is_empty() && id.len() <= MAX_ID && !id.starts_with('.') && id.chars().all(plain) {
        Ok(())
    } else {
        Err(ExportError::BadId(id.to_owned()))
    }
}

/// The output folder of a clip while it is made: `OUT/.tmp-ID-PID`, which becomes `OUT/ID` by one
/// rename. Dropped before [`publish`](Self::publish), it leaves nothing.
#[derive(Debug)]
pub struct ClipFolder {
    temporary: PathBuf,
    target: PathBuf,
    published: bool,
}

impl ClipFolder {
    /// Starts the folder of clip `id` in `out`, creating `out` and the sub-folders of the design.
    /// What runs of this clip that were killed left behind is removed.
    ///
    /// # Errors
    /// When `id` is not a plain name or a folder cannot be created.
    pub fn create(out: &Path, id: &str) -> Result<Self, ExportError> {
        check_id(id)?;
        fs::create_dir_all(out).map_err(|source| ExportError::io(out, "create the folder", source))?;
        remove_leftovers(out, id);
        let temporary = out.join(format!(".tmp-{id}-{}", std::process::id()));
        let folder = Self { temporary, target: out.join(id), published: false };
        let _ = fs::remove_dir_all(&folder.temporary);
        for name in ["masks/object", "masks/hand", "crops", "debug"] {
            let path = folder.temporary.join(name);
            fs::create_dir_all(&path)
                .map_err(|source| ExportError::io(&path, "create the folder", source))?;
        }
        Ok(folder)
    }

    /// Where `name` is to be written, for example `composite.mp4`.
    pub fn file(&self, name: &str) -> PathBuf {
        self.temporary.join(name)
    }

    /// `masks/{kind}/{frame:06}.png`, kind `object` or `hand`.
    pub fn mask_file(&self, kind: &str, frame: crate::clip::FrameIndex) -> PathBuf {
        self.temporary.join(format!("masks/{kind}/{:06}.png", frame.0))
    }

    /// `crops/{frame:06}.png`.
    pub fn crop_file(&self, frame: crate::clip::FrameIndex) -> PathBuf {
        self.temporary.join(format!("crops/{:06}.png", frame.0))
    }

    /// `layers/{layer}/{frame:06}.png`; their folders are made where layers are wanted.
    ///
    /// # Errors
    /// When the folder cannot be made.
    pub fn layer_file(&self, layer: &str, frame: crate::clip::FrameIndex) -> Result<PathBuf, ExportError> {
        let folder = self.temporary.join("layers").join(layer);
        fs::create_dir_all(&folder)
            .map_err(|source| ExportError::io(&folder, "create the folder", source))?;
        Ok(folder.join(format!("{:06}.png", frame.0)))
    }

    /// Writes `done.json`, flushes everything to disk and puts the folder in its place, replacing
    /// an older one. Returns the final path.
    ///
    /// # Errors
    /// When anything cannot be written; then the final place holds no `done.json` of this run.
    pub fn publish(mut self, done: &impl Serialize) -> Result<PathBuf, ExportError> {
        write_json(&self.temporary.join("done.json"), done)?;
        sync_tree(&self.temporary)?;
        let mut old = self.temporary.clone().into_os_string();
        old.push(".old");
        let old = PathBuf::from(old);
        let _ = fs::remove_dir_all(&old);
        match fs::rename(&self.target, &old) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(ExportError::io(&self.target, "replace the folder", error));
            }
            _ => {}
        }
        if let Err(error) = fs::rename(&self.temporary, &self.target) {
            let _ = fs::rename(&old, &self.target);
            return Err(ExportError::io(&self.target, "put the folder in place", error));
        }
        self.published = true;
        if let Some(parent) = self.target.parent() {
            sync(parent)?;
        }
        let _ = fs::remove_dir_all(&old);
        Ok(self.target.clone())
    }
}

impl Drop for ClipFolder {
    fn drop(&mut self) {
        if !self.published {
            let _ = fs::remove_dir_all(&self.temporary);
        }
    }
}

/// Removes `.tmp-ID-PID` folders whose process no longer runs on this machine.
fn remove_leftovers(out: &Path, id: &str) {
    let prefix = format!(".tmp-{id}-");
    for entry in fs::read_dir(out).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let pid = name.strip_prefix(&prefix).map(|rest| rest.strip_suffix(".old").unwrap_or(rest));
        let pid = pid.and_then(|pid| pid.parse().ok()).and_then(rustix::process::Pid::from_raw);
        let is_dead = |pid| rustix::process::test_kill_process(pid) == Err(rustix::io::Errno::SRCH);
        if pid.is_some_and(is_dead) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

fn sync(path: &Path) -> Result<(), ExportError> {
    let flush = File::open(path).and_then(|file| file.sync_all());
    flush.map_err(|source| ExportError::io(path, "flush", source))
}

/// Flushes every file, then its folder, up to `folder` itself.
fn sync_tree(folder: &Path) -> Result<(), ExportError> {
    let failed = |source| ExportError::io(folder, "list", source);
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_dir() { sync_tree(&path)? } else { sync(&path)? }
    }
    sync(folder)
}

/// Writes `value` as indented JSON: a sibling is written and flushed, then renamed.
///
/// # Errors
/// When the file cannot be written.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), ExportError> {
    let write = || -> std::io::Result<()> {
        let mut text = serde_json::to_vec_pretty(value).map_err(std::io::Error::other)?;
        text.push(b'\n');
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(".partial");
        let partial = path.with_file_name(name);
        let mut file = File::create(&partial)?;
        file.write_all(&text)?;
        file.sync_all()?;
        fs::rename(&partial, path)?;
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            File::open(folder)?.sync_all()?;
        }
        Ok(())
    };
    write().map_err(|source| ExportError::io(path, "write", source))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_that_lead_elsewhere_are_refused() {
        for id in ["", ".", "..", "../x", "a/b", ".hidden", "a\0b", "a b", &"x".repeat(101)] {
            assert!(check_id(id).is_err(), "{id:?}");
        }
        for id in ["put", "clip-01_a.b"] {
            assert!(check_id(id).is_ok(), "{id:?}");
        }
    }

    #[test]
    fn a_folder_appears_whole_and_replaces_an_older_one() {
        let out = tempfile::tempdir().unwrap();
        for run in ["first", "second"] {
            let folder = ClipFolder::create(out.path(), "clip").unwrap();
            fs::write(folder.file(run), run).unwrap();
            assert!(!out.path().join("clip").join(run).exists());
            let path = folder.publish(&run).unwrap();
            assert_eq!(path, out.path().join("clip"));
        }
        let clip = out.path().join("clip");
        assert!(clip.join("second").exists() && !clip.join("first").exists());
        assert_eq!(fs::read_to_string(clip.join("done.json")).unwrap(), "\"second\"\n");
        assert_eq!(fs::read_dir(out.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_is_not_published_or_was_killed_leaves_nothing() {
        let out = tempfile::tempdir().unwrap();
        // No process has this id: Linux ends at 2^22.
        let dead = out.path().join(".tmp-clip-99999999");
        fs::create_dir_all(&dead).unwrap();
        drop(ClipFolder::create(out.path(), "clip").unwrap());
        assert_eq!(fs::read_dir(out.path()).unwrap().count(), 0);
    }
}
