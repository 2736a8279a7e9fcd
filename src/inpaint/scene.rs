//! Frames of the clip with everything that plates need, kept while memory allows.

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
};

use opencv::core::{Mat, MatTraitConst};

use super::{
    InpaintError, InpaintParams,
    hole::{blocked_mat, core_mat, hole_mat},
};
use crate::{
    clip::{FrameIndex, FrameSource},
    segment::MaskTrack,
    vision::{View, WorkScale},
};

/// One frame, ready for registration and sampling.
#[derive(Debug)]
pub(super) struct Loaded {
    /// CV_8UC3, RGB, full size.
    pub picture: Mat,
    /// CV_8UC1, full size: what is taken out.
    pub hole: Mat,
    /// CV_8UC1, full size: what does not show the background.
    pub blocked: Mat,
    /// CV_8UC1, full size: object pixels that stay whatever the hand's mask says.
    pub core: Mat,
    /// The background at work scale.
    pub view: View,
}

/// One frame and its masks, CV_8UC3 and CV_8UC1 of full size.
#[derive(Debug)]
pub(super) struct Cut {
    pub picture: Mat,
    pub arm: Mat,
    pub object: Mat,
    /// What is taken out.
    pub hole: Mat,
    /// Object pixels that stay whatever the hand's mask says.
    pub core: Mat,
}

/// One frame at work scale only.
#[derive(Debug)]
pub(super) struct Glance {
    /// CV_8UC1, work size: what is taken out.
    pub hole: Mat,
    /// CV_8UC1, work size: what does not show the background.
    pub blocked: Mat,
    /// The background at work scale.
    pub view: View,
}

/// The clip and its masks.
pub(super) struct Scene<'a> {
    pub frames: &'a dyn FrameSource,
    pub arms: &'a MaskTrack,
    pub object: &'a MaskTrack,
    pub params: &'a InpaintParams,
    pub scale: WorkScale,
    kept: Mutex<BTreeMap<u32, Arc<Loaded>>>,
}

impl<'a> Scene<'a> {
    /// Checks that the masks belong to the clip.
    pub fn new(
        frames: &'a dyn FrameSource,
        arms: &'a MaskTrack,
        object: &'a MaskTrack,
        params: &'a InpaintParams,
    ) -> Result<Self, InpaintError> {
        for (what, track) in [("the arm mask track", arms), ("the object mask track", object)] {
            if track.frames.len() != frames.frame_count() || track.size != frames.size() {
                return Err(InpaintError::Mismatch {
                    what,
                    found: track.frames.len(),
                    found_size: track.size,
                    expected: frames.frame_count(),
                    expected_size: frames.size(),
                });
            }
        }
        let scale = WorkScale::fit(frames.size(), params.work_side);
        Ok(Self { frames, arms, object, params, scale, kept: Mutex::default() })
    }

    pub fn frame_count(&self) -> usize {
        self.frames.frame_count()
    }

    /// Reads frame `index` at work scale, without keeping it: much cheaper than [`Self::load`].
    pub fn glance(&self, index: usize) -> Result<Glance, InpaintError> {
        let index = FrameIndex(index as u32);
        let colour = self.scale.shrink(&self.frames.frame(index)?.to_mat()?)?;
        let arm = self.scale.shrink_mask(&self.arms.frame(index).mask.decode().to_mat()?)?;
        let object = self.scale.shrink_mask(&self.object.frame(index).mask.decode().to_mat()?)?;
        let hole = hole_mat(&arm, &core_mat(&object, self.params)?, self.params)?;
        let blocked = blocked_mat(&arm, &object, self.params)?;
        let view = View::new(WorkScale { full: self.scale.work, work: self.scale.work }, &colour, &blocked)?;
        Ok(Glance { hole, blocked, view })
    }

    /// Reads frame `index` without keeping it.
    pub fn read(&self, index: usize) -> Result<Loaded, InpaintError> {
        let Cut { picture, arm, object, hole, core } = self.cut(index)?;
        let blocked = blocked_mat(&arm, &object, self.params)?;
        let view = View::new(self.scale, &picture, &blocked)?;
        Ok(Loaded { picture, hole, blocked, core, view })
    }

    /// Frame `index` and what is taken out of it, without what registration needs: much cheaper than [`Self::read`].
    pub fn cut(&self, index: usize) -> Result<Cut, InpaintError> {
        let index = FrameIndex(index as u32);
        let picture = self.frames.frame(index)?.to_mat()?;
        let arm = self.arms.frame(index).mask.decode().to_mat()?;
        let object = self.object.frame(index).mask.decode().to_mat()?;
        let core = core_mat(&object, self.params)?;
        let hole = hole_mat(&arm, &core, self.params)?;
        Ok(Cut { picture, arm, object, hole, core })
    }

    /// Frame `index`, read or kept; the frame farthest from it gives way when memory is short.
    pub fn load(&self, index: usize) -> Result<Arc<Loaded>, InpaintError> {
        let wanted = index as u32;
        if let Some(loaded) = self.kept().get(&wanted) {
            return Ok(loaded.clone());
        }
        let loaded = Arc::new(self.read(index)?);
        let mut kept = self.kept();
        let each = loaded.picture.total() * 6 + loaded.view.gray.total() * 6;
        let room = (self.params.cache_mib << 20).checked_div(each).unwrap_or(1).max(2);
        while kept.len() >= room {
            let farthest = kept.keys().copied().max_by_key(|key| key.abs_diff(wanted));
            let Some(farthest) = farthest else { break };
            kept.remove(&farthest);
        }
        kept.insert(wanted, loaded.clone());
        Ok(loaded)
    }

    fn kept(&self) -> std::sync::MutexGuard<'_, BTreeMap<u32, Arc<Loaded>>> {
        // The map is a cache of immutable values: a panic elsewhere cannot leave it half-made.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
