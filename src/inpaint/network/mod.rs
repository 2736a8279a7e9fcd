//! What no frame saw, made up by a network that sees one picture: LaMa and the like.
//!
//! On video such a network flickers. It is asked once a plate, for what neither this plate's frames nor the plate before
//! know, and what it says is handed on from plate to plate like everything made up.

mod contract;
mod fill;
mod net;

pub use contract::IMAGE_INPAINT;
pub(super) use fill::fill_by_network;
pub use net::ImageNetwork;
