//! Tracks of both hands: 21 keypoints a hand and frame, in pixels and in metric camera space.

use nalgebra::UnitQuaternion;
use serde::{Deserialize, Serialize};

use crate::{
    clip::FrameIndex,
    geometry::{Camera, PerSide, Pixel, Position, Side},
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

/// A hand's pose as MANO's model has it, where a network gives it. Axes are the camera's; a left hand's rotations are those
/// of the left model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ManoHand {
    /// Orientation of the whole hand.
    pub orientation: UnitQuaternion<f64>,
    /// Rotations of the 15 finger joints, each relative to its parent: index, middle, pinky, ring, thumb, from base to tip.
    pub fingers: [UnitQuaternion<f64>; 15],
    /// The shape's ten coefficients.
    pub shape: Option<[f64; 10]>,
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
    /// MANO's rotations, where the back end gives them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mano: Option<Box<ManoHand>>,
}

impl HandFrame {
    /// A hand that is not there.
    pub fn invalid() -> Self {
        Self {
            state: HandState::Invalid,
            confidence: 0.0,
            keypoints: [Pixel::default(); KEYPOINT_COUNT],
            joints: [Position::default(); KEYPOINT_COUNT],
            mano: None,
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

    /// Moves every hand along its rays to where it is `length` metres long from wrist to middle tip: what is seen stays.
    /// Sides whose length is not known stay where they are.
    pub fn set_length(&mut self, length: f64) {
        for side in Side::BOTH {
            let Some(known) = self.hand_length[side].filter(|known| *known > 0.0) else { continue };
            for joint in self.hands[side].iter_mut().flat_map(|hand| &mut hand.joints) {
                joint.xyz *= length / known;
            }
            self.hand_length[side] = Some(length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_of_an_older_track_has_no_rotations() {
        let mut frame = serde_json::to_value(HandFrame::invalid()).unwrap();
        assert!(frame.get("mano").is_none());
        frame["state"] = "observed".into();
        let read: HandFrame = serde_json::from_value(frame).unwrap();
        assert_eq!((read.state, read.mano), (HandState::Observed, None));
    }

    #[test]
    fn rotations_are_kept_in_the_file() {
        let turned = UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3);
        let mano = ManoHand { orientation: turned, fingers: [turned; 15], shape: Some([0.5; 10]) };
        let frame = HandFrame { mano: Some(Box::new(mano)), ..HandFrame::invalid() };
        let text = serde_json::to_string(&frame).unwrap();
        assert_eq!(serde_json::from_str::<HandFrame>(&text).unwrap(), frame);
    }
}
