//! What an interactive program keeps between runs of the same clip: nothing is decoded or read twice.

use std::{
    any::{Any, TypeId},
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
};

use super::{Key, Stage};
use crate::{
    clip::{ClipRequest, StandardClip},
    engine::ModelUse,
    onnx::OnnxError,
    robot::RobotModel,
    session::{FreshMasks, ObjectAnswer},
};

/// An artifact of any type, by the key of what went into it.
type Kept = (Key, Arc<dyn Any + Send + Sync>);

/// The newest artifact of every type that a stage has, and the decoded clip.
#[derive(Debug, Default)]
pub struct Memory {
    clip: Mutex<Option<(ClipRequest, Arc<StandardClip>)>>,
    artifacts: Mutex<BTreeMap<(Stage, TypeId), Kept>>,
    robot: Mutex<Option<RobotModel>>,
    model_word: Mutex<Option<(String, ModelWord)>>,
    told: Mutex<BTreeMap<&'static str, String>>,
    broken: Mutex<BTreeMap<ModelUse, OnnxError>>,
    masks: FreshMasks,
}

/// What a vision-language model answered, or why it was not asked.
type ModelWord = Result<ObjectAnswer, String>;

impl Memory {
    /// Masks that a person made and that are being written: a run does not wait for the disk.
    pub fn masks(&self) -> &FreshMasks {
        &self.masks
    }

    /// The clip that was decoded for this very request.
    pub(super) fn clip(&self, request: &ClipRequest) -> Option<Arc<StandardClip>> {
        let clip = self.clip.lock().unwrap_or_else(PoisonError::into_inner);
        clip.as_ref().filter(|(known, _)| known == request).map(|(_, clip)| Arc::clone(clip))
    }

    /// The clip that was decoded last.
    pub fn latest_clip(&self) -> Option<Arc<StandardClip>> {
        let clip = self.clip.lock().unwrap_or_else(PoisonError::into_inner);
        clip.as_ref().map(|(_, clip)| Arc::clone(clip))
    }

    /// The robot in use, loaded once: reading a model takes longer than moving it.
    pub(super) fn robot<E>(&self, load: impl FnOnce() -> Result<RobotModel, E>) -> Result<RobotModel, E> {
        let mut robot = self.robot.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(robot) = &*robot {
            return Ok(robot.clone());
        }
        Ok(robot.insert(load()?).clone())
    }

    /// Keeps a decoded clip, and forgets the one before it.
    pub(super) fn keep_clip(&self, request: ClipRequest, clip: &Arc<StandardClip>) {
        *self.clip.lock().unwrap_or_else(PoisonError::into_inner) = Some((request, Arc::clone(clip)));
    }

    /// What came of this very question to a model: asked in vain, it is not asked again at every change.
    pub(super) fn model_word(&self, question: &str) -> Option<ModelWord> {
        let word = self.model_word.lock().unwrap_or_else(PoisonError::into_inner);
        word.as_ref().filter(|(known, _)| known == question).map(|(_, word)| word.clone())
    }

    /// Keeps what came of a question to a model, and forgets the one before it.
    pub(super) fn keep_model_word(&self, question: String, word: ModelWord) {
        *self.model_word.lock().unwrap_or_else(PoisonError::into_inner) = Some((question, word));
    }

    /// What the model for `purpose` broke down on.
    pub(super) fn broken_model(&self, purpose: ModelUse) -> Option<OnnxError> {
        self.broken.lock().unwrap_or_else(PoisonError::into_inner).get(&purpose).cloned()
    }

    /// Keeps what the model for `purpose` broke down on.
    pub(super) fn keep_broken_model(&self, purpose: ModelUse, error: OnnxError) {
        self.broken.lock().unwrap_or_else(PoisonError::into_inner).insert(purpose, error);
    }

    /// Whether `line` is another one than the last about `topic`: every change of a document comes to it again.
    pub(super) fn is_news(&self, topic: &'static str, line: &str) -> bool {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        told.insert(topic, line.to_owned()).is_none_or(|last| last != line)
    }

    /// The artifact of `stage`, if it is the one that `key` names.
    pub(super) fn artifact<T: Any + Send + Sync>(&self, stage: Stage, key: &Key) -> Option<Arc<T>> {
        let artifacts = self.artifacts.lock().unwrap_or_else(PoisonError::into_inner);
        let (known, artifact) = artifacts.get(&(stage, TypeId::of::<T>()))?;
        if known == key { Arc::clone(artifact).downcast().ok() } else { None }
    }

    /// Keeps the artifact of `stage`, and forgets the one of its type before it.
    pub(super) fn keep<T: Any + Send + Sync>(&self, stage: Stage, key: &Key, artifact: &Arc<T>) {
        let artifact: Arc<dyn Any + Send + Sync> = Arc::<T>::clone(artifact);
        let mut artifacts = self.artifacts.lock().unwrap_or_else(PoisonError::into_inner);
        artifacts.insert((stage, TypeId::of::<T>()), (key.clone(), artifact));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_artifact_that_the_key_names_comes_back() {
        let memory = Memory::default();
        let (one, two) = (Key::new(Stage::Arms, &[], &1).unwrap(), Key::new(Stage::Arms, &[], &2).unwrap());
        memory.keep(Stage::Arms, &one, &Arc::new(5_i32));
        assert_eq!(memory.artifact::<i32>(Stage::Arms, &one).as_deref(), Some(&5));
        assert!(memory.artifact::<i32>(Stage::Arms, &two).is_none());
        assert!(memory.artifact::<i32>(Stage::Object, &one).is_none());
        assert!(memory.artifact::<String>(Stage::Arms, &one).is_none());
    }
}
