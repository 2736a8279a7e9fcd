//! From pixels to what is in them: hands, arms, object, template, background.

use std::{borrow::Cow, sync::Arc};

use nalgebra::Matrix3;

use super::{
    context::Context,
    edits::{human_masks, landmarks_with_keypoints, landmarks_with_sides},
    estimator,
    given_hands::GivenHands,
    model,
    source::standard_prompt,
};
use crate::{
    clip::{FrameIndex, FrameSource, StandardClip},
    geometry::PerSide,
    hands::{self, EstimateParams, Estimation, HandTrack},
    landmarks::{HandLandmarks, LandmarkTrack},
    pipeline::{ClipFailure, ClipJob, Decisions, ExitCode, Key, Stage},
    segment::{
        MaskTrack,
        arms::{self, ArmInputs, ArmParams, ArmTrack, HandledObject},
    },
    select::{self, SelectParams},
    session::{Author, Command, MaskLayer, ObjectChoice, ObjectPromptKind, ReviewState, TemplateEdits},
    template::{self, TemplateParams, TemplateTrack},
};

/// Landmarks of the clip: from the estimator, or seen again from hands that are given.
pub(super) fn landmarks(
    context: &Context<'_>,
    clip: &StandardClip,
    given: Option<&GivenHands>,
    clip_key: &Key,
) -> Result<(Estimation, Key), ClipFailure> {
    let (estimation, key) = if let Some(given) = given {
        let key = given.key(context, clip_key)?;
        let track = given.track();
        (Arc::new(Estimation { landmarks: landmarks_of(track), backend: track.backend.clone() }), key)
    } else {
        let params = EstimateParams::default();
        let inputs = (&params, estimator::identity(context.installation));
        context.cached_stage(Stage::Landmarks, &[clip_key], &inputs, ExitCode::Temporary, |watch| {
            let command = estimator::command(context.installation, &context.cache)?;
            hands::estimate(clip, &command, &params, watch)
        })?
    };
    let document = &context.document;
    let struck_out = document.hand_edits.iter().map(|(_, edits)| {
        let invalid = edits.iter().filter(|(_, edit)| edit.invalid);
        invalid.map(|(frame, _)| *frame).collect::<Vec<_>>()
    });
    let inputs = (struck_out.collect::<Vec<_>>(), &document.sides_swapped);
    let key = Key::new(Stage::Landmarks, &[&key], &inputs)?;
    let landmarks = landmarks_with_sides(estimation.landmarks.clone(), document);
    Ok((Estimation { landmarks, backend: estimation.backend.clone() }, key))
}

/// The landmarks that hands are fitted to: with the keypoints a person moved.
pub(super) fn corrected(
    context: &Context<'_>,
    seen: &Estimation,
    key: &Key,
) -> Result<(Estimation, Key), ClipFailure> {
    let document = &context.document;
    let key = Key::new(Stage::Landmarks, &[key], &document.hand_edits)?;
    let landmarks = landmarks_with_keypoints(seen.landmarks.clone(), document);
    Ok((Estimation { landmarks, backend: seen.backend.clone() }, key))
}

/// A given track as an estimator would have seen it.
fn landmarks_of(track: &HandTrack) -> LandmarkTrack {
    FrameIndex::all(track.frame_count())
        .map(|index| {
            let hands = track.at(index);
            PerSide::from_fn(|side| {
                let hand = hands[side];
                hand.is_valid().then_some(HandLandmarks {
                    keypoints: hand.keypoints,
                    world: None,
                    confidence: hand.confidence,
                })
            })
        })
        .collect()
}

/// Arm masks.
pub(super) fn arms(
    context: &Context<'_>,
    job: &ClipJob,
    clip: &StandardClip,
    landmarks: &LandmarkTrack,
    landmark_key: &Key,
) -> Result<(Arc<ArmTrack>, Key), ClipFailure> {
    let human =
        human_masks(&context.document, &context.masks, MaskLayer::Arms, clip.size(), clip.frame_count())?;
    let params = ArmParams::default();
    let object = handled_object(context, job, clip)?;
    let stated = object.map(|object| (object.frame, object.bounds));
    let inputs = (&params, human.iter().collect::<Vec<_>>(), stated);
    context.cached_stage(Stage::Arms, &[landmark_key], &inputs, ExitCode::Internal, |watch| {
        let scratch = context.cache.folder();
        let inputs = ArmInputs { frames: clip, landmarks, human: &human, object, scratch };
        arms::track_arms(&inputs, &params, watch)
    })
}

/// The object as somebody pointed at it with a box; proposals come later, and are made from the arms.
fn handled_object(
    context: &Context<'_>,
    job: &ClipJob,
    clip: &StandardClip,
) -> Result<Option<HandledObject>, ClipFailure> {
    let Some(choice) = stated_object(context, job, clip)? else { return Ok(None) };
    Ok(match choice.prompt {
        ObjectPromptKind::Box(bounds) => Some(HandledObject { frame: choice.frame, bounds }),
        ObjectPromptKind::Points { .. } => None,
    })
}

/// The object as a person or the manifest stated it; the person's word counts more.
fn stated_object(
    context: &Context<'_>,
    job: &ClipJob,
    clip: &StandardClip,
) -> Result<Option<ObjectChoice>, ClipFailure> {
    let by_human = context.document.object.as_ref().is_some_and(|object| object.author == Author::Human);
    match &job.object {
        Some(raw) if !by_human => {
            Ok(Some(standard_prompt(raw, &clip.info).map_err(|failure| failure.in_stage(Stage::Select))?))
        }
        _ => {
            Ok(context.document.object.clone().filter(|object| !matches!(object.author, Author::Machine(_))))
        }
    }
}

