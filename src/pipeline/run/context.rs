//! What every stage of a run needs at hand.

use std::{
    error::Error,
    sync::{Arc, Mutex, PoisonError, atomic::AtomicBool},
    time::Instant,
};

use super::super::{
    Cache, ClipFailure, Decisions, ExitCode, Installation, Key, Listener, Memory, Stage,
    reporter::{Progress, StageWatch},
};
use crate::{
    clip::FrameIndex,
    engine::Finding,
    onnx::{CheckedModel, Contract, OnnxError},
    segment::MaskFrame,
    session::{Author, Command, Document, MaskStore},
};

/// A run's surroundings.
pub(super) struct Context<'a> {
    pub(super) document: Document,
    pub(super) masks: MaskStore,
    pub(super) cache: Cache,
    /// What an interactive program kept from the run before.
    pub(super) memory: Option<&'a Memory>,
    pub(super) installation: &'a Installation,
    pub(super) listener: &'a dyn Listener,
    pub(super) cancel: &'a AtomicBool,
    pub(super) progress: Progress,
    /// Whether a model was to be asked for the object and could not be.
    pub(super) unasked: bool,
    /// Seconds from the start of each stage to its end; stages that run side by side share them.
    pub(super) timings: Mutex<Vec<(Stage, f64)>>,
}

impl Context<'_> {
    pub(super) fn watch(&self, stage: Stage) -> StageWatch<'_> {
        StageWatch::new(stage, &self.progress, self.listener, self.cancel)
    }

    /// The model of this installation that keeps `contract`, where one may be used; what is done `instead` of one that
    /// may not is said in one line.
    pub(super) fn model(&self, contract: &Contract, instead: &str) -> Option<CheckedModel> {
        self.installation.model(contract).unwrap_or_else(|error| {
            self.fall_back(&error, instead);
            None
        })
    }

    /// Says that a model failed, and what is done instead.
    pub(super) fn fall_back(&self, error: &OnnxError, instead: &str) {
        self.listener.note(&format!("{error}; instead: {instead}"));
    }

    /// Tells whoever listens of a mask of the object as soon as it is found.
    pub(super) fn tell_mask(&self, index: FrameIndex, mask: &MaskFrame) {
        self.listener.found(Finding::ObjectFrame(index, Box::new(mask.clone())));
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
    ) -> Result<(Arc<T>, Key), ClipFailure>
    where
        T: serde::Serialize + serde::de::DeserializeOwned + Send + Sync + 'static,
        E: Error + 'static,
    {
        let key = Key::new(stage, inputs, params)?;
        if let Some(artifact) = self.memory.and_then(|memory| memory.artifact(stage, &key)) {
            self.progress.at(stage, 1.0);
            return Ok((artifact, key));
        }
        let artifact = self.stage(stage, |watch| {
            let make = || work(watch).map_err(|error| ClipFailure::from_error(&error, otherwise));
            // While somebody moves a slider, a file for every value would be no use.
            if self.memory.is_some() && stage == Stage::Retarget {
                make()
            } else {
                self.cache.get_or_make(stage, &key, make)
            }
        })?;
        let artifact = Arc::new(artifact);
        if let Some(memory) = self.memory {
            memory.keep(stage, &key, &artifact);
        }
        Ok((artifact, key))
    }

    /// A decision of the machine's, for this run and for whoever keeps the session.
    pub(super) fn decide(
        &mut self,
        decisions: &mut dyn Decisions,
        author: Author,
        command: Command,
    ) -> Result<(), ClipFailure> {
        decisions.decide(author, command.clone())?;
        self.document.apply(command).map_err(ClipFailure::bad_input)?;
        Ok(())
    }
}
