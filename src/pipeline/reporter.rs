//! What a run tells its listener.

use std::{
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use super::Stage;
use crate::progress::Watch;

/// Hears how a clip goes on.
pub trait Listener: Sync {
    /// `stage` has done `done` of `total` steps; `share` of the whole clip is done.
    fn progress(&self, stage: Stage, done: usize, total: usize, share: f64);

    /// Something worth a line in the log.
    fn note(&self, text: &str);
}

/// At most this often a stage's progress is passed on.
const INTERVAL: Duration = Duration::from_millis(200);

/// Watches one stage for a [`Listener`].
pub(super) struct StageWatch<'a> {
    stage: Stage,
    listener: &'a dyn Listener,
    cancel: &'a AtomicBool,
    spoke: Mutex<Option<Instant>>,
}

impl<'a> StageWatch<'a> {
    pub(super) fn new(stage: Stage, listener: &'a dyn Listener, cancel: &'a AtomicBool) -> Self {
        Self { stage, listener, cancel, spoke: Mutex::new(None) }
    }
}

impl Watch for StageWatch<'_> {
    fn advance(&self, done: usize, total: usize) {
        let mut spoke = self.spoke.lock().unwrap_or_else(PoisonError::into_inner);
        if spoke.is_none_or(|last| last.elapsed() >= INTERVAL) {
            *spoke = Some(Instant::now());
            let part = done as f64 / total.max(1) as f64;
            self.listener.progress(self.stage, done, total, self.stage.overall(part));
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}
