//! A model as a selector: question, answer, one repair turn.

use serde_json::json;

use super::{
    Profile, VlmServer,
    error::VlmError,
    frames,
    letterbox::Letterbox,
    parse::{Answer, parse},
    picture, prompt,
    reply::Reply,
    request::Question,
    transport::Connection,
    validate::{Place, Selection, Shown, line, validate},
};
use crate::{
    clip::FrameIndex,
    geometry::{PixelBox, Size},
    image::Mask,
    progress::Watch,
    select::{ObjectSelector, Proposal, SelectError, SelectInput},
    session::{Author, ObjectAnswer, ObjectPromptKind, ObjectProposal, Said},
};

/// Longest text of a model that is kept, bytes.
const LONGEST_KEPT: usize = 8 << 10;
/// How far around a point the object may reach where a point is all that was said, pixels.
const AROUND_POINT: f64 = 16.0;
/// How often a model is asked: once, and once more when its answer cannot be used.
const TURNS: usize = 2;

/// Asks a vision-language model which object the hands manipulate.
#[derive(Clone, Copy)]
pub struct VlmSelector<'a> {
    /// The model.
    pub server: &'a VlmServer,
    /// The task in one sentence, where it is known.
    pub task: Option<&'a str>,
    /// What the frames are taken from, for the question's hash: the file's hash and how it was cut and turned.
    pub clip: &'a str,
    /// Gets lines for the log.
    pub say: &'a dyn Fn(&str),
}

impl std::fmt::Debug for VlmSelector<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("VlmSelector").field("server", self.server).finish_non_exhaustive()
    }
}

impl ObjectSelector for VlmSelector<'_> {
    fn select(&self, input: SelectInput<'_>, watch: &dyn Watch) -> Result<Vec<Proposal>, SelectError> {
        let answer = self.ask(input, watch)?;
        Ok(match answer.said {
            Said::Object(object) => vec![self.proposal(object)],
            Said::Nothing(_) | Said::Unusable(_) => Vec::new(),
        })
    }
}

