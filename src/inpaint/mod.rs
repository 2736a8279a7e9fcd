//! Removing the human: the background behind hands and arms, from frames that really saw it.
//!
//! The hole is `M_hand ∩ ¬M_obj`, widened but never into the object. Key frames get a *plate*: the
//! picture with hand and object taken out and replaced by aligned samples of the frames nearest in
//! time that saw that place. Every frame then draws its hole from the two plates around it, cross-faded
//! in time, so that nothing flickers. What no frame saw is synthesised once on a plate, by a network
//! where one is at hand, and handed on from plate to plate. Beside the hole the shadow of hand and arm is taken out with them.

#[cfg(feature = "engine")]
mod cast;
#[cfg(feature = "engine")]
mod clean;
#[cfg(feature = "engine")]
mod error;
#[cfg(feature = "engine")]
mod fill;
#[cfg(feature = "engine")]
mod gather;
#[cfg(feature = "engine")]
mod hole;
#[cfg(feature = "engine")]
mod moved;
#[cfg(feature = "engine")]
pub mod network;
mod params;
#[cfg(feature = "engine")]
mod plate;
mod report;
#[cfg(feature = "engine")]
mod scene;
#[cfg(feature = "engine")]
mod seam;
#[cfg(feature = "engine")]
mod settle;
#[cfg(feature = "engine")]
mod shadow;
#[cfg(feature = "engine")]
mod survey;
#[cfg(feature = "engine")]
pub mod video;

#[cfg(feature = "engine")]
pub use clean::{SinkError, clean, clean_with};
#[cfg(feature = "engine")]
pub use error::InpaintError;
#[cfg(feature = "engine")]
pub use hole::inpaint_mask;
pub use params::InpaintParams;
pub use report::{FrameCoverage, InpaintReport};
