//! Tracks of both hands: 21 keypoints a hand and frame, in pixels and in metric camera space.

use serde::{Deserialize, Serialize};

use crate::{
    clip::FrameIndex,
    geometry::{Camera, PerSide, Pixel, Position},
    landmarks::{KEYPOINT_COUNT, keypoint},
};

/// Where a hand on a frame comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HandState {
    /// Seen by the estimator, imported, or placed by a person.
    Observed,
    /// Interpolated over a short gap.
    Bridged,
    /// Not known: nothing downstream may use it.
    Invalid,
}

/// One hand on one frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandFrame {
    /// Where it comes from.
    pub state: HandState,
    /// Trust, 0 to 1.
    pub confidence: f64,
    /// Keypoints as seen, pixels of the clip; reprojections where imported or bridged.
    pub keypoints: [Pixel; KEYPOINT_COUNT],
    /// Keypoints in the camera frame, metres.
    pub joints: [Position<Camera>; KEYPOINT_COUNT],
}

impl HandFrame {
    /// A hand that is not there.
    pub fn invalid() -> Self {
        Self {
            state: HandState::Invalid,
            confidence: 0.0,
            keypoints: [Pixel::default(); KEYPOINT_COUNT],
            joints: [Position::default(); KEYPOINT_COUNT],
        }
    }

    /// Whether downstream stages may use it.
    pub fn is_valid(&self) -> bool {
        self.state != HandState::Invalid
    }

    /// The wrist in metres.
    pub fn wrist(&self) -> Position<Camera> {
        self.joints[keypoint::WRIST]
    }
}

/// Both hands over a clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandTrack {
    /// One a frame and side, in order.
    pub hands: PerSide<Vec<HandFrame>>,
    /// Fitted hand length of each side, metres (wrist to middle tip, straight), where known.
    pub hand_length: PerSide<Option<f64>>,
    /// The back end that made it, as the record names it, for example `mediapipe`.
    pub backend: String,
}

impl HandTrack {
    /// Number of frames.
    pub fn frame_count(&self) -> usize {
        self.hands.left.len()
    }

    /// The hands on a frame.
    ///
    /// # Panics
    /// When `index` is beyond the clip the track was made for.
    pub fn at(&self, index: FrameIndex) -> PerSide<&HandFrame> {
        PerSide { left: &self.hands.left[index.as_usize()], right: &self.hands.right[index.as_usize()] }
    }
}
