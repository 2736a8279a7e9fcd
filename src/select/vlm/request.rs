//! The question as it is sent, and its hash.

use serde::Serialize;
use serde_json::{Value, json};

use super::{letterbox::Letterbox, profile::Profile, prompt};
use crate::{clip::FrameIndex, geometry::Size};

/// Most pictures in one question.
const MOST_PICTURES: usize = 4;
/// Longest answer asked for, tokens.
const MAX_TOKENS: u32 = 600;
/// Counts up when the wording or the pictures change, so that kept answers are known to be of another question.
const VERSION: u32 = 1;

/// Everything that decides what a model is asked.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Question<'a> {
    pub model: &'a str,
    pub profile: Profile,
    /// The task in one sentence.
    pub task: Option<&'a str>,
    /// What the pictures are taken from: the file's hash and how it was cut and turned.
    pub clip: &'a str,
    /// Which frames, in order.
    pub frames: Vec<FrameIndex>,
    pub letterbox: Letterbox,
}

impl Question<'_> {
    /// How many frames a model of `profile` is shown.
    pub const fn most_frames(profile: Profile) -> usize {
        if profile.is_point() { 1 } else { MOST_PICTURES }
    }

    fn words(&self) -> String {
        prompt::question(self.task, &self.frames, self.profile, self.letterbox.sent)
    }

    /// Hexadecimal blake3 of what decides about the answer. Pictures enter by clip and frame, not by their bytes: the
    /// same question has the same hash whatever library compresses them. Neither the key nor the address enters.
    pub fn hash(&self) -> String {
        let Size { width, height } = self.letterbox.sent;
        let parts = json!([
            VERSION,
            self.model,
            self.profile,
            prompt::SYSTEM,
            self.words(),
            self.clip,
            self.frames,
            [width, height],
        ]);
        blake3::hash(parts.to_string().as_bytes()).to_hex().to_string()
    }

    /// The messages, with `pictures` as data addresses in the order of the frames.
    pub fn messages(&self, pictures: &[String]) -> Vec<Value> {
        let text = |text: String| json!({"type": "text", "text": text});
        let mut content = vec![text(self.words())];
        for (frame, picture) in self.frames.iter().zip(pictures) {
            content.push(text(format!("frame {}", frame.0)));
            content.push(json!({"type": "image_url", "image_url": {"url": picture}}));
        }
        vec![
            json!({"role": "system", "content": prompt::SYSTEM}),
            json!({"role": "user", "content": content}),
        ]
    }
}

/// How the answer's form is asked for. Servers differ; each step asks less.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ResponseFormat {
    /// By the schema.
    JsonSchema,
    /// Some JSON.
    JsonObject,
    /// By the words alone.
    Plain,
}

impl ResponseFormat {
    /// Where a model of `profile` begins: points are not JSON.
    pub const fn first(profile: Profile) -> Self {
        if profile.is_point() { Self::Plain } else { Self::JsonSchema }
    }

    /// What is tried when a server refuses this one.
    pub const fn next(self) -> Option<Self> {
        match self {
            Self::JsonSchema => Some(Self::JsonObject),
            Self::JsonObject => Some(Self::Plain),
            Self::Plain => None,
        }
    }

    pub const fn name(self) -> &'static str {
        match self {
            Self::JsonSchema => "json_schema",
            Self::JsonObject => "json_object",
            Self::Plain => "plain text",
        }
    }

    fn value(self) -> Option<Value> {
        match self {
            Self::JsonSchema => Some(json!({
                "type": "json_schema",
                "json_schema": {"name": "object_selection", "strict": true, "schema": prompt::schema()}
            })),
            Self::JsonObject => Some(json!({"type": "json_object"})),
            Self::Plain => None,
        }
    }
}

/// The body of a request.
#[derive(Serialize)]
struct Body<'a> {
    model: &'a str,
    temperature: u32,
    max_tokens: u32,
    stream: bool,
    messages: &'a [Value],
    #[serde(skip_serializing_if = "Option::is_none")]
    response_format: Option<Value>,
}

/// The bytes of a request.
///
/// # Errors
/// When they cannot be written as JSON.
pub(super) fn body(model: &str, messages: &[Value], format: ResponseFormat) -> serde_json::Result<Vec<u8>> {
    let response_format = format.value();
    let body =
        Body { model, temperature: 0, max_tokens: MAX_TOKENS, stream: false, messages, response_format };
    serde_json::to_vec(&body)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn question(frames: &[u32]) -> Question<'static> {
        Question {
            model: "m",
            profile: Profile::default(),
            task: Some("put the cup away"),
            clip: "hash",
            frames: frames.iter().copied().map(FrameIndex).collect(),
            letterbox: Letterbox::new(Size::new(640, 480)),
        }
    }

    #[test]
    fn pictures_follow_their_numbers_in_one_message() {
        let pictures = ["data:1".to_owned(), "data:2".to_owned()];
        let messages = question(&[3, 9]).messages(&pictures);
        let content = messages[1]["content"].as_array().unwrap();
        assert_eq!(content.len(), 5);
        assert_eq!(
            (&content[3]["text"], &content[4]["image_url"]["url"]),
            (&json!("frame 9"), &json!("data:2"))
        );
        let body = body("m", &messages, ResponseFormat::JsonSchema).unwrap();
        let body: Value = serde_json::from_slice(&body).unwrap();
        assert_eq!(body["temperature"], 0);
        assert_eq!(
            body["response_format"]["json_schema"]["schema"]["required"].as_array().unwrap().len(),
            12
        );
    }

    #[test]
    fn another_question_has_another_hash() {
        let one = question(&[0, 5]);
        assert_eq!(one.hash(), question(&[0, 5]).hash());
        let others = [
            question(&[0, 6]),
            Question { task: None, ..question(&[0, 5]) },
            Question { model: "n", ..question(&[0, 5]) },
            Question { clip: "other", ..question(&[0, 5]) },
            Question { profile: Profile::Rel1000Yxyx, ..question(&[0, 5]) },
        ];
        assert!(others.iter().all(|other| other.hash() != one.hash()));
    }
}
