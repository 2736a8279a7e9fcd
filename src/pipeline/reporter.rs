//! What a run tells its listener.

use std::{
    collections::BTreeMap,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use super::Stage;
use crate::{
    engine::{Finding, ModelUse},
    progress::Watch,
};

/// Hears how a clip goes on.
pub trait Listener: Sync {
    /// `stage` has done `done` of `total` steps; `share` of the whole clip is done.
    fn progress(&self, stage: Stage, done: usize, total: usize, share: f64);

    /// Something worth a line in the log.
    fn note(&self, text: &str);

    /// Something was found out about the clip. A batch only writes results, so nothing happens by default.
    fn found(&self, _finding: Finding) {}

    /// How it stands with a learned model: why it is done without, in one line; `None` where nothing is wrong. A batch
    /// says it once, as a note, so nothing more happens by default.
    fn model(&self, _purpose: ModelUse, _fault: Option<&str>) {}

    /// Whether every object mask is to be told as it is made, which costs time.
    fn wants_every_mask(&self) -> bool {
        false
    }
}

/// At most this often a stage's progress is passed on.
const INTERVAL: Duration = Duration::from_millis(200);

/// How far every stage of a clip is.
#[derive(Debug, Default)]
pub(super) struct Progress(Mutex<BTreeMap<Stage, f64>>);

impl Progress {
    /// Notes that `part` (0 to 1) of `stage` is done; answers the share of the whole clip's work that is.
    pub(super) fn at(&self, stage: Stage, part: f64) -> f64 {
        let mut parts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        parts.insert(stage, part);
        let done = |other: Stage| {
            // A stage before this one that never spoke was not needed.
            let skipped = other < stage && !other.runs_beside(stage);
            parts.get(&other).copied().unwrap_or(if skipped { 1.0 } else { 0.0 })
        };
        let share: f64 = Stage::SHARES.iter().map(|(other, share)| share * done(*other)).sum();
        share.clamp(0.0, 1.0)
    }
}

/// Watches one stage for a [`Listener`].
pub(super) struct StageWatch<'a> {
    stage: Stage,
    progress: &'a Progress,
    listener: &'a dyn Listener,
    cancel: &'a AtomicBool,
    spoke: Mutex<Option<Instant>>,
}

impl<'a> StageWatch<'a> {
    pub(super) fn new(
        stage: Stage,
        progress: &'a Progress,
        listener: &'a dyn Listener,
        cancel: &'a AtomicBool,
    ) -> Self {
        Self { stage, progress, listener, cancel, spoke: Mutex::new(None) }
    }
}

impl Watch for StageWatch<'_> {
    fn advance(&self, done: usize, total: usize) {
        let mut spoke = self.spoke.lock().unwrap_or_else(PoisonError::into_inner);
        if spoke.is_none_or(|last| last.elapsed() >= INTERVAL) {
            *spoke = Some(Instant::now());
            let part = done as f64 / total.max(1) as f64;
            self.listener.progress(self.stage, done, total, self.progress.at(self.stage, part));
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_side_by_side_add_up_and_those_left_out_count_once_passed() {
        let progress = Progress::default();
        let share = |stage| Stage::SHARES.iter().find(|(other, _)| *other == stage).map_or(0.0, |s| s.1);
        let before: f64 = Stage::SHARES.iter().take_while(|s| s.0 < Stage::Template).map(|s| s.1).sum();
        assert!((progress.at(Stage::Hands, 1.0) - before - share(Stage::Hands)).abs() < 1e-9);
        let both = before + share(Stage::Hands) + 0.5 * share(Stage::Template);
        assert!((progress.at(Stage::Template, 0.5) - both).abs() < 1e-9);
        assert!((progress.at(Stage::Export, 1.0) + 0.5 * share(Stage::Template) - 1.0).abs() < 1e-9);
        progress.at(Stage::Template, 1.0);
        assert!((progress.at(Stage::Export, 1.0) - 1.0).abs() < 1e-9);
    }
}
