//! What the operator may turn.

use serde::{Deserialize, Serialize};

use crate::{
    clip::FrameIndex,
    geometry::{Pixel, PixelBox},
    segment::RleMask,
};

/// What a person (or a proposal) says about the object on one frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectPrompt {
    /// The frame it speaks of.
    pub frame: FrameIndex,
    /// What it says.
    pub kind: PromptKind,
    /// Whether it is spread to earlier and to later frames.
    pub reach: (bool, bool),
}

impl ObjectPrompt {
    /// A prompt that is spread both ways.
    pub fn new(frame: FrameIndex, kind: PromptKind) -> Self {
        Self { frame, kind, reach: (true, true) }
    }
}

/// A prompt in pixels of the clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PromptKind {
    /// A box around the object's visible part.
    Box(PixelBox),
    /// Points on the object and off it.
    Points {
        /// On the object, at least one.
        positive: Vec<Pixel>,
        /// Not on the object.
        negative: Vec<Pixel>,
    },
    /// The visible part itself.
    Mask {
        /// The mask, of the clip's size.
        mask: RleMask,
        /// Whether a person drew or confirmed it; such a mask is never changed.
        human: bool,
    },
}

/// Parameters of classical object tracking.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObjectParams {
    /// Longest side of the pictures worked on, pixels; 640 by default.
    pub work_side: u32,
    /// Smoothness of mask borders: weight of edge length against colour evidence; 1.6 by default.
    pub smoothness: f64,
    /// Weight of the rigidly carried shape against colour evidence; 1 by default.
    pub rigidity: f64,
    /// Visible share of the shape below which the object counts as occluded; 0.25 by default.
    pub occluded_share: f64,
}

impl Default for ObjectParams {
    fn default() -> Self {
        Self { work_side: 640, smoothness: 1.6, rigidity: 1.0, occluded_share: 0.25 }
    }
}
