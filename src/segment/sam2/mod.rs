//! Masks by SAM 2 and 2.1: on one picture from points or a box, and through a clip, where every frame is decoded from
//! what is remembered of prompted and recent frames.

mod bank;
mod contract;
mod image;
mod image_contract;
mod logits;
mod network;
mod picture;
mod track;

pub use bank::{Bank, Heading};
pub use contract::SAM2_VIDEO;
pub use image::{EncodedPicture, ImageSegmenter, segment_frame};
pub use image_contract::SAM2_IMAGE;
pub use network::{Decoded, Encoded, Memory, TwoPoints, VideoSegmenter};
pub use track::{MaskOfPrompt, track_object};
