//! What every stage of a run needs at hand.

use std::{
    cell::RefCell,
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
    engine::{Finding, ModelUse},
    onnx::{CheckedModel, Contract, OnnxError},
    segment::MaskFrame,
    session::{Author, Command, Document, MaskStore},
};

/// What a model broke down on, out of the errors of a stage.
#[derive(Debug, Default)]
pub(super) struct ModelFault(RefCell<Option<OnnxError>>);

impl ModelFault {
    /// Notes a fault of the model; the stage's own faults are none.
    pub(super) fn note(&self, fault: Option<&OnnxError>) {
        *self.0.borrow_mut() = fault.cloned();
    }
}

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

    /// What `work` makes with the model of this installation that keeps `contract`; `None` where there is none, and where
    /// it may not be used or `work` left a fault, which is said in one line with what is done instead. A model that broke
    /// down is left alone while the clip is open: a window comes here at every change.
    pub(super) fn with_model<T, E>(
        &self,
        contract: &Contract,
        purpose: ModelUse,
        work: impl FnOnce(&CheckedModel, &ModelFault) -> Result<T, E>,
    ) -> Result<Option<T>, E> {
        let model = match self.installation.model(contract) {
            Ok(Some(model)) => model,
            Ok(None) => {
                self.listener.model(purpose, None);
                return Ok(None);
            }
            Err(error) => return Ok(self.fall_back(&error, purpose)),
        };
        if let Some(error) = self.memory.and_then(|memory| memory.broken_model(purpose)) {
            return Ok(self.fall_back(&error, purpose));
        }
        let fault = ModelFault::default();
        match (work(&model, &fault), fault.0.take()) {
            (Err(_), Some(error)) => {
                if let Some(memory) = self.memory {
                    memory.keep_broken_model(purpose, error.clone());
                }
                Ok(self.fall_back(&error, purpose))
            }
            (made, _) => {
                if made.is_ok() {
                    self.listener.model(purpose, None);
                }
                made.map(Some)
            }
        }
    }

    fn fall_back<T>(&self, error: &OnnxError, purpose: ModelUse) -> Option<T> {
        let line = format!("{error}; instead: {}", purpose.instead());
        self.say(purpose.instead(), &line);
        self.listener.model(purpose, Some(&line));
        None
    }

    /// Says a line about `topic`, unless a window was told the very same one last: every change of a document comes
    /// to it again.
    pub(super) fn say(&self, topic: &'static str, line: &str) {
        if self.memory.is_none_or(|memory| memory.is_news(topic, line)) {
            self.listener.note(line);
        }
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
