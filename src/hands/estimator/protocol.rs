//! The messages of the protocol `agenticfocus-hands/1`.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{
    geometry::{Pixel, Side},
    hands::detection::Detection,
    landmarks::KEYPOINT_COUNT,
};

/// Name and version of the protocol.
pub const PROTOCOL: &str = "agenticfocus-hands/1";

/// How a picture relates to the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::hands) enum Mode {
    /// The next frame of the clip.
    Track,
    /// A picture on its own.
    Single,
}

/// What the estimator says first.
#[derive(Debug, Deserialize)]
pub(super) struct Hello {
    pub protocol: String,
    #[serde(default)]
    pub name: String,
}

/// What the host answers.
#[derive(Debug, Serialize)]
pub(super) struct Welcome {
    pub protocol: &'static str,
    pub frames: usize,
}

/// The line before a picture's bytes.
#[derive(Debug, Serialize)]
pub(super) struct Header {
    pub id: u64,
    pub frame: u32,
    pub mode: Mode,
    pub width: u32,
    pub height: u32,
}

/// The hands of one picture.
#[derive(Debug, Deserialize)]
pub(super) struct Answer {
    id: u64,
    hands: Vec<WireHand>,
}

#[derive(Debug, Deserialize)]
struct WireHand {
    side: Side,
    score: f64,
    keypoints: Vec<[f64; 2]>,
    #[serde(default)]
    world: Option<Vec<[f64; 3]>>,
}

impl Answer {
    /// The hands, keypoints in pixels of the picture that was sent.
    ///
    /// # Errors
    /// A sentence about what is wrong: another request's answer, a count other than 21, a value
    /// that is not finite.
    pub fn into_detections(self, request: u64) -> Result<Vec<Detection>, String> {
        if self.id != request {
            return Err(format!("id is {}, expected {request}", self.id));
        }
        self.hands.into_iter().map(WireHand::into_detection).collect()
    }
}

impl WireHand {
    fn into_detection(self) -> Result<Detection, String> {
        if !(0.0..=1.0).contains(&self.score) {
            return Err(format!("score is {}, expected 0 to 1", self.score));
        }
        let keypoints: [[f64; 2]; KEYPOINT_COUNT] = self
            .keypoints
            .try_into()
            .map_err(|k: Vec<_>| format!("{} keypoints, expected {KEYPOINT_COUNT}", k.len()))?;
        let world: Option<[[f64; 3]; KEYPOINT_COUNT]> = match self.world {
            None => None,
            Some(world) => Some(
                world
                    .try_into()
                    .map_err(|w: Vec<_>| format!("{} world points, expected {KEYPOINT_COUNT}", w.len()))?,
            ),
        };
        // 1e6 px and 10 m are far outside any picture or hand and keep later squares finite.
        let sane = keypoints.as_flattened().iter().all(|v| v.abs() < 1e6)
            && world.iter().flat_map(|w| w.as_flattened()).all(|v| v.abs() < 10.0);
        if !sane {
            return Err("a keypoint is not finite or out of all bounds".to_owned());
        }
        Ok(Detection {
            side: self.side,
            score: self.score,
            keypoints: keypoints.map(|[x, y]| Pixel::new(x, y)),
            world: world.map(|w| w.map(|p| Vector3::from_row_slice(&p))),
        })
    }
}
