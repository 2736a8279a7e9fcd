//! Object masks: by a network where one is active, else by flow, colours and cuts.

use std::{collections::BTreeMap, sync::Arc};

use super::{context::Context, edits::human_masks};
use crate::{
    clip::{FrameIndex, FrameSource as _, StandardClip},
    engine::ModelUse,
    landmarks::LandmarkTrack,
    pipeline::{ClipFailure, ExitCode, Key, Stage},
    progress::Watch,
    segment::{
        MaskAuthor, MaskFlag, MaskFrame, MaskTrack, RleMask, SegmentError,
        arms::ArmTrack,
        object::{self, ObjectParams, ObjectPrompt, PromptKind},
        sam2::{self, ImageSegmenter, SAM2_IMAGE, SAM2_VIDEO, VideoSegmenter},
    },
    session::{Author, Document, MaskLayer, ObjectChoice, ObjectPromptKind},
};

/// Object masks; all empty and lost where nobody knows what the object is.
pub(super) fn object(
    context: &Context<'_>,
    clip: &StandardClip,
    choice: Option<&ObjectChoice>,
    landmarks: &LandmarkTrack,
    arms: (&ArmTrack, &Key),
) -> Result<(Arc<MaskTrack>, Key), ClipFailure> {
    let human =
        human_masks(&context.document, &context.masks, MaskLayer::Object, clip.size(), clip.frame_count())?;
    let guessed = choice.is_some_and(|choice| matches!(choice.author, Author::Machine(_)));
    let prompts = prompts(&context.document, choice, human);
    if let Some(track) = object_by_network(context, clip, &prompts, arms)? {
        return Ok(track);
    }
    let params = ObjectParams::default();
    context.cached_stage(Stage::Object, &[arms.1], &(&params, &prompts), ExitCode::BadInput, |watch| {
        if prompts.is_empty() {
            return Ok(nothing(clip));
        }
        let tell = |index: FrameIndex, mask: &MaskFrame| context.tell_mask(index, mask);
        let sink: Option<&object::MaskSink<'_>> = context.listener.wants_every_mask().then_some(&tell);
        match object::track_object(clip, &prompts, &arms.0.union, landmarks, &params, sink, watch) {
            // A guess of our own that leads nowhere is no fault of the input: the clip goes on without an object.
            Err(SegmentError::Prompt { reason, .. }) if guessed => {
                context
                    .listener
                    .note(&format!("the proposed object cannot be told from its surroundings: {reason}"));
                Ok(nothing(clip))
            }
            other => other,
        }
    })
}

/// Object masks by a network with a memory; `None` where none is active, nobody knows what the object is, or it failed,
/// which is said in one line.
fn object_by_network(
    context: &Context<'_>,
    clip: &StandardClip,
    prompts: &[ObjectPrompt],
    arms: (&ArmTrack, &Key),
) -> Result<Option<(Arc<MaskTrack>, Key)>, ClipFailure> {
    if prompts.is_empty() {
        return Ok(None);
    }
    context.with_model(&SAM2_VIDEO, ModelUse::ObjectMasks, |model, fault| {
        let params = ObjectParams::default();
        let inputs = (&params, prompts, model.identity());
        context.cached_stage(Stage::Object, &[arms.1], &inputs, ExitCode::BadInput, |watch| {
            let tell = |index: FrameIndex, mask: &MaskFrame| context.tell_mask(index, mask);
            let sink: Option<&object::MaskSink<'_>> = context.listener.wants_every_mask().then_some(&tell);
            let mut by_hand =
                |prompt: &ObjectPrompt| mask_of_prompt(context, clip, prompt, arms.0, &params, watch);
            let network =
                context.installation.runtime().and_then(|runtime| VideoSegmenter::open(&runtime, model));
            let track = network.map_err(SegmentError::from).and_then(|mut network| {
                sam2::track_object(clip, prompts, &mut network, &mut by_hand, sink, watch)
            });
            track.inspect_err(|error| fault.note(error.of_model()))
        })
    })
}

/// The arms without what the object was found to be.
pub(super) fn arms_without(
    context: &Context<'_>,
    arms: (&Arc<ArmTrack>, &Key),
    object: (&MaskTrack, &Key),
) -> Result<(Arc<ArmTrack>, Key), ClipFailure> {
    let key = Key::new(Stage::Object, &[arms.1, object.1], &"arms")?;
    let kept = context.memory.and_then(|memory| memory.artifact::<ArmTrack>(Stage::Object, &key));
    let made = kept.unwrap_or_else(|| Arc::new(arms.0.without(object.0)));
    if let Some(memory) = context.memory {
        memory.keep(Stage::Object, &key, &made);
    }
    Ok((made, key))
}

/// The mask that a prompt means on its own frame: by a network where one is active.
fn mask_of_prompt(
    context: &Context<'_>,
    clip: &StandardClip,
    prompt: &ObjectPrompt,
    arms: &ArmTrack,
    params: &ObjectParams,
    watch: &dyn Watch,
) -> Result<RleMask, SegmentError> {
    let mask = context.with_model(&SAM2_IMAGE, ModelUse::PointMasks, |model, fault| {
        let network =
            context.installation.runtime().and_then(|runtime| ImageSegmenter::open(&runtime, model));
        let mask = network
            .map_err(SegmentError::from)
            .and_then(|mut network| sam2::segment_frame(clip, prompt, &mut network));
        mask.inspect_err(|error| fault.note(error.of_model()))
    })?;
    if let Some(mask) = mask {
        return Ok(mask);
    }
    let arms = arms.union.frame(prompt.frame).mask.clone();
    object::segment_frame(clip, prompt, Some(arms), params, watch)
}

fn prompts(
    document: &Document,
    choice: Option<&ObjectChoice>,
    human: BTreeMap<FrameIndex, RleMask>,
) -> Vec<ObjectPrompt> {
    let chosen = choice.filter(|choice| !human.contains_key(&choice.frame)).map(|choice| {
        let kind = match choice.prompt.clone() {
            ObjectPromptKind::Box(bounds) => PromptKind::Box(bounds),
            ObjectPromptKind::Points { positive, negative } => PromptKind::Points { positive, negative },
        };
        ObjectPrompt::new(choice.frame, kind)
    });
    let drawn = human.into_iter().map(|(frame, mask)| {
        let reach = document.object_reach.get(&frame).copied().unwrap_or_default();
        let kind = PromptKind::Mask { mask, human: true };
        ObjectPrompt { frame, kind, reach: (reach.backward, reach.forward) }
    });
    chosen.into_iter().chain(drawn).collect()
}

fn nothing(clip: &StandardClip) -> MaskTrack {
    let size = clip.size();
    let frame = MaskFrame {
        mask: RleMask::empty(size),
        author: MaskAuthor::Propagated,
        score: 0.0,
        flags: vec![MaskFlag::Lost],
    };
    MaskTrack { size, frames: vec![frame; clip.frame_count()], backend: "none".to_owned() }
}
