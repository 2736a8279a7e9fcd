//! 21-joint tracks of both hands.
//!
//! [`estimate`] asks an external estimator for image landmarks and keeps left and right apart;
//! [`fit`](fn@fit) turns them into metric hands in the camera frame. [`network`] finds metric hands by itself.

#[cfg(feature = "engine")]
mod detection;
#[cfg(feature = "engine")]
mod error;
#[cfg(feature = "engine")]
mod estimate;
#[cfg(feature = "engine")]
mod estimator;
#[cfg(feature = "engine")]
mod fit;
#[cfg(feature = "engine")]
mod follow;
#[cfg(feature = "engine")]
mod hidden;
#[cfg(feature = "engine")]
pub mod import;
#[cfg(feature = "engine")]
pub mod network;
#[cfg(feature = "engine")]
mod outliers;
#[cfg(feature = "engine")]
mod recover;
#[cfg(feature = "engine")]
mod sides;
#[cfg(feature = "engine")]
mod smooth;
mod track;
#[cfg(feature = "engine")]
mod tracklet;

#[cfg(feature = "engine")]
pub use error::HandsError;
#[cfg(feature = "engine")]
pub use estimate::{EstimateParams, Estimation, estimate};
#[cfg(feature = "engine")]
pub use estimator::{EstimatorCommand, PROTOCOL};
#[cfg(feature = "engine")]
pub use fit::{FitParams, FitScore, fit, fit_frame, length_of, score_fit};
#[cfg(feature = "engine")]
pub use follow::{NamedHand, follow};
#[cfg(feature = "engine")]
pub use hidden::{FilledLandmarks, Surroundings, fill_hidden};
pub use track::{HandFrame, HandState, HandTrack, ManoHand};
