//! What the window remembers between starts: theme, panels, sizes, recent files. No part of any session.

mod file;
mod recent;

use std::{
    path::PathBuf,
    sync::mpsc,
    thread::JoinHandle,
    time::{Duration, Instant},
};

use super::OperatorApp;
use file::{Remembered, Unread};

pub use file::window_file;
pub(super) use recent::Recent;

/// How long things stay as they are before they are written: a slider that is dragged is one change.
const REST: Duration = Duration::from_secs(1);

/// Keeps what is remembered in its file, on a thread of its own; what is not yet there is written at the end.
#[derive(Debug)]
pub(super) struct Memory {
    /// As the window is now, and since when.
    seen: Remembered,
    since: Instant,
    /// What was sent to be written, or was read.
    sent: Remembered,
    /// Gone when the window ends.
    writer: Option<(mpsc::Sender<Remembered>, JoinHandle<()>)>,
    faults: mpsc::Receiver<String>,
}

impl Memory {
    fn start(file: PathBuf, read: Remembered) -> std::io::Result<Self> {
        let (sender, receiver) = mpsc::channel::<Remembered>();
        let (faulty, faults) = mpsc::channel();
        let write = move || {
            while let Ok(first) = receiver.recv() {
                // Only the newest counts.
                let newest = receiver.try_iter().last().unwrap_or(first);
                if let Err(error) = newest.write(&file) {
                    // Nobody listens any more when the window has ended.
                    faulty.send(format!("{}: {error}", file.display())).ok();
                }
            }
        };
        let thread = std::thread::Builder::new().name("remember".to_owned()).spawn(write)?;
        Ok(Self {
            seen: read.clone(),
            since: Instant::now(),
            sent: read,
            writer: Some((sender, thread)),
            faults,
        })
    }

    /// Notes how the window is `now`; answers when to come back, where something waits to be written.
    fn note(&mut self, now: Remembered) -> Option<Duration> {
        if now != self.seen {
            self.seen = now;
            self.since = Instant::now();
        }
        if self.seen == self.sent {
            return None;
        }
        let left = REST.saturating_sub(self.since.elapsed());
        if left.is_zero() {
            self.send();
            return None;
        }
        Some(left)
    }

    fn send(&mut self) {
        if let Some((writer, _)) = &self.writer {
            // The thread lives as long as the sender; were it gone, the fault was told.
            writer.send(self.seen.clone()).ok();
        }
        self.sent = self.seen.clone();
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        if self.seen != self.sent {
            self.send();
        }
        if let Some((sender, thread)) = self.writer.take() {
            drop(sender);
            // A writer that panicked has nothing left to write.
            thread.join().ok();
        }
    }
}

impl OperatorApp {
    /// Takes up what `file` remembers of the last start, and keeps it there from now on. What cannot be read is
    /// mentioned, and is as in a window that was never opened; what a newer program wrote stays untouched.
    #[must_use]
    pub fn remembering(mut self, file: PathBuf) -> Self {
        let read = Remembered::read(&file);
        match &read {
            Ok(remembered) => remembered.apply(&mut self.options, &mut self.recent),
            Err(Unread::Missing) => {}
            Err(Unread::Damaged(why)) => {
                self.mention(&format!("Theme, sizes and recent files begin anew: {}: {why}", file.display()));
            }
            Err(Unread::Newer(version)) => {
                self.mention(&format!(
                    "Theme, sizes and recent files are not kept: {} is of format {version}, which a newer \
                     version of this program wrote",
                    file.display()
                ));
                return self;
            }
        }
        let remembered = Remembered::of(&self.options, self.options.queue_open, &self.recent);
        match Memory::start(file, remembered) {
            Ok(memory) => self.memory = Some(memory),
            Err(error) => self.mention(&format!("Theme, sizes and recent files are not kept: {error}")),
        }
        self
    }

    /// Offers a session to try the window with.
    #[must_use]
    pub fn offering_demo(mut self, session: Option<PathBuf>) -> Self {
        self.demo = session;
        self
    }

    /// Files that were opened, the newest first.
    pub fn recent(&self) -> &[PathBuf] {
        self.recent.paths()
    }

    /// Writes what changed, once it stays as it is.
    pub(super) fn remember(&mut self, ctx: &egui::Context) {
        let queue_open = self.shell.queue_wanted(&self.options);
        let now = Remembered::of(&self.options, queue_open, &self.recent);
        let Some(memory) = &mut self.memory else { return };
        if let Some(left) = memory.note(now) {
            ctx.request_repaint_after(left);
        }
        if let Ok(fault) = memory.faults.try_recv() {
            // Told once: the next change would fail likewise.
            self.memory = None;
            self.mention(&format!("Theme, sizes and recent files are not kept: {fault}"));
        }
    }

    /// Writes what is not yet written, and ends the writing; waits for the disk, so only for the end.
    pub fn close(&mut self) {
        self.memory = None;
    }
}
