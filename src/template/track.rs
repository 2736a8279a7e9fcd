//! What the template stage hands on: the whole object, and where it goes on every frame.

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

use crate::{clip::FrameIndex, image::Rgba8};

/// Where the template goes on one frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Takes template pixels (x, y, 1) to frame pixels; a similarity or a homography.
    pub transform: Matrix3<f64>,
    /// Trust, 0 to 1; 0 where nothing of the object was seen and no neighbour helps.
    pub confidence: f64,
    /// Share of the object's full shape that is visible on this frame, 0 to 1.
    pub visible: f64,
}

/// The object cut whole out of a clean frame, and its placements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TemplateTrack {
    /// The object with soft alpha; pixels are those of the clean frame's crop.
    pub picture: Rgba8,
    /// Column and row of the crop's top-left pixel on the clean frame.
    pub origin: (u32, u32),
    /// The clean frame.
    pub frame: FrameIndex,
    /// One a frame, in order; `None` where the object is absent.
    pub placements: Vec<Option<Placement>>,
    /// Clean-frame score of every frame, 0 to 1.
    pub scores: Vec<f64>,
}
