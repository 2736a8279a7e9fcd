//! Synthetic episodes: a table, an object and human-like hands, rendered with MuJoCo, with exact truth.
//!
//! [`generate`] writes an episode to a folder, [`Episode::load`] reads it back. World axes: x right,
//! y away from the person, z up, origin on the table below the camera; metres.

mod episode;
pub mod error_model;
mod generate;
mod grasp;
mod hand_shape;
mod implicit;
mod motion;
mod motion_only;
mod object;
mod pictures;
mod scene;
mod skin;
mod spec;
mod texture;
mod truth;

pub use episode::Episode;
pub use generate::generate;
pub use grasp::GraspKind;
pub use hand_shape::{HandPose, HandShape};
pub use motion_only::{MotionTruth, motion_truth};
pub use object::ObjectKind;
pub use spec::{EpisodeSpec, HELD_OUT_SEED, SynthError, TUNING_SEEDS};
pub use texture::{Finish, Surface};
pub use truth::{EpisodeTruth, FrameTruth, HandTruth};
