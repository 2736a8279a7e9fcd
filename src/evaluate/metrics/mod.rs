//! Measures of a path: how far it is from another, and how smooth it moves.
//!
//! A path is a list of points in metres at a fixed rate. Smoothness measures take its speed (see [`speed`]). None
//! of them filters; none depends on the path's size.

mod align;
mod jerk;
mod path;
mod spectral;

pub use align::{Alignment, Similarity, umeyama};
pub use jerk::log_dimensionless_jerk;
pub use path::{mean_distance, resampled, speed};
pub use spectral::{SpectralParams, sal_fixed, sparc};
