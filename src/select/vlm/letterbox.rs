//! The size at which frames are sent, and the way back.

use crate::geometry::{Pixel, Size};

/// Sides are multiples of this (the least common multiple of 28 and 32), so that the resizing that models do themselves
/// (`smart_resize` of the Qwen families) changes nothing and pixels sent are pixels seen.
const STEP: u32 = 224;
/// Most pixels that those models look at without shrinking the picture.
const MOST: u32 = 1_003_520;
/// Enlarging further shows nothing more and costs tokens.
const LARGEST_SCALE: f64 = 1.5;

/// A frame scaled into the top-left of a larger picture; right and bottom are filled up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Letterbox {
    /// The frame's own size.
    pub clip: Size,
    /// The size of the picture sent.
    pub sent: Size,
    /// The part of it that shows the frame.
    pub content: Size,
}

impl Letterbox {
    /// The box for frames of size `clip` that shows most of them and wastes least.
    pub fn new(clip: Size) -> Self {
        let steps = || 1..=MOST / STEP / STEP;
        let candidates = steps().flat_map(|across| steps().map(move |down| (across, down)));
        let boxes = candidates
            .filter(|(across, down)| across * down * STEP * STEP <= MOST)
            .map(|(across, down)| Self::within(clip, Size::new(across * STEP, down * STEP)));
        let worth = |boxed: &Self| {
            let shown = boxed.content.area() as f64;
            shown * (shown / boxed.sent.area() as f64).powi(2)
        };
        // The smaller one of two that show as much.
        boxes
            .reduce(|best, next| if worth(&next) > worth(&best) { next } else { best })
            .unwrap_or_else(|| Self::within(clip, Size::new(STEP, STEP)))
    }

    fn within(clip: Size, sent: Size) -> Self {
        let (width, height) = (f64::from(clip.width.max(1)), f64::from(clip.height.max(1)));
        let scale = (f64::from(sent.width) / width).min(f64::from(sent.height) / height).min(LARGEST_SCALE);
        let side = |length: f64, most: u32| ((length * scale).round() as u32).clamp(1, most);
        let content = Size::new(side(width, sent.width), side(height, sent.height));
        Self { clip, sent, content }
    }

    /// Pixels of the clip where the picture sent has `at`; beyond the frame where `at` lies on what was filled up.
    pub fn to_clip(self, at: Pixel) -> Pixel {
        let across = f64::from(self.clip.width) / f64::from(self.content.width);
        let down = f64::from(self.clip.height) / f64::from(self.content.height);
        Pixel::new(at.x * across, at.y * down)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_those_that_no_model_resizes() {
        for (clip, sent) in [
            (Size::new(1920, 1080), Size::new(1344, 672)),
            (Size::new(640, 480), Size::new(896, 672)),
            (Size::new(1440, 1440), Size::new(896, 896)),
            (Size::new(1080, 1920), Size::new(672, 1344)),
            (Size::new(456, 256), Size::new(672, 448)),
        ] {
            assert_eq!(Letterbox::new(clip).sent, sent, "{clip}");
        }
        for clip in [Size::new(1, 1), Size::new(7680, 20), Size::new(3, 4000), Size::new(320, 240)] {
            let boxed = Letterbox::new(clip);
            let whole = [boxed.sent.width, boxed.sent.height].iter().all(|side| side.is_multiple_of(224));
            assert!(whole, "{boxed:?}");
            assert!(boxed.sent.area() <= 1_003_520 && boxed.content.width <= boxed.sent.width, "{boxed:?}");
            assert!(boxed.content.height <= boxed.sent.height, "{boxed:?}");
        }
    }

    #[test]
    fn the_way_back_leads_to_the_frame_s_own_corner() {
        let boxed = Letterbox::new(Size::new(1920, 1080));
        let corner = Pixel::new(f64::from(boxed.content.width), f64::from(boxed.content.height));
        assert_eq!(boxed.to_clip(corner), Pixel::new(1920.0, 1080.0));
    }
}
