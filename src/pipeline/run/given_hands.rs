//! Metric hands that need no fit: imported, or by a network where one is active.

use std::sync::Arc;

use super::context::Context;
use crate::{
    clip::StandardClip,
    engine::ModelUse,
    hands::{
        HandTrack, HandsError,
        import::{self, ImportParams},
        network::{HAND_POSE, HandNetwork, distance_warning, track_hands},
    },
    pipeline::{ClipFailure, ExitCode, Key, Stage},
};

/// What its lines are about.
const TOPIC: &str = "the network's hands";

/// Metric hands that need no fit.
#[derive(Debug)]
pub(super) enum GivenHands {
    /// A track made elsewhere: taken as it is.
    Imported(HandTrack),
    /// By a network: hands that go out of sight are still to be carried along.
    Network(Arc<HandTrack>),
}

impl GivenHands {
    /// The hands as they came.
    pub(super) fn track(&self) -> &HandTrack {
        match self {
            Self::Imported(track) => track,
            Self::Network(track) => track,
        }
    }

    /// What tells them from others.
    pub(super) fn key(&self, context: &Context<'_>, clip_key: &Key) -> Result<Key, ClipFailure> {
        Ok(Key::new(Stage::Landmarks, &[clip_key], &(&context.document.hand_track, self.track()))?)
    }
}

/// The session's imported track, where it names one; else a network's hands, where one is active and no estimator was
/// asked for.
pub(super) fn given(
    context: &Context<'_>,
    clip: &StandardClip,
    clip_key: &Key,
) -> Result<Option<GivenHands>, ClipFailure> {
    if let Some(track) = imported(context, clip)? {
        return Ok(Some(GivenHands::Imported(track)));
    }
    if !context.installation.models.estimator.is_empty() {
        return Ok(None);
    }
    let found = by_network(context, clip, clip_key)?;
    if let Some(line) = found.as_ref().and_then(|track| distance_warning(track, &clip.info.intrinsics)) {
        context.say(TOPIC, &line);
    }
    Ok(found.map(GivenHands::Network))
}

fn imported(context: &Context<'_>, clip: &StandardClip) -> Result<Option<HandTrack>, ClipFailure> {
    let Some(path) = &context.document.hand_track else { return Ok(None) };
    let times: Vec<f64> = clip.info.frame_table.iter().map(|row| row.source_pts).collect();
    let track = import::read(path.as_ref(), &times, &clip.info.intrinsics, &ImportParams::default())
        .map_err(|error| ClipFailure::from_error(&error, ExitCode::BadInput).in_stage(Stage::Landmarks))?;
    Ok(Some(track))
}

/// `None` where no network is active or it failed, which is said in one line.
fn by_network(
    context: &Context<'_>,
    clip: &StandardClip,
    clip_key: &Key,
) -> Result<Option<Arc<HandTrack>>, ClipFailure> {
    context.with_model(&HAND_POSE, ModelUse::Hands, |model, fault| {
        let camera = clip.info.intrinsics;
        let inputs = (camera, model.identity());
        let found = context.cached_stage(
            Stage::Landmarks,
            &[clip_key],
            &inputs,
            ExitCode::Internal,
            |watch| -> Result<HandTrack, HandsError> {
                let network =
                    context.installation.runtime().and_then(|runtime| HandNetwork::open(&runtime, model));
                let track = network
                    .map_err(HandsError::from)
                    .and_then(|mut network| track_hands(clip, &mut network, &camera, watch));
                track.inspect_err(|error| fault.note(error.of_model()))
            },
        );
        found.map(|(track, _)| track)
    })
}
