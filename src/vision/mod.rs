//! Classical vision tools that several stages share; they know no stage.
//!
//! Pictures are OpenCV matrices in RGB order (see [`crate::image::mat`]). OpenCV's own thread
//! pool is switched off by [`single_threaded`]: stages are parallel over frames instead, so that
//! results never depend on the number of threads.

mod align;
pub mod binary;
mod colour_model;
mod flow;
pub mod grab_cut;
mod guided;
mod histogram;
mod homography;
mod plane;
mod scale;
mod tv_cut;

pub use align::{AlignChannel, AlignPoint, AlignPrior, Alignment, align};
pub use colour_model::{ColourModel, log_odds};
pub use flow::{Flow, FlowQuality, dense_flow};
pub use guided::refine_edges;
pub use histogram::LabHistogram;
pub use homography::{BackgroundMotion, background_motion};
pub use plane::Plane;
pub use scale::{WorkScale, single_threaded};
pub use tv_cut::{EdgeWeights, tv_cut};
