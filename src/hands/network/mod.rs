//! Both hands by a network that sees each in a crop: WiLoR, HaMeR and the like.
//!
//! A detector finds hands, boxes are followed over time and given to a side, and a regressor says of each side's crop
//! how the 21 joints lie and how large the hand appears. With the camera's own intrinsics that is a place in metres.
//! Procedure: rolpotamias/WiLoR and geopavlakos/hamer, `demo.py`, `vitdet_dataset.py`. What differs: the true focal
//! length and principal point in place of the networks' own, and one size of hand a clip.

mod boxes;
mod clean;
mod contract;
mod crop;
mod follow;
mod letterbox;
mod net;
mod place;
mod rotation;
mod track;

pub use boxes::{HandBox, hands_in, without_doubles};
pub use contract::{BoxRule, HAND_POSE, HandParameters, JointOrder, Rotations};
pub use crop::{CROP_SIDE, Crop, CropPixels};
pub use letterbox::Letterbox;
pub use net::HandNetwork;
pub use place::{HandPrediction, PlacedHand, camera_translation};
pub use track::{distance_warning, track_hands};
