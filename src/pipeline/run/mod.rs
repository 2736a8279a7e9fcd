//! One clip from its file to its record.

mod background;
mod context;
mod edits;
mod estimator;
mod export;
mod frame;
mod given_hands;
mod inputs;
mod layer_files;
mod layers;
mod model;
mod move_robot;
mod object;
mod pixels;
mod prepare;
mod report;
mod source;
mod stills;
mod understand;

use std::{
    path::Path,
    sync::{Arc, Mutex, atomic::AtomicBool},
    thread,
};

use super::{
    Cache, ClipFailure, ClipJob, Decisions, ExitCode, Installation, Key, Listener, Memory, Stage,
    batch::{ClipOutcome, ClipState, read_outcome},
    reporter::Progress,
};
use crate::{
    clip::{FrameSource as _, StandardClip},
    engine::Finding,
    hands::{Estimation, HandTrack},
    retarget::RobotMotion,
    robot::RobotModel,
    segment::{MaskTrack, arms::ArmTrack},
    session::{Author, Command, Document, MaskStore, ObjectChoice, ReviewState, Session},
    template::TemplateTrack,
};
use context::Context;
use export::Parts;
use inputs::Inputs;

pub use background::Background;
pub(crate) use frame::{FramePixels, compose_frame, layers_of, render_robot, robot_renderer};
pub use layers::shown_arms;
pub(crate) use layers::{Evidence, LayerPlan, layer_evidence, plan_layers};
pub(crate) use prepare::open_session;
pub(super) use source::clip_request;

/// What a run of one clip leaves beside its results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunOptions {
    /// The decoded clip and the background stay in the session's cache, which is large (default: no).
    pub keep_frames: bool,
    /// Every frame's layers are written without loss, as pictures in `layers/` (default: no).
    pub layers: bool,
}

/// How a run of one clip ended.
#[derive(Debug)]
pub struct ClipRun {
    /// As `done.json` or `failed.json` says.
    pub outcome: ClipOutcome,
    /// Whether the result was there already.
    pub skipped: bool,
}

/// Finds everything out about a clip, from its session's cache where it can; writes no result.
///
/// # Errors
/// As [`run_clip`].
pub fn understand_clip(
    job: &ClipJob,
    out: &Path,
    installation: &Installation,
    listener: &dyn Listener,
    cancel: &AtomicBool,
) -> Result<Understood, ClipFailure> {
    let mut session = prepare::open_session(job, out, listener)?;
    let mut context = new_context(job, &session, installation, listener, cancel)?;
    understand(job, &mut context, &mut session)
}

/// As [`understand_clip`], for a document that somebody else keeps: nothing is written but the cache of the session
/// in `folder`; decisions go to `decisions`, and what `memory` holds from the run before is not made again.
///
/// # Errors
/// As [`run_clip`].
pub fn understand_document(
    job: &ClipJob,
    document: &Document,
    folder: &Path,
    memory: &Memory,
    decisions: &mut dyn Decisions,
    surroundings: (&Installation, &dyn Listener, &AtomicBool),
) -> Result<Understood, ClipFailure> {
    let (installation, listener, cancel) = surroundings;
    let mut context = Context {
        document: job.taken(document),
        masks: MaskStore::with_fresh(&folder.join("masks"), memory.masks().clone()),
        cache: Cache::open(&folder.join("cache"))?,
        memory: Some(memory),
        installation,
        listener,
        cancel,
        progress: Progress::default(),
        unasked: false,
        timings: Mutex::default(),
    };
    understand(job, &mut context, decisions)
}

fn new_context<'a>(
    job: &ClipJob,
    session: &Session,
    installation: &'a Installation,
    listener: &'a dyn Listener,
    cancel: &'a AtomicBool,
) -> Result<Context<'a>, ClipFailure> {
    Ok(Context {
        document: job.taken(session.document()),
        masks: session.masks(),
        memory: None,
        cache: Cache::open(&session.folder().join("cache"))?,
        installation,
        listener,
        cancel,
        progress: Progress::default(),
        unasked: false,
        timings: Mutex::default(),
    })
}

