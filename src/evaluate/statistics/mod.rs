//! Means over episodes with their uncertainty.

mod bootstrap;
mod split_mix;

pub use bootstrap::{Bootstrap, Estimate, exact_bootstrap};
pub use split_mix::SplitMix64;
