//! What a vision-language model says about the object: asked, or taken from the session.

use serde_json::{Value, json};

use super::context::Context;
use crate::{
    clip::{FrameSource as _, StandardClip},
    landmarks::LandmarkTrack,
    pipeline::{ClipFailure, ClipJob, Decisions, ExitCode, Installation, Stage},
    progress::Watch as _,
    segment::MaskTrack,
    select::{
        SelectInput,
        vlm::{VlmError, VlmPlan, VlmSelector, VlmServer, answers},
    },
    session::{Author, Command, Document, ObjectAnswer, ObjectProposal, Said},
};

/// What its lines are about.
const TOPIC: &str = "the object's model";

/// A model's proposal, or why there is none where one was hoped for.
#[derive(Debug, Default)]
pub(super) struct Word {
    pub(super) object: Option<ObjectProposal>,
    pub(super) excuse: Option<String>,
}

impl Word {
    fn excuse(context: &Context<'_>, reason: String) -> Self {
        context.say(TOPIC, &format!("{reason}; contact motion proposes"));
        Self { object: None, excuse: Some(reason) }
    }

    fn of(context: &Context<'_>, answer: &ObjectAnswer) -> Self {
        match &answer.said {
            Said::Object(object) => Self { object: Some(object.clone()), excuse: None },
            Said::Nothing(reason) => {
                Self::excuse(context, format!("{} sees no handled object ({reason})", answer.model))
            }
            Said::Unusable(reason) => {
                Self::excuse(context, format!("the answer of {} cannot be used: {reason}", answer.model))
            }
        }
    }
}

/// Asks the model where one is to be asked and no answer to the same question is kept. What it says is kept in the
/// session; a model that cannot be asked is a line in the log, never a failure of the clip.
pub(super) fn word(
    context: &mut Context<'_>,
    decisions: &mut dyn Decisions,
    job: &ClipJob,
    clip: &StandardClip,
    landmarks: &LandmarkTrack,
    arms: &MaskTrack,
) -> Result<Word, ClipFailure> {
    let plan = match context.installation.vlm.plan(&job.vlm) {
        Ok(plan) => plan,
        Err(error) => return Ok(Word::excuse(context, format!("no model is asked: {error}"))),
    };
    let source = source_of(&context.document, &clip.info.hash);
    let wanted = match &plan {
        VlmPlan::Off => return Ok(Word::default()),
        VlmPlan::Replay { model, profile, .. } => (model.as_deref(), *profile),
        VlmPlan::Ask(server) => (Some(server.model.as_str()), Some(server.profile)),
    };
    let task = context.document.task.as_deref();
    if let Some(kept) = &context.document.object_answer
        && answers(kept, task, &source, clip.size(), wanted)
    {
        context.say(TOPIC, &format!("the kept answer of {} is used", kept.model));
        return Ok(Word::of(context, kept));
    }
    match plan {
        VlmPlan::Ask(server) => {
            let input = SelectInput { frames: clip, landmarks, arms };
            match asked(context, &server, &source, input)? {
                Ok(answer) => {
                    let command = Command::SetObjectAnswer(Some(Box::new(answer.clone())));
                    context.decide(decisions, Author::Machine(server.backend()), command)?;
                    Ok(Word::of(context, &answer))
                }
                Err(reason) => {
                    context.unasked = true;
                    Ok(Word::excuse(context, format!("{} was not asked: {reason}", server.model)))
                }
            }
        }
        VlmPlan::Replay { asked_for: true, .. } => {
            let reason = "the session keeps no model's answer to this question (--vlm live asks)";
            Ok(Word::excuse(context, reason.to_owned()))
        }
        VlmPlan::Replay { asked_for: false, .. } | VlmPlan::Off => Ok(Word::default()),
    }
}

/// The model's answer, or in one line why there is none. Asked in vain, a model is not asked again while the clip is open.
fn asked(
    context: &Context<'_>,
    server: &VlmServer,
    source: &str,
    input: SelectInput<'_>,
) -> Result<Result<ObjectAnswer, String>, ClipFailure> {
    let task = context.document.task.as_deref();
    let question = json!([source, task, server.url, server.model, server.profile]).to_string();
    if let Some(known) = context.memory.and_then(|memory| memory.model_word(&question)) {
        return Ok(known);
    }
    let watch = context.watch(Stage::Select);
    watch.advance(0, 1);
    let say = |line: &str| context.listener.note(line);
    let word = match (VlmSelector { server, task, clip: source, say: &say }).ask(input, &watch) {
        Ok(answer) => Ok(answer),
        Err(error @ (VlmError::Cancelled(_) | VlmError::Frame(_))) => {
            return Err(ClipFailure::from_error(&error, ExitCode::Internal).in_stage(Stage::Select));
        }
        Err(error) => Err(error.to_string()),
    };
    if let Some(memory) = context.memory {
        memory.keep_model_word(question, word.clone());
    }
    Ok(word)
}

/// What frames are taken from: the same frame numbers of the same source show the same pictures.
fn source_of(document: &Document, hash: &str) -> String {
    let clip = &document.clip;
    json!([hash, clip.rotate, clip.start, clip.end]).to_string()
}

/// What a model's word adds to the hash of a clip's inputs; nothing where no model has a say. A model that was asked in
/// vain (`unasked`) leaves a hash that no clip to be done has, so that the same line asks it again.
pub(super) fn inputs(
    job: &ClipJob,
    document: &Document,
    installation: &Installation,
    unasked: bool,
) -> Value {
    let is_stated =
        document.object.as_ref().is_some_and(|object| !matches!(object.author, Author::Machine(_)));
    if job.object.is_some() || is_stated || !document.object_masks.is_empty() {
        return Value::Null;
    }
    let kept = document.object_answer.as_ref().map(|answer| json!([answer.request, answer.said]));
    match installation.vlm.plan(&job.vlm) {
        Ok(VlmPlan::Replay { model, profile, .. }) => {
            kept.map_or(Value::Null, |kept| json!([model, profile, kept]))
        }
        Ok(VlmPlan::Ask(server)) => {
            let word = if unasked { Some(json!("unasked")) } else { kept };
            json!([server.model, server.profile, word])
        }
        Ok(VlmPlan::Off) | Err(_) => Value::Null,
    }
}
