//! What a session knows about its clip: everything a person or a manifest decided.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

use super::{Author, MaskId, ObjectAnswer, RetargetSettings, Step};
use crate::{
    clip::{CameraSpec, FrameIndex, Rotation},
    geometry::{PerSide, Pixel, PixelBox},
};

/// The clip a session is about.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClipReference {
    /// The clip's id: the name of its output folder.
    pub id: String,
    /// Absolute path of the video file.
    pub path: String,
    /// blake3 of the file's bytes as hexadecimal; empty until it was decoded once.
    pub content_hash: String,
    /// Clockwise rotation after decoding.
    pub rotate: Rotation,
    /// First second of the source to use (default: its start).
    pub start: Option<f64>,
    /// Last second of the source to use (default: its end).
    pub end: Option<f64>,
}

/// How an object was pointed at, in pixels of the standardised clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObjectPromptKind {
    /// A box around it.
    Box(PixelBox),
    /// Points on it and points beside it.
    Points {
        /// On the object.
        positive: Vec<Pixel>,
        /// Not on the object.
        negative: Vec<Pixel>,
    },
}

/// An object somebody could mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectProposal {
    /// What it is called.
    pub label: String,
    /// The frame it is pointed at on.
    pub frame: FrameIndex,
    /// How it is pointed at.
    pub prompt: ObjectPromptKind,
    /// Trust, 0 to 1.
    pub confidence: f64,
    /// Why, in one line.
    pub reason: String,
    /// Who proposed it.
    pub author: Author,
}

impl ObjectProposal {
    /// The same thing as a person's choice: no later guess replaces it.
    #[must_use]
    pub fn taken_by_person(self) -> Self {
        Self { confidence: 1.0, author: Author::Human, ..self }
    }

    /// Whether both point at the same place, whoever says so.
    pub fn points_where(&self, other: &Self) -> bool {
        self.frame == other.frame && self.prompt == other.prompt
    }
}

/// The object the clip is about, and who said so.
pub type ObjectChoice = ObjectProposal;

/// The two mask layers a person edits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaskLayer {
    /// The manipulated object, its visible part.
    Object,
    /// Hands, arms and sleeves.
    Arms,
}

/// What a person said about a mask on one frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaskEdit {
    /// This is the mask.
    Mask(MaskId),
    /// There is nothing of it on this frame.
    Absent,
}

/// Which way a mask that a person made of the object is spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MaskReach {
    /// To earlier frames (default: yes).
    pub backward: bool,
    /// To later frames (default: yes).
    pub forward: bool,
}

impl Default for MaskReach {
    fn default() -> Self {
        Self { backward: true, forward: true }
    }
}

/// What a person said about the template.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TemplateEdits {
    /// The clean frame to cut it from.
    pub frame: Option<FrameIndex>,
    /// Its mask on that frame.
    pub mask: Option<MaskId>,
    /// Placements set by hand: template pixels to frame pixels.
    pub placements: BTreeMap<FrameIndex, Matrix3<f64>>,
    /// Keyframes from which the placement runs straight to the next one, over the frames between.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub interpolated: BTreeSet<FrameIndex>,
}

impl TemplateEdits {
    /// The keyframe at or before `frame` and the one after it, with their placements; `None` where either is missing.
    pub fn keyframes_around(&self, frame: FrameIndex) -> Option<[(FrameIndex, &Matrix3<f64>); 2]> {
        let (first, from) = self.placements.range(..=frame).next_back()?;
        let (last, to) = self.placements.range(FrameIndex(frame.0.saturating_add(1))..).next()?;
        Some([(*first, from), (*last, to)])
    }

    /// Pairs of keyframes with interpolated frames between them, in order.
    pub fn interpolated_spans(&self) -> impl Iterator<Item = (FrameIndex, FrameIndex)> {
        let frames = self.placements.keys().zip(self.placements.keys().skip(1));
        frames.filter(|(first, _)| self.interpolated.contains(first)).map(|(first, last)| (*first, *last))
    }
}

