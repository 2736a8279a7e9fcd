//! Hand landmarks as an estimator sees them: plain data that several stages read.
//!
//! They live beside [`crate::geometry`] because segmentation needs them before the hand stage
//! has made metric hands of them.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::geometry::{PerSide, Pixel};

/// Keypoints a hand, in the OpenPose order: 0 wrist; 1–4 thumb CMC, MCP, IP, tip;
/// 5–8 index MCP, PIP, DIP, tip; 9–12 middle; 13–16 ring; 17–20 pinky.
pub const KEYPOINT_COUNT: usize = 21;

/// Indices into the 21 keypoints.
pub mod keypoint {
    /// Wrist.
    pub const WRIST: usize = 0;
    /// Bases of the five fingers: thumb CMC, then the MCPs.
    pub const BASES: [usize; 5] = [1, 5, 9, 13, 17];
    /// Tips, thumb to pinky.
    pub const TIPS: [usize; 5] = [4, 8, 12, 16, 20];
    /// The parent of every keypoint; the wrist is its own.
    pub const PARENT: [usize; 21] = [0, 0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 0, 13, 14, 15, 0, 17, 18, 19];
}

/// One hand on one frame as the estimator saw it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandLandmarks {
    /// Keypoints in pixels of the clip.
    pub keypoints: [Pixel; KEYPOINT_COUNT],
    /// Keypoints relative to the hand's centre, metres, camera axes, where the estimator gives them:
    /// a prior for the pose of the fingers, not for depth.
    pub world: Option<[Vector3<f64>; KEYPOINT_COUNT]>,
    /// Trust, 0 to 1.
    pub confidence: f64,
}

/// Landmarks of both hands for every frame; `None` where a hand was not seen.
pub type LandmarkTrack = Vec<PerSide<Option<HandLandmarks>>>;
