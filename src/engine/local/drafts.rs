//! Masks from points while a person clicks, on one frame alone.

use std::sync::Arc;

use super::scene::{DraftWish, Shared};
use crate::{
    clip::{FrameIndex, FrameSource as _, StandardClip},
    engine::{Drafted, Event, ModelUse},
    onnx::OnnxError,
    progress::Unwatched,
    segment::{
        RleMask, SegmentError,
        object::{self, ObjectParams, ObjectPrompt, PromptKind},
        sam2::{EncodedPicture, ImageSegmenter, SAM2_IMAGE},
    },
};

/// The network for clicks, and the picture it saw last: the second click on a frame is answered much faster.
#[derive(Debug, Default)]
pub(super) struct Drafts {
    /// Looked for when first needed; `Some(None)` where there is none or it failed.
    network: Option<Option<ImageSegmenter>>,
    seen: Option<(Arc<StandardClip>, FrameIndex, EncodedPicture)>,
}

impl Drafts {
    /// The mask of what the points lie on: by the network where one is active, else by colours and cuts.
    pub(super) fn mask(
        &mut self,
        shared: &Shared,
        clip: &Arc<StandardClip>,
        wish: &DraftWish,
    ) -> Result<Drafted, String> {
        let kind = PromptKind::Points { positive: wish.positive.clone(), negative: wish.negative.clone() };
        let prompt = ObjectPrompt::new(wish.frame, kind);
        match self.by_network(shared, clip, &prompt) {
            Some(Err(SegmentError::Network(error))) => self.give_up(shared, &error),
            Some(mask) => {
                shared.tell(Event::Model { purpose: ModelUse::PointMasks, fault: None });
                let backend = self.network_name().unwrap_or_default().to_owned();
                return mask.map(|mask| drafted(mask, backend)).map_err(|error| error.to_string());
            }
            None => {}
        }
        let arms = shared.scene().filter(|_| wish.arms_matter).map(|scene| Arc::clone(&scene.found.arms));
        let arms = arms.map(|arms| arms.union.frame(wish.frame).mask.clone());
        object::segment_frame(&**clip, &prompt, arms, &ObjectParams::default(), &Unwatched)
            .map(|mask| drafted(mask, object::BACKEND.to_owned()))
            .map_err(|error| error.to_string())
    }

    fn network_name(&self) -> Option<&str> {
        Some(self.network.as_ref()?.as_ref()?.name())
    }

    /// `None` where no network is active.
    fn by_network(
        &mut self,
        shared: &Shared,
        clip: &Arc<StandardClip>,
        prompt: &ObjectPrompt,
    ) -> Option<Result<RleMask, SegmentError>> {
        if self.network.is_none() {
            match open(shared) {
                Ok(network) => self.network = Some(network),
                Err(error) => return Some(Err(error.into())),
            }
        }
        let network = self.network.as_mut()?.as_mut()?;
        let known = self.seen.as_ref();
        let known = known.is_some_and(|(of, frame, _)| Arc::ptr_eq(of, clip) && *frame == prompt.frame);
        if !known {
            let picture = clip.frame(prompt.frame).map_err(SegmentError::from);
            let seen = picture.and_then(|picture| network.encode(&picture.to_mat()?));
            match seen {
                Ok(seen) => self.seen = Some((Arc::clone(clip), prompt.frame, seen)),
                Err(error) => return Some(Err(error)),
            }
        }
        let (_, _, seen) = self.seen.as_ref()?;
        Some(network.mask(seen, prompt))
    }

    /// Says once why the network is not used any more.
    fn give_up(&mut self, shared: &Shared, error: &OnnxError) {
        *self = Self { network: Some(None), seen: None };
        let line = format!("{error}; instead: {}", ModelUse::PointMasks.instead());
        shared.tell(Event::Note(line.clone()));
        shared.tell(Event::Model { purpose: ModelUse::PointMasks, fault: Some(line) });
    }
}

fn drafted(mask: RleMask, backend: String) -> Drafted {
    Drafted { mask: Arc::new(mask), backend }
}

/// The active network for clicks, where there is one.
fn open(shared: &Shared) -> Result<Option<ImageSegmenter>, OnnxError> {
    let Some(model) = shared.installation.model(&SAM2_IMAGE)? else { return Ok(None) };
    ImageSegmenter::open(&shared.installation.runtime()?, &model).map(Some)
}