/// What a person said about one hand on one frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandEdit {
    /// Keypoints that were dragged, by index 0 to 20.
    pub keypoints: BTreeMap<u8, Pixel>,
    /// The hand is not usable here.
    pub invalid: bool,
}

/// Frames on which the estimator took left for right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SidesSwapped {
    /// First frame.
    pub first: FrameIndex,
    /// Last frame, inclusive.
    pub last: FrameIndex,
}

/// Which of hand and object lies in front.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LayerOrder {
    /// Decided by contact and the evidence in the source frame (default).
    #[default]
    Auto,
    /// The robot covers the object.
    RobotInFront,
    /// The object covers the robot, the thumb excepted where its pass is on.
    ObjectInFront,
}

/// A layer order over a range of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LayerOrderRange {
    /// First frame.
    pub first: FrameIndex,
    /// Last frame, inclusive.
    pub last: FrameIndex,
    /// The order.
    pub order: LayerOrder,
    /// Thumb pass on or off; `None` leaves it to the contact.
    pub thumb: Option<bool>,
}

/// Where a clip stands with its curator.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "state")]
pub enum ReviewState {
    /// Nobody looked yet (default).
    #[default]
    Unreviewed,
    /// The machine asks for a look.
    NeedsReview {
        /// Why.
        reason: String,
    },
    /// Good.
    Accepted,
    /// Not to be used.
    Rejected {
        /// Why.
        reason: String,
        /// Anything else.
        note: String,
    },
    /// To be looked at again.
    Flagged {
        /// Why.
        reason: String,
        /// Anything else.
        note: String,
    },
}

/// Everything that was decided about one clip.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Document {
    /// The clip.
    pub clip: ClipReference,
    /// The task in one sentence.
    pub task: Option<String>,
    /// The source camera.
    pub camera: CameraSpec,
    /// Objects that were proposed, best first.
    pub proposals: Vec<ObjectProposal>,
    /// What a model answered that was asked for the object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object_answer: Option<ObjectAnswer>,
    /// The object that was chosen.
    pub object: Option<ObjectChoice>,
    /// Masks a person made of the object.
    pub object_masks: BTreeMap<FrameIndex, MaskEdit>,
    /// Which way those are spread, where it is not both.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub object_reach: BTreeMap<FrameIndex, MaskReach>,
    /// Masks a person made of the arms.
    pub arm_masks: BTreeMap<FrameIndex, MaskEdit>,
    /// How far the arms' masks are widened to make the hole in the background, as a share of the picture's width
    /// (default: [`InpaintParams::hole_dilation`](crate::inpaint::InpaintParams::hole_dilation)).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hole_dilation: Option<f64>,
    /// The template.
    pub template: TemplateEdits,
    /// A hand track to import instead of estimating, absolute path.
    pub hand_track: Option<String>,
    /// Hands a person corrected.
    pub hand_edits: PerSide<BTreeMap<FrameIndex, HandEdit>>,
    /// Ranges with left and right exchanged.
    pub sides_swapped: Vec<SidesSwapped>,
    /// Retargeting.
    pub retarget: RetargetSettings,
    /// Layer orders; later ones win.
    pub layer_orders: Vec<LayerOrderRange>,
    /// Steps a person confirmed.
    #[serde(default)]
    pub confirmed: BTreeSet<Step>,
    /// Review.
    pub review: ReviewState,
}

impl Document {
    /// The human masks of `layer`.
    pub fn masks(&self, layer: MaskLayer) -> &BTreeMap<FrameIndex, MaskEdit> {
        match layer {
            MaskLayer::Object => &self.object_masks,
            MaskLayer::Arms => &self.arm_masks,
        }
    }

    pub(super) fn masks_mut(&mut self, layer: MaskLayer) -> &mut BTreeMap<FrameIndex, MaskEdit> {
        match layer {
            MaskLayer::Object => &mut self.object_masks,
            MaskLayer::Arms => &mut self.arm_masks,
        }
    }
}
