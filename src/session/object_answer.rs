//! What a model answered that was asked which object a clip is about.

use serde::{Deserialize, Serialize};

use super::ObjectProposal;
use crate::clip::FrameIndex;

/// A question to a vision-language model and what came of it, kept so that the same question need not be asked again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectAnswer {
    /// blake3 of the question, hexadecimal: model, words, clip, frames.
    pub request: String,
    /// The model, as its server calls it.
    pub model: String,
    /// How it was taken to write coordinates, by the profile's name.
    pub profile: String,
    /// The frames it was shown.
    pub frames: Vec<FrameIndex>,
    /// What it wrote, a text for each time it was asked; long ones are cut.
    pub raw: Vec<String>,
    /// What that was understood to mean.
    pub said: Said,
}

/// What an answer means.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Said {
    /// This object.
    Object(ObjectProposal),
    /// There is none; why, in the model's words.
    Nothing(String),
    /// Nothing that can be used; why.
    Unusable(String),
}
