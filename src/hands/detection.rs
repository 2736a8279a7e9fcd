//! One hand in one picture, before it is known whose it is.

use nalgebra::Vector3;

use crate::{
    geometry::{Pixel, PixelBox, Side},
    landmarks::{HandLandmarks, KEYPOINT_COUNT},
};

/// A hand as the estimator reported it, keypoints in pixels of the clip.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Detection {
    /// The side the estimator believes in.
    pub side: Side,
    /// Trust in hand and side, 0 to 1.
    pub score: f64,
    /// Keypoints, pixels of the clip.
    pub keypoints: [Pixel; KEYPOINT_COUNT],
    /// Keypoints relative to the hand, metres, camera axes.
    pub world: Option<[Vector3<f64>; KEYPOINT_COUNT]>,
}

impl Detection {
    /// The tight box around the keypoints.
    pub fn bounds(&self) -> PixelBox {
        bounds(&self.keypoints)
    }

    /// Longer side of the box, pixels.
    pub fn extent(&self) -> f64 {
        extent(&self.keypoints)
    }

    /// As landmarks of a side that has been decided.
    pub fn into_landmarks(self) -> HandLandmarks {
        HandLandmarks { keypoints: self.keypoints, world: self.world, confidence: self.score }
    }
}

/// The tight box around keypoints.
pub(super) fn bounds(keypoints: &[Pixel; KEYPOINT_COUNT]) -> PixelBox {
    let first = keypoints[0];
    keypoints.iter().fold(PixelBox::from_corners(first, first), |b, p| PixelBox {
        x0: b.x0.min(p.x),
        y0: b.y0.min(p.y),
        x1: b.x1.max(p.x),
        y1: b.y1.max(p.y),
    })
}

/// Longer side of the box around keypoints, at least one pixel.
pub(super) fn extent(keypoints: &[Pixel; KEYPOINT_COUNT]) -> f64 {
    let bounds = bounds(keypoints);
    bounds.width().max(bounds.height()).max(1.0)
}

/// Mean distance of corresponding keypoints as a share of the hands' mean extent: 0 for the same
/// hand in the same place, about 1 for hands side by side.
pub(super) fn distance(a: &[Pixel; KEYPOINT_COUNT], b: &[Pixel; KEYPOINT_COUNT]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(p, q)| p.distance(*q)).sum();
    sum / KEYPOINT_COUNT as f64 / (0.5 * (extent(a) + extent(b)))
}

/// `a` towards `b` by `share`; shares above 1 extrapolate.
pub(super) fn interpolate(
    a: &[Pixel; KEYPOINT_COUNT],
    b: &[Pixel; KEYPOINT_COUNT],
    share: f64,
) -> [Pixel; KEYPOINT_COUNT] {
    std::array::from_fn(|k| {
        Pixel::new(a[k].x + share * (b[k].x - a[k].x), a[k].y + share * (b[k].y - a[k].y))
    })
}