impl VlmSelector<'_> {
    /// Shows the model some frames and asks. What it answers is a guess like any other, also where it cannot be used.
    ///
    /// # Errors
    /// When no answer comes, a frame cannot be read or `watch` cancels.
    pub fn ask(&self, input: SelectInput<'_>, watch: &dyn Watch) -> Result<ObjectAnswer, VlmError> {
        let profile = self.server.profile;
        let most = Question::most_frames(profile);
        let question = Question {
            model: &self.server.model,
            profile,
            task: self.task,
            clip: self.clip,
            frames: frames::chosen(input.frames.frame_count(), input.landmarks, most),
            letterbox: Letterbox::new(input.frames.size()),
        };
        let request = question.hash();
        (self.say)(&format!(
            "asking {} at {} about {}; {}",
            self.server.model,
            self.server.url.host(),
            shown_frames(&question.frames),
            self.server.profile_line()
        ));
        let (raw, said) = self.converse(&question, &request, input, watch)?;
        Ok(ObjectAnswer {
            request,
            model: self.server.model.clone(),
            profile: profile.name().to_owned(),
            frames: question.frames,
            raw,
            said,
        })
    }

    fn converse(
        &self,
        question: &Question<'_>,
        seed: &str,
        input: SelectInput<'_>,
        watch: &dyn Watch,
    ) -> Result<(Vec<String>, Said), VlmError> {
        let arms = |frame: FrameIndex| {
            input
                .arms
                .frames
                .get(frame.as_usize())
                .map_or_else(|| Mask::new(input.frames.size()), |f| f.mask.decode())
        };
        let shown = Shown {
            profile: question.profile,
            frames: &question.frames,
            letterbox: &question.letterbox,
            arms: &arms,
        };
        let mut pictures = Vec::new();
        for frame in &question.frames {
            watch.check()?;
            pictures.push(picture::data_url(input.frames, *frame, &question.letterbox)?);
        }
        let mut connection = Connection::new(self.server, self.say)?;
        let mut messages = question.messages(&pictures);
        let mut raw = Vec::new();
        loop {
            let reply = connection.ask(&messages, seed, watch)?;
            let text = bounded(&self.without_key(&reply.text));
            let error = match self.understood(&reply, &shown) {
                Ok(said) => {
                    raw.push(text);
                    return Ok((raw, said));
                }
                Err(error) => self.without_key(&error),
            };
            (self.say)(&format!("the answer of {} cannot be used: {error}", self.server.model));
            messages.push(json!({"role": "assistant", "content": text}));
            messages.push(json!({"role": "user", "content": prompt::repair(&error, question.profile)}));
            raw.push(text);
            if raw.len() == TURNS {
                return Ok((raw, Said::Unusable(error)));
            }
        }
    }

    fn understood(&self, reply: &Reply, shown: &Shown<'_>) -> Result<Said, String> {
        let answer: Answer = match parse(&reply.text, shown.profile) {
            Ok(answer) => answer,
            Err(_) if reply.is_cut_off => {
                return Err("it was cut off before its end: answer shorter".to_owned());
            }
            Err(error) => return Err(error.to_string()),
        };
        if !answer.found {
            let reason = line(&self.without_key(answer.reason.as_deref().unwrap_or_default()), 300);
            let none = || "the model gave no reason".to_owned();
            return Ok(Said::Nothing(if reason.is_empty() { none() } else { reason }));
        }
        let selection = validate(&answer, shown).map_err(|error| error.to_string())?;
        for remark in &selection.remarks {
            (self.say)(&format!("answer of {}: {remark}", self.server.model));
        }
        Ok(Said::Object(self.object(selection)))
    }

    fn object(&self, selection: Selection) -> ObjectProposal {
        ObjectProposal {
            label: self.without_key(&selection.label),
            frame: selection.frame,
            prompt: match selection.place {
                Place::Box(bounds) => ObjectPromptKind::Box(bounds),
                Place::Point(at) => ObjectPromptKind::Points { positive: vec![at], negative: Vec::new() },
            },
            confidence: selection.confidence,
            reason: self.without_key(&selection.reason),
            author: Author::Machine(self.server.backend()),
        }
    }

    fn proposal(&self, object: ObjectProposal) -> Proposal {
        let (bounds, point) = match &object.prompt {
            ObjectPromptKind::Box(bounds) => (*bounds, None),
            ObjectPromptKind::Points { positive, .. } => {
                let at = positive.first().copied().unwrap_or_default();
                (PixelBox::from_corners(at, at).grown(AROUND_POINT), Some(at))
            }
        };
        let ObjectProposal { label, frame, confidence, reason, .. } = object;
        Proposal { frame, bounds, point, label, confidence, reason, backend: self.server.backend() }
    }

    fn without_key(&self, text: &str) -> String {
        self.server.key.as_ref().map_or_else(|| text.to_owned(), |key| key.struck_out(text))
    }
}

/// Whether `answer` is one to the question that would be asked about this clip now: of `model` and in `profile`, where
/// these are given, and with the same words about the same frames. Frames are those that were shown then, so that a
/// better choice of frames does not make an answer void.
pub fn answers(
    answer: &ObjectAnswer,
    task: Option<&str>,
    clip: &str,
    size: Size,
    (model, profile): (Option<&str>, Option<Profile>),
) -> bool {
    let Ok(kept) = answer.profile.parse::<Profile>() else { return false };
    let question = Question {
        model: &answer.model,
        profile: kept,
        task,
        clip,
        frames: answer.frames.clone(),
        letterbox: Letterbox::new(size),
    };
    model.is_none_or(|model| model == answer.model)
        && profile.is_none_or(|profile| profile == kept)
        && question.hash() == answer.request
}

fn shown_frames(frames: &[FrameIndex]) -> String {
    let numbers = frames.iter().map(|frame| frame.0.to_string()).collect::<Vec<_>>().join(", ");
    if frames.len() == 1 { format!("frame {numbers}") } else { format!("frames {numbers}") }
}

fn bounded(text: &str) -> String {
    let end = text.floor_char_boundary(LONGEST_KEPT);
    if end == text.len() { text.to_owned() } else { format!("{}…", &text[..end]) }
}
