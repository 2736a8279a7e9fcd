//! What to make, and why it could not be made.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{grasp::GraspKind, object::ObjectKind};
use crate::{geometry::Size, progress::Cancelled};

/// One synthetic episode. Everything not stated is drawn from the seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EpisodeSpec {
    /// The same seed makes the same bytes on the same renderer.
    pub seed: u64,
    /// Picture size, pixels.
    pub size: Size,
    /// Number of frames at 30 frames a second.
    pub frames: u32,
    /// The object; drawn when none.
    pub object: Option<ObjectKind>,
    /// The grasp; the object's natural one when none.
    pub grasp: Option<GraspKind>,
    /// Whether the second hand is there too; drawn when none.
    pub both_hands: Option<bool>,
    /// Standard deviation of the sensor noise, 8-bit steps.
    pub noise: f64,
    /// x264's constant rate factor; lower is better.
    pub crf: u32,
}

impl Default for EpisodeSpec {
    /// Seed 0, 640×480, 135 frames, noise 1.5, rate factor 14.
    fn default() -> Self {
        Self {
            seed: 0,
            size: Size::new(640, 480),
            frames: 135,
            object: None,
            grasp: None,
            both_hands: None,
            noise: 1.5,
            crf: 14,
        }
    }
}

/// Seeds that may be used to tune parameters: whatever was looked at before is among them.
pub const TUNING_SEEDS: std::ops::RangeInclusive<u64> = 1..=3099;
/// First of the seeds that scores are reported on.
pub const HELD_OUT_SEED: u64 = 3100;

/// Why an episode could not be made or read.
#[derive(Debug, thiserror::Error)]
pub enum SynthError {
    /// Too small, odd or no frames.
    #[error(
        "an episode of {frames} frames of {size}: expected at least 2 frames of even sides, 64 to 4096 pixels"
    )]
    Spec {
        /// Asked for.
        size: Size,
        /// Asked for.
        frames: u32,
    },
    /// MuJoCo refused the scene.
    #[error("MuJoCo refused the synthetic scene: {0}")]
    Scene(String),
    /// The renderer failed.
    #[error(transparent)]
    Render(#[from] crate::render::RenderError),
    /// A file failed.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The video encoder failed.
    #[error("ffmpeg could not write {path}: {reason}; `ffmpeg` with libx264 must be on the path")]
    Encoder {
        /// The video.
        path: PathBuf,
        /// What it said.
        reason: String,
    },
    /// A truth file holds something else.
    #[error("{path} is not what a synthetic episode holds: {reason}")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What was found.
        reason: String,
    },
    /// No longer wanted.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl SynthError {
    pub(super) fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::Io { path, source }
    }

    pub(super) fn damaged(path: impl Into<PathBuf>, reason: impl ToString) -> Self {
        Self::Damaged { path: path.into(), reason: reason.to_string() }
    }
}
