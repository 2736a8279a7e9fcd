//! Quality measures: pictures against clean truth, masks against true masks.

pub mod bench;
mod fidelity;
mod region;

pub use fidelity::{MetricError, psnr, psnr_inside, ssim, ssim_inside};
pub use region::{boundary_f, region_j};
