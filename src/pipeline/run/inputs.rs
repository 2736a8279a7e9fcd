//! Everything that decides about a clip's result and is known before any work.

use std::{collections::BTreeSet, path::Path, sync::atomic::AtomicBool};

use super::{RunOptions, estimator, model, move_robot};
use crate::{
    inpaint::video::Blend,
    pipeline::{
        ClipFailure, ClipJob, Installation, Key, Listener, Stage,
        reporter::{Progress, StageWatch},
    },
    session::{Author, Document, ReviewState, Session},
};

/// The files a clip is made from, by their content.
pub(super) struct Inputs {
    /// The video.
    clip: String,
    /// The hand track to import.
    track: Option<String>,
    robot: String,
    /// The learned models in use, and how their windows are blended.
    models: (Vec<(&'static str, String)>, Blend),
    /// The hand estimator that somebody asked for.
    estimator: Option<Vec<String>>,
    options: RunOptions,
}

impl Inputs {
    /// Reads what is named by content.
    pub(super) fn read(
        session: &Session,
        installation: &Installation,
        options: RunOptions,
        cancel: &AtomicBool,
        listener: &dyn Listener,
    ) -> Result<Self, ClipFailure> {
        let progress = Progress::default();
        let watch = StageWatch::new(Stage::Clip, &progress, listener, cancel);
        let document = session.document();
        let clip = crate::clip::content_hash(Path::new(&document.clip.path), &watch)
            .map_err(|error| ClipFailure::from(error).in_stage(Stage::Clip))?;
        check_hash(session, &clip)?;
        let track = match &document.hand_track {
            Some(path) => Some(blake3::hash(&std::fs::read(path).map_err(|error| {
                ClipFailure::bad_input(format_args!("cannot read the hand track {path}: {error}"))
                    .in_stage(Stage::Landmarks)
            })?)),
            None => None,
        };
        let track = track.map(|hash| hash.to_hex().to_string());
        let robot = move_robot::robot_identity(installation)?;
        let models = (installation.model_identities(), installation.models.blend);
        let own = !installation.models.estimator.is_empty();
        let estimator = own.then(|| estimator::identity(installation));
        Ok(Self { clip, track, robot, models, estimator, options })
    }

    /// The hash of these and of everything decided in `document`. `unasked` says that a model was asked in vain for them.
    pub(super) fn key(
        &self,
        job: &ClipJob,
        document: &Document,
        installation: &Installation,
        unasked: bool,
    ) -> Result<Key, ClipFailure> {
        let mut decided = Document {
            proposals: Vec::new(),
            object_answer: None,
            confirmed: BTreeSet::new(),
            review: ReviewState::Unreviewed,
            ..document.clone()
        };
        decided.clip.content_hash.clone_from(&self.clip);
        decided.clip.path.clear();
        // What the machine or the manifest chose follows from the other inputs.
        decided.object = decided.object.filter(|object| object.author == Author::Human);
        let said = model::inputs(job, document, installation, unasked);
        let inputs = (decided, &job.object, &self.track, &self.robot, said, &self.models);
        let mut key = Key::new(Stage::Export, &[], &inputs)?;
        if let Some(estimator) = &self.estimator {
            key = Key::new(Stage::Export, &[&key], &("estimator", estimator))?;
        }
        Ok(if self.options.layers { Key::new(Stage::Export, &[&key], &"layers")? } else { key })
    }
}

/// A session with a person's edits stays with the file it was made from.
fn check_hash(session: &Session, hash: &str) -> Result<(), ClipFailure> {
    let clip = &session.document().clip;
    if clip.content_hash.is_empty() || clip.content_hash == hash || session.human_edits() == 0 {
        return Ok(());
    }
    Err(ClipFailure::bad_input(format_args!(
        "{} is not the file this session was made from (its content differs): restore it, or start a new session",
        clip.path
    ))
    .in_stage(Stage::Clip))
}
