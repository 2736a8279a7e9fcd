//! Classical vision tools that several stages share; they know no stage.
//!
//! Pictures are OpenCV matrices in RGB order (see [`crate::image::mat`]). OpenCV's own thread
//! pool is switched off by [`single_threaded`]: stages are parallel over frames instead, so that
//! results never depend on the number of threads.

mod align;
pub mod binary;
mod box_blur;
mod camera_path;
mod colour_model;
mod flow;
pub mod grab_cut;
mod guided;
mod histogram;
mod homography;
mod moments;
mod motion_fit;
mod plane;
mod registration;
mod scale;
mod smooth_fill;
mod tv_cut;

pub use align::{AlignChannel, AlignPoint, AlignPrior, Alignment, align};
pub use box_blur::box_blurred;
pub use camera_path::CameraPath;
pub use colour_model::{COLOUR_BIN_VOLUME, ColourModel, log_odds};
pub use flow::{Flow, FlowQuality, dense_flow};
pub use guided::refine_edges;
pub use histogram::LabHistogram;
pub use homography::{BackgroundMotion, background_motion, background_motion_from};
pub use moments::Moments;
pub use plane::Plane;
pub use registration::{Registration, View, Warp, colour_offset, enlarged_part, scene_change, to_full_size};
pub use scale::{WorkScale, single_threaded};
pub use smooth_fill::fill_smoothly;
pub use tv_cut::{EdgeWeights, tv_cut};
