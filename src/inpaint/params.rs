//! What can be tuned.

use serde::{Deserialize, Serialize};

/// Parameters of background restoration. Lengths are shares of the picture's width.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct InpaintParams {
    /// Longer side, in pixels, of the picture on which frames are registered (default: 320).
    pub work_side: u32,
    /// How far the arm mask is widened to make the hole (default: 0.009): covers blurred edges and
    /// the soft shadow at the contact border.
    pub hole_dilation: f64,
    /// How far the arm and object masks are widened before anything outside counts as background
    /// (default: 0.015).
    pub guard: f64,
    /// How far the object mask is narrowed before it is taken out of the hole (default: 0.003):
    /// its rim may carry the hand's colours.
    pub object_erosion: f64,
    /// How far from the hole the shadow of hand and arm is looked for (default: 0.12).
    pub shadow_reach: f64,
    /// Width of the seam over which restored background fades into the frame (default: 0.004).
    pub feather: f64,
    /// Frames that one plate serves at least, where the clip is long enough (default: 15).
    pub plate_spacing: u32,
    /// Frames that one plate serves at most (default: 60), however little the camera moves.
    pub longest_service: u32,
    /// How far the camera may carry the picture's corners away from a plate's key frame, as a share of
    /// the width, before another plate takes over (default: 0.06).
    pub plate_reach: f64,
    /// Frames over which one plate fades into the next (default: 6).
    pub handover: u32,
    /// Samples kept for each pixel of a plate, nearest in time first, at most 15 (default: 15).
    pub samples: usize,
    /// Frames a plate may read at most (default: 16).
    pub max_sources: usize,
    /// Margin of a plate around its frame, for a moving camera (default: 0.125).
    pub margin: f64,
    /// Whether parallax is followed by dense flow on top of a homography (default: true).
    pub parallax: bool,
    /// Colour differences that leave the typical one by more than this many levels are shadow or
    /// misregistration, not exposure (default: 12).
    pub colour_limit: f32,
    /// Levels by which the surroundings of a hole may differ from another frame's before that frame
    /// is taken to show another state of the scene (default: 24). Differences of brightness alone are shadow.
    pub change_limit: f32,
    /// Mebibytes of decoded frames that may be kept (default: 160).
    pub cache_mib: usize,
}

impl Default for InpaintParams {
    fn default() -> Self {
        Self {
            work_side: 320,
            hole_dilation: 0.009,
            guard: 0.015,
            object_erosion: 0.003,
            shadow_reach: 0.12,
            feather: 0.004,
            plate_spacing: 15,
            longest_service: 60,
            plate_reach: 0.06,
            handover: 6,
            samples: 15,
            max_sources: 16,
            margin: 0.125,
            parallax: true,
            colour_limit: 12.0,
            change_limit: 24.0,
            cache_mib: 160,
        }
    }
}

impl InpaintParams {
    /// The widest hole a person may ask for, as a share of the picture's width: twice a finger.
    pub const WIDEST_DILATION: f64 = 0.05;

    /// The defaults with the hole widened by `share`. What is taken out must not teach the background, so that the
    /// guard keeps its distance from a wider hole.
    #[must_use]
    pub fn with_hole_dilation(share: f64) -> Self {
        let usual = Self::default();
        let guard = usual.guard + (share - usual.hole_dilation).max(0.0);
        Self { hole_dilation: share, guard, ..usual }
    }

    /// Pixels by which the arm mask of a picture `width` wide is widened to make the hole.
    pub fn hole_reach(&self, width: u32) -> u32 {
        Self::pixels(self.hole_dilation, width, 2).unsigned_abs()
    }

    /// Pixels by which the object mask of a picture `width` wide is narrowed before it is taken out of the hole.
    pub fn object_inset(&self, width: u32) -> u32 {
        Self::pixels(self.object_erosion, width, 1).unsigned_abs()
    }

    /// A share of the width in whole pixels, at least `least`.
    pub(super) fn pixels(share: f64, width: u32, least: i32) -> i32 {
        ((share * f64::from(width)).round() as i32).max(least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wider_hole_keeps_its_distance_to_what_teaches_the_background() {
        let usual = InpaintParams::default();
        assert_eq!(InpaintParams::with_hole_dilation(usual.hole_dilation), usual);
        let wide = InpaintParams::with_hole_dilation(0.03);
        assert!((wide.guard - wide.hole_dilation - (usual.guard - usual.hole_dilation)).abs() < 1e-12);
        assert_eq!((wide.hole_reach(640), usual.hole_reach(640)), (19, 6));
        let narrow = InpaintParams::with_hole_dilation(0.0);
        assert!((narrow.guard - usual.guard).abs() < 1e-12 && narrow.hole_reach(640) == 2);
    }
}
