//! What an interactive program keeps between runs of the same clip: nothing is decoded or read twice.

use std::{
    any::{Any, TypeId},
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
};

use super::{Key, Stage};
use crate::{
    clip::{ClipRequest, StandardClip},
    robot::RobotModel,
};

/// An artifact of any type, by the key of what went into it.
type Kept = (Key, Arc<dyn Any + Send + Sync>);

/// The newest artifact of every type that a stage has, and the decoded clip.
#[derive(Debug, Default)]
pub struct Memory {
    clip: Mutex<Option<(ClipRequest, Arc<StandardClip>)>>,
    artifacts: Mutex<BTreeMap<(Stage, TypeId), Kept>>,
    robot: Mutex<Option<RobotModel>>,
}

impl Memory {
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
