//! Removing the human: the background behind hands and arms, from frames that really saw it.
//!
//! The hole is `M_hand ∩ ¬M_obj`, widened but never into the object. Key frames get a *plate*: the
//! picture with hand and object taken out and replaced by aligned samples of the frames nearest in
//! time that saw that place. Every frame then draws its hole from the two plates around it, cross-faded
//! in time, so that nothing flickers. What no frame saw is synthesised once on a plate and handed on
//! from plate to plate. Beside the hole the shadow of hand and arm is taken out with them.

mod cast;
mod clean;
mod error;
mod fill;
mod gather;
mod hole;
mod moved;
mod params;
mod plate;
mod report;
mod scene;
mod shadow;
mod survey;

pub use clean::clean;
pub use error::InpaintError;
pub use hole::inpaint_mask;
pub use params::InpaintParams;
pub use report::{FrameCoverage, InpaintReport};
