//! What is exactly known of an episode.

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use super::{grasp::GraspKind, object::ObjectKind, spec::EpisodeSpec, texture::Finish};
use crate::{
    geometry::{Camera, PerSide, Pinhole, Pixel, Position, Side},
    landmarks::KEYPOINT_COUNT,
};

/// One hand on one frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandTruth {
    /// 21 joints in the camera frame, metres.
    pub joints: [Position<Camera>; KEYPOINT_COUNT],
    /// Their projections, pixels.
    pub keypoints: [Pixel; KEYPOINT_COUNT],
    /// Whether the wrist and at least 15 joints lie inside the picture.
    pub in_view: bool,
    /// Whether it holds the object.
    pub contact: bool,
}

/// One frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameTruth {
    /// Camera (OpenCV axes) to world (x right, y away, z up; origin on the table below the camera), metres.
    pub camera_to_world: Isometry3<f64>,
    /// The object's frame in the camera frame.
    pub object_to_camera: Isometry3<f64>,
    /// The hands that exist in this episode, seen or not.
    pub hands: PerSide<Option<HandTruth>>,
    /// Share of the object's full shape (inside the picture) that is hidden, 0 to 1.
    pub object_hidden: f64,
    /// Column and row of the stored crop's top-left pixel, its width and height.
    pub crop: [u32; 4],
}

/// All that is known of an episode beside its pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeTruth {
    /// 1.
    pub version: u32,
    /// What was asked for.
    pub spec: EpisodeSpec,
    /// Intrinsics.
    pub pinhole: Pinhole,
    /// Wrist to middle fingertip along the bones, straight, metres; both hands.
    pub hand_length: f64,
    /// The object.
    pub object: ObjectKind,
    /// Its paint.
    pub finish: Finish,
    /// The grasp.
    pub grasp: GraspKind,
    /// The hand that moves the object.
    pub moving_side: Side,
    /// Whether the arms have sleeves.
    pub sleeves: bool,
    /// One a frame.
    pub frames: Vec<FrameTruth>,
}
