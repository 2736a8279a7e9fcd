//! Restoring the background with a network that sees several frames at once, E2FGVI-HQ and the like.
//!
//! Procedure: MCG-NKU/E2FGVI, `test.py`. What differs: windows are as long as the exported graph says, overlapping
//! windows are blended by nearness unless the published rule is asked for, and the object is kept out of the hole.

mod blend;
mod clean;
mod contract;
mod fit;
mod network;
mod windows;

pub use blend::Blend;
pub use clean::clean_by_network;
pub use contract::{VIDEO_INPAINT, VideoParameters};
pub use fit::Fit;
pub use network::{NetworkFrame, VideoNetwork};
pub use windows::{Window, WindowSize, WindowSteps, windows};
