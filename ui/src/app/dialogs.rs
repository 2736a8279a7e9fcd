//! Asking the operator for files, with the system's own dialogs.

use std::{
    path::{Path, PathBuf},
    sync::mpsc,
};

/// What a path is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A clip or manifest to open.
    OpenFile,
    /// A folder to open as the queue, or a session.
    OpenFolder,
    /// A new folder for the session.
    SaveElsewhere,
}

/// Asks for paths without holding up the window.
pub trait Dialogs {
    /// Shows a dialog; an earlier one that was not answered is forgotten.
    fn ask(&mut self, purpose: Purpose, start: Option<&Path>);

    /// The answer, once there is one.
    fn answer(&mut self) -> Option<(Purpose, PathBuf)>;
}

/// The system's dialogs, on a thread of their own.
#[derive(Debug, Default)]
pub struct NativeDialogs {
    waiting: Option<mpsc::Receiver<(Purpose, PathBuf)>>,
}

impl Dialogs for NativeDialogs {
    fn ask(&mut self, purpose: Purpose, start: Option<&Path>) {
        let (sender, receiver) = mpsc::channel();
        let start = start.map(Path::to_owned);
        let shown = std::thread::Builder::new().name("dialog".to_owned()).spawn(move || {
            let mut dialog = rfd::FileDialog::new();
            if let Some(start) = start {
                dialog = dialog.set_directory(start);
            }
            let path = match purpose {
                Purpose::OpenFile => dialog.set_title("Open a clip or a manifest").pick_file(),
                Purpose::OpenFolder => dialog.set_title("Open a folder of clips, or a session").pick_folder(),
                Purpose::SaveElsewhere => {
                    dialog.set_title("Keep the session in an empty folder").pick_folder()
                }
            };
            // Nobody waits any more when another dialog was asked for.
            if let Some(path) = path {
                sender.send((purpose, path)).ok();
            }
        });
        self.waiting = shown.is_ok().then_some(receiver);
    }

    fn answer(&mut self) -> Option<(Purpose, PathBuf)> {
        let answer = self.waiting.as_ref()?.try_recv().ok()?;
        self.waiting = None;
        Some(answer)
    }
}
