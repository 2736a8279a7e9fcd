//! The background without the human: by a network where one is active, else by plates.

use std::{fs, sync::Arc};

use serde::{Deserialize, Serialize};

use super::context::Context;
use crate::{
    clip::{FrameIndex, FrameSource as _, FrameStore, FrameStoreWriter, StandardClip, StoreError},
    engine::ModelUse,
    image::Rgb8,
    inpaint::{
        self, InpaintError, InpaintParams, InpaintReport, SinkError,
        network::{IMAGE_INPAINT, ImageNetwork},
        video::{VIDEO_INPAINT, VideoNetwork, clean_by_network},
    },
    pipeline::{ClipFailure, ExitCode, Key, Stage, reporter::StageWatch},
    segment::{MaskTrack, arms::ArmTrack},
};

/// What the background stage leaves: the frames on disk, the report in memory.
#[derive(Debug)]
pub struct Background {
    /// Every frame without arms; the visible object is still in it.
    pub frames: FrameStore,
    /// Where its pixels come from.
    pub report: Arc<InpaintReport>,
}

#[derive(Serialize, Deserialize)]
struct Sealed {
    report: InpaintReport,
}

/// Masks of arms and object, and the keys of what they were made from.
type Masks<'a> = (&'a MaskTrack, &'a MaskTrack, [&'a Key; 2]);
/// Takes finished frames in order.
type Sink<'a> = dyn FnMut(FrameIndex, &Rgb8) -> Result<(), SinkError> + 'a;

/// The background without the human, kept in a frame store in the cache.
pub(super) fn background(
    context: &Context<'_>,
    clip: &StandardClip,
    arms: (&ArmTrack, &Key),
    object: (&MaskTrack, &Key),
) -> Result<Background, ClipFailure> {
    let params =
        context.document.hole_dilation.map_or_else(InpaintParams::default, InpaintParams::with_hole_dilation);
    let masks = (&arms.0.union, object.0, [arms.1, object.1]);
    if let Some(made) = by_network(context, clip, masks, &params)? {
        return Ok(made);
    }
    if let Some(made) = with_unseen_by_network(context, clip, masks, &params)? {
        return Ok(made);
    }
    let key = Key::new(Stage::Inpaint, &masks.2, &params)?;
    kept(context, clip, &key, |sink, watch| {
        inpaint::clean(clip, masks.0, masks.1, None, &params, sink, watch)
    })
}

/// `None` where no network is active or it failed, which is said in one line.
fn by_network(
    context: &Context<'_>,
    clip: &StandardClip,
    masks: Masks<'_>,
    params: &InpaintParams,
) -> Result<Option<Background>, ClipFailure> {
    context.with_model(&VIDEO_INPAINT, ModelUse::Background, |model, fault| {
        let blend = context.installation.models.blend;
        let key = Key::new(Stage::Inpaint, &masks.2, &(params, model.identity(), blend))?;
        kept(context, clip, &key, |sink, watch| {
            let network =
                context.installation.runtime().and_then(|runtime| VideoNetwork::open(&runtime, model));
            let cleaned = network.map_err(InpaintError::from).and_then(|mut network| {
                clean_by_network(clip, (masks.0, masks.1), params, (&mut network, blend), sink, watch)
            });
            cleaned.inspect_err(|error| fault.note(error.of_model()))
        })
    })
}

/// Plates whose unseen parts a network makes up; `None` where none is active or it failed, which is said in one line.
fn with_unseen_by_network(
    context: &Context<'_>,
    clip: &StandardClip,
    masks: Masks<'_>,
    params: &InpaintParams,
) -> Result<Option<Background>, ClipFailure> {
    context.with_model(&IMAGE_INPAINT, ModelUse::UnseenBackground, |model, fault| {
        let key = Key::new(Stage::Inpaint, &masks.2, &(params, "unseen by", model.identity()))?;
        kept(context, clip, &key, |sink, watch| {
            let network =
                context.installation.runtime().and_then(|runtime| ImageNetwork::open(&runtime, model));
            let cleaned = network.map_err(InpaintError::from).and_then(|mut network| {
                let unseen = Some(&mut network);
                inpaint::clean_with(clip, (masks.0, masks.1), None, params, unseen, sink, watch)
            });
            cleaned.inspect_err(|error| fault.note(error.of_model()))
        })
    })
}

/// What `make` hands to its sink, as a frame store in the cache; made only where it is not there yet.
fn kept(
    context: &Context<'_>,
    clip: &StandardClip,
    key: &Key,
    make: impl FnOnce(&mut Sink<'_>, &StageWatch<'_>) -> Result<InpaintReport, InpaintError>,
) -> Result<Background, ClipFailure> {
    let path = context.cache.path(Stage::Inpaint, key, "frames");
    let whole = FrameStore::open(&path).ok().filter(|store| store.frame_count() == clip.frame_count());
    if whole.is_none() {
        // Without its frames the report is of no use: make both again.
        fs::remove_file(context.cache.path(Stage::Inpaint, key, "json")).ok();
    }
    let failed = |error: StoreError| ClipFailure::from_error(&error, ExitCode::InputOutput);
    let sealed = context.stage(Stage::Inpaint, |watch| {
        context.cache.get_or_make(Stage::Inpaint, key, || {
            let mut writer = FrameStoreWriter::create(&path, clip.size()).map_err(failed)?;
            let mut sink = |_: FrameIndex, frame: &Rgb8| Ok(writer.push(frame)?);
            let report = make(&mut sink, watch)
                .map_err(|error| ClipFailure::from_error(&error, ExitCode::Internal))?;
            writer.finish().map_err(failed)?;
            Ok::<_, ClipFailure>(Sealed { report })
        })
    })?;
    let frames = FrameStore::open(&path).map_err(failed)?;
    Ok(Background { frames, report: Arc::new(sealed.report) })
}
