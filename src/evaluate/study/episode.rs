//! A hand track and what it is compared with.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{
    geometry::PerSide,
    hands::{HandState, HandTrack},
    landmarks::KEYPOINT_COUNT,
    synth::MotionTruth,
};

/// What is known of the human hands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReferenceKind {
    /// The truth.
    Truth,
    /// The track itself, since nothing better is known: what a method smooths out of it counts as error.
    Track,
}

impl ReferenceKind {
    /// Its name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Truth => "truth",
            Self::Track => "track",
        }
    }
}

/// The human hands that a robot's are compared with.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Where they come from.
    pub kind: ReferenceKind,
    /// 21 joints in the camera frame, metres, one a frame; `None` where they are not known.
    pub joints: PerSide<Vec<Option<[Vector3<f64>; KEYPOINT_COUNT]>>>,
    /// Frames that count, where the track knows the hand at some time before and after: known, and in view.
    pub counts: PerSide<Vec<bool>>,
    /// Wrist to middle fingertip along the bones, metres.
    pub hand_length: PerSide<Option<f64>>,
}

/// One episode.
#[derive(Clone, Debug)]
pub struct Episode {
    /// Its name in reports, alone of its kind in a study.
    pub name: String,
    /// What every method gets.
    pub track: HandTrack,
    /// What it is compared with.
    pub reference: Reference,
}

impl Episode {
    /// A synthetic episode: a track that an estimator would have given, and the truth.
    pub fn with_truth(name: String, track: HandTrack, truth: &MotionTruth) -> Self {
        let joints = PerSide::from_fn(|side| {
            let hands = truth.frames.iter().map(|frame| frame[side].as_ref());
            hands.map(|hand| Some(hand?.joints.map(|joint| joint.xyz))).collect()
        });
        let counts = PerSide::from_fn(|side| {
            truth.frames.iter().map(|frame| frame[side].as_ref().is_some_and(|hand| hand.in_view)).collect()
        });
        let hand_length = PerSide::from_fn(|_| Some(truth.hand_length));
        Self { name, track, reference: Reference { kind: ReferenceKind::Truth, joints, counts, hand_length } }
    }

    /// A track without truth: compared with itself, where it is observed.
    pub fn of_track(name: String, track: HandTrack) -> Self {
        let joints = PerSide::from_fn(|side| {
            let hands = track.hands[side].iter();
            hands.map(|hand| hand.is_valid().then(|| hand.joints.map(|joint| joint.xyz))).collect()
        });
        let counts = PerSide::from_fn(|side| {
            track.hands[side].iter().map(|hand| hand.state == HandState::Observed).collect()
        });
        let hand_length = track.hand_length;
        Self { name, track, reference: Reference { kind: ReferenceKind::Track, joints, counts, hand_length } }
    }
}
