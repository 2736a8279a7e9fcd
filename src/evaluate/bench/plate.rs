//! The restored background against the clean truth.

use super::{BenchError, mean, same_length};
use crate::{
    clip::{FrameIndex, FrameSource},
    evaluate::psnr_inside,
    image::Mask,
    synth::Episode,
};

/// Holes smaller than this many pixels are not scored.
const LEAST_PIXELS: usize = 400;
/// A frame's PSNR counts up to this many decibels, so that no lucky frame outweighs the rest.
const CEILING_DB: f64 = 60.0;

/// Where a restored background can be compared with the truth: hidden by a hand or arm and not by the object,
/// which is drawn over it later.
///
/// # Errors
/// When the truth cannot be read.
pub fn background_truth_region(episode: &Episode, index: FrameIndex) -> Result<Mask, BenchError> {
    Ok(episode.hands(index)?.minus(&episode.object_full(index)?))
}

/// Mean PSNR (dB) over frames of the background inside the true hole against the clean truth, which has neither
/// hand nor object nor their shadows.
///
/// # Errors
/// When lengths or sizes differ, or a picture cannot be read.
pub fn inpaint_psnr_db(episode: &Episode, cleaned: &dyn FrameSource) -> Result<Option<f64>, BenchError> {
    same_length("cleaned background", episode.frame_count(), cleaned.frame_count())?;
    let mut scores = Vec::new();
    for index in FrameIndex::all(episode.frame_count()) {
        let region = background_truth_region(episode, index)?;
        if region.area() < LEAST_PIXELS {
            continue;
        }
        let score = psnr_inside(&cleaned.frame(index)?, &episode.background(index)?, &region)?;
        scores.extend(score.map(|score| score.min(CEILING_DB)));
    }
    Ok(mean(&scores))
}