/// Does one clip: everything from its file to `out/ID/`, unless that is there already for the same inputs.
///
/// # Errors
/// The stage, the class and one line. Nothing half-made is left in `out/ID/`; finished stages stay in the
/// session's cache, so that the next run goes on from there.
pub fn run_clip(
    job: &ClipJob,
    out: &Path,
    installation: &Installation,
    options: RunOptions,
    listener: &dyn Listener,
    cancel: &AtomicBool,
) -> Result<ClipRun, ClipFailure> {
    let mut session = prepare::open_session(job, out, listener)?;
    let inputs = Inputs::read(&session, installation, options, cancel, listener)?;
    let key = inputs.key(job, &job.taken(session.document()), installation, false)?;
    if let ClipState::Done(outcome) = read_outcome(&out.join(&job.id))?
        && outcome.inputs == key.as_str()
    {
        return Ok(ClipRun { outcome, skipped: true });
    }
    let mut context = new_context(job, &session, installation, listener, cancel)?;
    let outcome = work(job, (out, options), &mut context, &mut session, &inputs)?;
    if session.is_writable() {
        session.save_snapshot()?;
    }
    if !options.keep_frames {
        clear_frame_stores(&context.cache);
    }
    Ok(ClipRun { outcome, skipped: false })
}

/// Everything that was found out about a clip, before a file is written.
#[derive(Debug)]
pub struct Understood {
    /// The clip on its standard timeline.
    pub clip: Arc<StandardClip>,
    /// Hands, forearms, sleeves.
    pub arms: Arc<ArmTrack>,
    /// The object's visible part.
    pub object: Arc<MaskTrack>,
    /// The object whole, and where it goes; `None` where no object is known.
    pub template: Option<Arc<TemplateTrack>>,
    /// The clip without the human.
    pub background: Arc<Background>,
    /// What the estimator saw.
    pub landmarks: Arc<Estimation>,
    /// Metric hands.
    pub hands: Arc<HandTrack>,
    /// The robot in use.
    pub robot: RobotModel,
    /// Its motion.
    pub motion: Arc<RobotMotion>,
    /// The object as it was pointed at.
    pub choice: Option<ObjectChoice>,
}

fn work(
    job: &ClipJob,
    (out, options): (&Path, RunOptions),
    context: &mut Context<'_>,
    session: &mut Session,
    inputs: &Inputs,
) -> Result<ClipOutcome, ClipFailure> {
    let found = understand(job, context, session)?;
    // Of what is known now: the same line finds the same.
    let key = inputs.key(job, &context.document, context.installation, context.unasked)?;
    let outcome = ClipOutcome {
        id: job.id.clone(),
        exit: ExitCode::Done,
        stage: None,
        message: None,
        inputs: key.as_str().to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        frames: Some(found.clip.frame_count()),
        flags: clip_flags(context, &found),
    };
    export::write(context, out, &Parts { found: &found, outcome: &outcome, layers: options.layers })?;
    Ok(outcome)
}

