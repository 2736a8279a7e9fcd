//! What every stage of a run needs at hand.

use std::{
    error::Error,
    sync::{Mutex, PoisonError, atomic::AtomicBool},
    time::Instant,
};

use super::super::{
    Cache, ClipFailure, ExitCode, Installation, Key, Listener, Stage,
    reporter::{Progress, StageWatch},
};
use crate::session::Document;

/// A run's surroundings.
pub(super) struct Context<'a> {
    pub(super) document: Document,
    pub(super) cache: Cache,
    pub(super) installation: &'a Installation,
    pub(super) listener: &'a dyn Listener,
    pub(super) cancel: &'a AtomicBool,
    pub(super) progress: Progress,
    /// Seconds from the start of each stage to its end; stages that run side by side share them.
    pub(super) timings: Mutex<Vec<(Stage, f64)>>,
}

impl Context<'_> {
    pub(super) fn watch(&self, stage: Stage) -> StageWatch<'_> {
        StageWatch::new(stage, &self.progress, self.listener, self.cancel)
    }

    /// Runs `stage` under its own watch, notes how long it took, and says where a failure happened.
    pub(super) fn stage<T>(
        &self,
        stage: Stage,
        work: impl FnOnce(&StageWatch<'_>) -> Result<T, ClipFailure>,
    ) -> Result<T, ClipFailure> {
        let start = Instant::now();
        self.listener.progress(stage, 0, 1, self.progress.at(stage, 0.0));
        let result = work(&self.watch(stage)).map_err(|failure| failure.in_stage(stage));
        self.progress.at(stage, 1.0);
        let seconds = start.elapsed().as_secs_f64();
        self.timings.lock().unwrap_or_else(PoisonError::into_inner).push((stage, seconds));
        result
    }

    /// As [`Self::stage`], for a stage whose artifact is kept in the cache under the returned key.
    pub(super) fn cached_stage<T, E>(
        &self,
        stage: Stage,
        inputs: &[&Key],
        params: &impl serde::Serialize,
        otherwise: ExitCode,
        work: impl FnOnce(&StageWatch<'_>) -> Result<T, E>,
    ) -> Result<(T, Key), ClipFailure>
    where
        T: serde::Serialize + serde::de::DeserializeOwned,
        E: Error + 'static,
    {
        let key = Key::new(stage, inputs, params)?;
        let artifact = self.stage(stage, |watch| {
            let make = || work(watch).map_err(|error| ClipFailure::from_error(&error, otherwise));
            self.cache.get_or_make(stage, &key, make)
        })?;
        Ok((artifact, key))
    }
}
