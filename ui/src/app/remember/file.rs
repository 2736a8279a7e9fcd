//! The file that holds what is remembered.

use std::{
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
};

use agenticfocus::session::write_durably;
use serde::{Deserialize, Serialize};

use super::recent::Recent;
use crate::{
    state::{BeforeAfter, Options, PlaySpeed},
    theme::ThemeChoice,
};

/// The file's format that this build writes and the newest that it reads.
const VERSION: u32 = 1;

/// Where the window's file lies by the XDG base directories: `config` is `$XDG_CONFIG_HOME`, which counts only
/// where it is absolute, `home` is `$HOME`. `None` where neither says.
pub fn window_file(config: Option<OsString>, home: Option<OsString>) -> Option<PathBuf> {
    let absolute = |text: OsString| Some(PathBuf::from(text)).filter(|path| path.is_absolute());
    let folder = config.and_then(absolute).or_else(|| Some(home.and_then(absolute)?.join(".config")))?;
    Some(folder.join("agenticfocus").join("window.json"))
}

/// What is remembered. What a file lacks is as in a window that was never opened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Remembered {
    version: u32,
    theme: ThemeChoice,
    zoom: f32,
    queue_open: bool,
    inspector_open: bool,
    brush_radius: f32,
    mask_opacity: f32,
    grow_by: u32,
    speed: PlaySpeed,
    plot: usize,
    before_after: BeforeAfter,
    recent: Vec<String>,
}

impl Default for Remembered {
    fn default() -> Self {
        Self::of(&Options::default(), true, &Recent::default())
    }
}

/// Why nothing could be read.
#[derive(Debug)]
pub(super) enum Unread {
    /// Nothing was written yet.
    Missing,
    /// It cannot be read or is no such file; the text says why.
    Damaged(String),
    /// A newer program wrote it.
    Newer(u32),
}

impl Remembered {
    /// What of `options` outlives the window; `queue_open` is what the operator chose, not what the room allowed.
    pub(super) fn of(options: &Options, queue_open: bool, recent: &Recent) -> Self {
        Self {
            version: VERSION,
            theme: options.theme,
            zoom: options.zoom,
            queue_open,
            inspector_open: options.inspector_open,
            brush_radius: options.brush_radius,
            mask_opacity: options.mask_opacity,
            grow_by: options.grow_by,
            speed: options.speed,
            plot: options.plot,
            before_after: options.before_after,
            // A path that is no text cannot be kept in JSON.
            recent: recent.paths().iter().filter_map(|path| path.to_str().map(str::to_owned)).collect(),
        }
    }

    /// Takes it up; numbers that no control allows are brought into its range.
    pub(super) fn apply(&self, options: &mut Options, recent: &mut Recent) {
        options.theme = self.theme;
        options.zoom = self.zoom.clamp(0.6, 2.5);
        options.queue_open = self.queue_open;
        options.inspector_open = self.inspector_open;
        options.brush_radius = self.brush_radius.clamp(0.5, 300.0);
        options.mask_opacity = self.mask_opacity.clamp(0.0, 1.0);
        options.grow_by = self.grow_by.clamp(1, 50);
        options.speed = self.speed;
        options.plot = self.plot;
        options.before_after = match self.before_after {
            BeforeAfter::Wipe(at) => BeforeAfter::Wipe(at.clamp(0.05, 0.95)),
            other => other,
        };
        *recent = Recent::new(self.recent.iter().map(PathBuf::from));
    }

    pub(super) fn read(file: &Path) -> Result<Self, Unread> {
        /// All that files of every version have in common.
        #[derive(Deserialize)]
        struct Head {
            version: u32,
        }
        let text = match fs::read_to_string(file) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Err(Unread::Missing),
            Err(error) => return Err(Unread::Damaged(error.to_string())),
        };
        let damaged = |error: serde_json::Error| Unread::Damaged(error.to_string());
        let head: Head = serde_json::from_str(&text).map_err(damaged)?;
        if head.version > VERSION {
            return Err(Unread::Newer(head.version));
        }
        serde_json::from_str(&text).map_err(damaged)
    }

    pub(super) fn write(&self, file: &Path) -> io::Result<()> {
        if let Some(folder) = file.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut text = serde_json::to_string_pretty(self).map_err(io::Error::other)?;
        text.push('\n');
        write_durably(file, text.as_bytes())
    }
}
