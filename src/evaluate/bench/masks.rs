//! Masks and template placements against the true shapes.

use super::{BenchError, mean, same_length};
use crate::{
    clip::FrameIndex, composite::placed_shape, geometry::PixelBox, image::Mask, segment::MaskTrack,
    synth::Episode, template::TemplateTrack,
};

/// Frames on which the truth has fewer pixels than this are not scored: one pixel would decide.
const LEAST_PIXELS: usize = 150;
/// Share of the object that must be hidden for a frame to count as occluded.
const OCCLUDED: f64 = 0.3;

/// The one prompt of the object: the first frame on which it is wholly visible and clear of the border, and the
/// tight box around it there.
///
/// # Errors
/// When the truth cannot be read.
pub fn first_object_box(episode: &Episode) -> Result<Option<(FrameIndex, PixelBox)>, BenchError> {
    for index in FrameIndex::all(episode.frame_count()) {
        if episode.truth.frames[index.as_usize()].object_hidden > 0.02 {
            continue;
        }
        if let Some(bounds) = episode.object_visible(index)?.bounding_box() {
            return Ok(Some((index, bounds)));
        }
    }
    Ok(None)
}

/// Mean J of the object's visible part over all frames that show at least 150 pixels of it.
///
/// # Errors
/// When the lengths differ or the truth cannot be read.
pub fn object_mask_j(episode: &Episode, track: &MaskTrack) -> Result<Option<f64>, BenchError> {
    track_j(episode, "object mask track", track, Episode::object_visible)
}

/// Mean J of hands, arms and sleeves over all frames that show at least 150 pixels of them.
///
/// # Errors
/// When the lengths differ or the truth cannot be read.
pub fn arm_mask_j(episode: &Episode, track: &MaskTrack) -> Result<Option<f64>, BenchError> {
    track_j(episode, "arm mask track", track, Episode::hands)
}

fn track_j(
    episode: &Episode,
    what: &'static str,
    track: &MaskTrack,
    truth: impl Fn(&Episode, FrameIndex) -> Result<Mask, crate::synth::SynthError>,
) -> Result<Option<f64>, BenchError> {
    same_length(what, episode.frame_count(), track.frames.len())?;
    let mut scores = Vec::new();
    for index in FrameIndex::all(episode.frame_count()) {
        let truth = truth(episode, index)?;
        if truth.area() >= LEAST_PIXELS {
            scores.push(super::super::region_j(&track.frame(index).mask.decode(), &truth)?);
        }
    }
    Ok(mean(&scores))
}

/// Mean IoU of the placed template with the object's full shape, over frames on which at least 30 % of it is
/// hidden; a frame without placement scores 0. `None` when no frame is that occluded.
///
/// # Errors
/// When the lengths differ, a placement is singular or the truth cannot be read.
pub fn template_iou_occluded(episode: &Episode, template: &TemplateTrack) -> Result<Option<f64>, BenchError> {
    same_length("template track", episode.frame_count(), template.placements.len())?;
    let mut scores = Vec::new();
    for index in FrameIndex::all(episode.frame_count()) {
        if episode.truth.frames[index.as_usize()].object_hidden < OCCLUDED {
            continue;
        }
        let full = episode.object_full(index)?;
        if full.area() < LEAST_PIXELS {
            continue;
        }
        scores.push(match &template.placements[index.as_usize()] {
            Some(placement) => placed_shape(template, placement, full.size())?.iou(&full),
            None => 0.0,
        });
    }
    Ok(mean(&scores))
}
