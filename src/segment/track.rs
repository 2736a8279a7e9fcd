//! What segmentation hands on: one mask a frame, who made it, how far to trust it.

use serde::{Deserialize, Serialize};

use super::RleMask;
use crate::{
    clip::FrameIndex,
    geometry::{PerSide, Side, Size},
};

/// Who made a mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaskAuthor {
    /// A person drew or confirmed it: never overwritten by a model.
    Human,
    /// Made on this very frame from a prompt (box, points) or from hand landmarks.
    Seeded,
    /// Propagated from another frame.
    Propagated,
}

/// What is doubtful about a mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaskFlag {
    /// The area left [0.6, 1.6] of the trusted area.
    AreaJump,
    /// Low IoU with the previous mask warped along the flow.
    LowOverlap,
    /// The colours inside no longer resemble the model.
    ColourDrift,
    /// The mask touches the picture's border.
    TouchesBorder,
    /// Mostly hidden: the mask is carried along, not seen.
    Occluded,
    /// The object was not found on this frame.
    Lost,
}

/// One frame of a mask track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaskFrame {
    /// The visible part.
    pub mask: RleMask,
    /// Who made it.
    pub author: MaskAuthor,
    /// Trust, 0 to 1.
    pub score: f64,
    /// What is doubtful, sorted, none twice.
    pub flags: Vec<MaskFlag>,
}

impl MaskFrame {
    /// Whether the mask may teach models and anchor others.
    pub fn is_trusted(&self) -> bool {
        self.author == MaskAuthor::Human || (self.score >= 0.5 && !self.flags.contains(&MaskFlag::Lost))
    }
}

/// A mask for every frame of a clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaskTrack {
    /// The clip's picture size.
    pub size: Size,
    /// One a frame, in order.
    pub frames: Vec<MaskFrame>,
    /// The back end that made it, as the record names it, for example `classical`.
    pub backend: String,
}

impl MaskTrack {
    /// The frame at `index`.
    ///
    /// # Panics
    /// When `index` is beyond the clip the track was made for.
    pub fn frame(&self, index: FrameIndex) -> &MaskFrame {
        &self.frames[index.as_usize()]
    }
}

/// Everything of the human that must vanish, on every frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmTrack {
    /// Both arms: hand, forearm, sleeve.
    pub union: MaskTrack,
    /// The union split by side, one a frame; pixels that no known hand claims are in neither.
    pub sides: PerSide<Vec<RleMask>>,
}

impl ArmTrack {
    /// The arms without what the object's mask shows of it: where both claim a pixel, the object was told from the arm by
    /// what is known of it. Masks that a person drew stay as they are.
    #[must_use]
    pub fn without(&self, object: &MaskTrack) -> Self {
        let mut arms = self.clone();
        for (index, (arm, object)) in arms.union.frames.iter_mut().zip(&object.frames).enumerate() {
            if arm.author != MaskAuthor::Human {
                arm.mask = arm.mask.minus(&object.mask);
                for side in Side::BOTH {
                    arms.sides[side][index] = arms.sides[side][index].minus(&object.mask);
                }
            }
        }
        arms
    }
}
