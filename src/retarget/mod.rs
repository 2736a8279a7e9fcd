//! Retargeting: camera-relative map, wrist corrections, inverse kinematics, smoothing, limits; and published
//! methods to compare with.

mod method;
mod motion;

#[cfg(feature = "engine")]
mod banded;
#[cfg(feature = "engine")]
mod baselines;
#[cfg(feature = "engine")]
mod beta;
mod error;
#[cfg(feature = "engine")]
mod filter;
#[cfg(feature = "engine")]
mod fingers;
#[cfg(feature = "engine")]
mod grip;
#[cfg(feature = "engine")]
mod human;
#[cfg(feature = "engine")]
mod mapping;
mod params;
#[cfg(feature = "engine")]
mod report;
#[cfg(feature = "engine")]
mod rest;
#[cfg(feature = "engine")]
mod score;
#[cfg(feature = "engine")]
mod solve;
#[cfg(feature = "engine")]
mod solver;
#[cfg(feature = "engine")]
mod stage;
#[cfg(feature = "engine")]
mod start;
#[cfg(feature = "engine")]
mod target;
#[cfg(feature = "engine")]
mod track;
#[cfg(feature = "engine")]
mod view;
mod wrist;

#[cfg(feature = "engine")]
pub use beta::reachable_share_of;
pub use error::RetargetError;
pub use method::{Method, UnknownMethod};
pub use motion::{CameraMap, RobotMotion, SideReport};
pub use params::{Beta, CameraAngles, CameraRotation, Cutoff, Pinch, RetargetParams, Smoothing, Weights};
#[cfg(feature = "engine")]
pub use score::{IkScore, reachable_motion, score_ik, score_ik_with};
#[cfg(feature = "engine")]
pub use stage::retarget;
pub use wrist::WristTurn;