/// All stages up to the robot's motion.
fn understand(
    job: &ClipJob,
    context: &mut Context<'_>,
    decisions: &mut dyn Decisions,
) -> Result<Understood, ClipFailure> {
    let listener = context.listener;
    let clip = source::open_clip(context)?;
    listener.found(Finding::Clip(Arc::new(clip.info.clone())));
    remember_hash(context, decisions, &clip.info.hash)?;
    let table = (&clip.info.hash, clip.info.rotate, clip.info.intrinsics_source, &clip.info.frame_table);
    let clip_key = Key::new(Stage::Clip, &[], &table)?;
    let given = given_hands::given(context, &clip, &clip_key)?;
    let (seen, landmark_key) = understand::landmarks(context, &clip, given.as_ref(), &clip_key)?;
    let seen = Arc::new(seen);
    let (corrected, corrected_key) = understand::corrected(context, &seen, &landmark_key)?;
    listener.found(Finding::Landmarks(Arc::new(corrected.landmarks.clone())));
    let (arms, arms_key) = understand::arms(context, job, &clip, &seen.landmarks, &landmark_key)?;
    listener.found(Finding::Arms(Arc::clone(&arms)));
    let choice =
        understand::choose_object(context, decisions, job, &clip, &seen.landmarks, (&arms, &arms_key))?;
    listener.found(Finding::Choice(choice.clone()));
    let (object, object_key) =
        object::object(context, &clip, choice.as_ref(), &seen.landmarks, (&arms, &arms_key))?;
    listener.found(Finding::Object(Arc::clone(&object)));
    let (arms, arms_key) = object::arms_without(context, (&arms, &arms_key), (&object, &object_key))?;
    listener.found(Finding::Arms(Arc::clone(&arms)));
    // The background needs nothing of what leads to the robot's motion, and neither fills all cores.
    let context = &*context;
    let (background, moved) = thread::scope(|scope| {
        let background = scope.spawn(|| {
            let made = background::background(context, &clip, (&arms, &arms_key), (&object, &object_key))?;
            listener.found(Finding::Background(Arc::clone(&made.report)));
            Ok(made)
        });
        let moved = (|| {
            let (object, arms) = ((&*object, &object_key), (&*arms, &arms_key));
            let (template, template_key) =
                understand::template(context, &clip, object, arms, &seen.landmarks)?;
            listener.found(Finding::Template(template.clone()));
            let around = move_robot::surroundings(arms.0, template.as_deref());
            let keys = [&corrected_key, &arms_key, &template_key];
            let (hands, hands_key) = move_robot::hands(context, &clip, given, &corrected, &around, keys)?;
            listener.found(Finding::Hands(Arc::clone(&hands)));
            let (robot, motion) = move_robot::retarget(context, &hands, &hands_key)?;
            listener.found(Finding::Motion(Arc::clone(&motion)));
            Ok::<_, ClipFailure>((template, hands, robot, motion))
        })();
        (joined(background.join()), moved)
    });
    // Where both failed, it is always the same one that is told.
    let ((template, hands, robot, motion), background) = (moved?, Arc::new(background?));
    Ok(Understood { clip, arms, object, template, background, landmarks: seen, hands, robot, motion, choice })
}

/// What a worker thread came to; its panic is a failure of the clip, not of the program.
fn joined<T>(result: thread::Result<Result<T, ClipFailure>>) -> Result<T, ClipFailure> {
    result.unwrap_or_else(|_| {
        let message = "a worker thread panicked".to_owned();
        Err(ClipFailure { stage: None, exit: ExitCode::Internal, message })
    })
}

fn remember_hash(
    context: &mut Context<'_>,
    decisions: &mut dyn Decisions,
    hash: &str,
) -> Result<(), ClipFailure> {
    let known = &context.document.clip.content_hash;
    if known == hash {
        return Ok(());
    }
    if !known.is_empty() {
        context.listener.note("the video file has changed since the last run");
    }
    context.decide(decisions, Author::Machine("clip".to_owned()), Command::SetContentHash(hash.to_owned()))
}

fn clip_flags(context: &Context<'_>, found: &Understood) -> Vec<String> {
    let Understood { object, hands, .. } = found;
    let mut flags: Vec<String> = found.clip.info.flags.iter().map(source::flag_name).collect();
    if matches!(context.document.review, ReviewState::NeedsReview { .. }) {
        flags.push("needs_review".to_owned());
    }
    if object.frames.iter().all(|frame| frame.mask.is_empty()) {
        flags.push("no_object".to_owned());
    }
    if !hands.hands.iter().any(|(_, side)| side.iter().any(crate::hands::HandFrame::is_valid)) {
        flags.push("no_hands".to_owned());
    }
    flags
}

/// Frame stores are large and only serve a run that was cut short; the small artifacts stay.
fn clear_frame_stores(cache: &Cache) {
    let entries = std::fs::read_dir(cache.folder()).into_iter().flatten().flatten();
    for path in entries.map(|entry| entry.path()) {
        if path.extension().is_some_and(|extension| extension == "frames") {
            // What cannot be removed only takes space.
            std::fs::remove_file(path).ok();
        }
    }
}
