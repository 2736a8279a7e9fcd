//! Quality measures: pictures against clean truth, masks against true masks, robot paths against human ones.

pub mod bench;
mod fidelity;
pub mod metrics;
mod region;
pub mod statistics;
pub mod study;

pub use fidelity::{MetricError, psnr, psnr_inside, ssim, ssim_inside};
pub use region::{boundary_f, region_j};
