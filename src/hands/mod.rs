//! 21-joint tracks of both hands.

mod track;

pub use track::{HandFrame, HandState, HandTrack};