/// The object: the person's or the manifest's, else the best proposal, which asks for a review.
pub(super) fn choose_object(
    context: &mut Context<'_>,
    decisions: &mut dyn Decisions,
    job: &ClipJob,
    clip: &StandardClip,
    landmarks: &LandmarkTrack,
    arms: (&ArmTrack, &Key),
) -> Result<Option<ObjectChoice>, ClipFailure> {
    let wanted = stated_object(context, job, clip)?;
    if let Some(object) = wanted {
        if context.document.object.as_ref() != Some(&object) {
            let author = object.author.clone();
            context.decide(decisions, author, Command::SetObject(Some(object.clone())))?;
        }
        return Ok(Some(object));
    }
    if !context.document.object_masks.is_empty() {
        // A person drew the object without naming it: their masks say enough.
        return Ok(None);
    }
    let word = model::word(context, decisions, job, clip, landmarks, &arms.0.union)?;
    let params = SelectParams::default();
    let (proposals, _) =
        context.cached_stage(Stage::Select, &[arms.1], &params, ExitCode::Internal, |watch| {
            select::propose(clip, landmarks, &arms.0.union, &params, watch)
        })?;
    // A model names what it sees; what moves with the hands stays beside it.
    let proposals: Vec<ObjectChoice> =
        word.object.into_iter().chain(proposals.iter().map(as_choice)).collect();
    let best = proposals.first().cloned();
    let reason = match &best {
        Some(best) => {
            let (by, confidence) = (proposer(&best.author), best.confidence);
            format!("the object was proposed by {by} ({confidence:.2}): {}", best.reason)
        }
        None => "no object was found that moves with a hand".to_owned(),
    };
    context.listener.note(&reason);
    let reason = word.excuse.map_or(reason.clone(), |excuse| format!("{excuse}; {reason}"));
    if context.document.object != best || context.document.proposals != proposals {
        let machine =
            best.as_ref().map_or(Author::Machine("contact motion".to_owned()), |best| best.author.clone());
        let mut commands = vec![Command::SetProposals(proposals), Command::SetObject(best.clone())];
        // What a person said about the clip stays.
        if matches!(context.document.review, ReviewState::Unreviewed | ReviewState::NeedsReview { .. }) {
            commands.push(Command::SetReview(ReviewState::NeedsReview { reason }));
        }
        context.decide(decisions, machine, Command::Together(commands))?;
    }
    Ok(best)
}

/// Who proposed something, in words.
fn proposer(author: &Author) -> &str {
    match author {
        Author::Machine(name) => name,
        Author::Human => "a person",
        Author::Manifest => "the manifest",
    }
}

fn as_choice(proposal: &select::Proposal) -> ObjectChoice {
    ObjectChoice {
        label: proposal.label.clone(),
        frame: proposal.frame,
        prompt: match proposal.point {
            Some(at) => ObjectPromptKind::Points { positive: vec![at], negative: Vec::new() },
            None => ObjectPromptKind::Box(proposal.bounds),
        },
        confidence: proposal.confidence,
        reason: proposal.reason.clone(),
        author: Author::Machine(proposal.backend.clone()),
    }
}

/// The object's template and placements, with the person's own on top.
pub(super) fn template(
    context: &Context<'_>,
    clip: &StandardClip,
    object: (&MaskTrack, &Key),
    arms: (&ArmTrack, &Key),
    landmarks: &LandmarkTrack,
) -> Result<(Option<Arc<TemplateTrack>>, Key), ClipFailure> {
    let edits = &context.document.template;
    let params = TemplateParams::default();
    let drawn = match (edits.frame, &edits.mask) {
        (Some(frame), Some(id)) => Some((frame, context.masks.get(id)?)),
        _ => None,
    };
    let inputs = (&params, edits.frame, &edits.mask);
    let (track, key) =
        context.cached_stage(Stage::Template, &[object.1, arms.1], &inputs, ExitCode::Internal, |watch| {
            let mut masks = Cow::Borrowed(object.0);
            if let Some((frame, mask)) = drawn
                && frame.as_usize() < masks.frames.len()
            {
                masks.to_mut().frames[frame.as_usize()].mask = mask;
            }
            template::build(clip, &masks, &arms.0.union, edits.frame, landmarks, &params, watch)
        })?;
    let set = set_placements(track.as_ref().as_ref(), edits);
    let key = Key::new(Stage::Template, &[&key], &set)?;
    let kept = context
        .memory
        .and_then(|memory| memory.artifact::<Option<Arc<TemplateTrack>>>(Stage::Template, &key));
    if let Some(placed) = kept {
        return Ok((Option::clone(&placed), key));
    }
    let placed = Option::clone(&track).map(|track| Arc::new(track.with_edits(edits)));
    if let Some(memory) = context.memory {
        memory.keep(Stage::Template, &key, &Arc::new(placed.clone()));
    }
    Ok((placed, key))
}

/// All placements that a person's word decides, in order.
fn set_placements(track: Option<&TemplateTrack>, edits: &TemplateEdits) -> Vec<(FrameIndex, Matrix3<f64>)> {
    let Some(track) = track else { return edits.placements.iter().map(|(at, to)| (*at, *to)).collect() };
    let set = |frame| Some((frame, track.by_hand(edits, frame)?.transform));
    FrameIndex::all(track.placements.len()).filter_map(set).collect()
}
