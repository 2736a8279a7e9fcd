//! Where frames lie on the screen.

use agenticfocus::clip::FrameIndex;
use egui::Rangef;

/// Frames across the width of the timeline: frame `f` fills the interval from `f` to `f + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Left and right end on the screen, points.
    pub x: Rangef,
    /// The interval of frames shown.
    pub shown: (f64, f64),
    /// Frames of the clip.
    pub count: u32,
}

/// Fewest frames that fill the timeline, so that one frame is never wider than a thumb.
const FEWEST: f64 = 12.0;

impl Scale {
    /// All frames of a clip.
    pub fn whole(x: Rangef, count: u32) -> Self {
        Self { x, shown: (0.0, f64::from(count.max(1))), count }
    }

    /// Frames from `start` on, `length` of them, moved so that they lie inside the clip.
    pub fn part(x: Rangef, count: u32, start: f64, length: f64) -> Self {
        let all = f64::from(count.max(1));
        let length = length.clamp(FEWEST.min(all), all);
        let start = start.clamp(0.0, all - length);
        Self { x, shown: (start, start + length), count }
    }

    /// Points a frame is wide.
    pub fn frame_width(&self) -> f32 {
        self.x.span() / (self.shown.1 - self.shown.0) as f32
    }

    /// The left edge of a frame.
    pub fn left(&self, frame: u32) -> f32 {
        let share = (f64::from(frame) - self.shown.0) / (self.shown.1 - self.shown.0);
        self.x.min + (share as f32) * self.x.span()
    }

    /// The middle of a frame.
    pub fn middle(&self, frame: u32) -> f32 {
        self.left(frame) + 0.5 * self.frame_width()
    }

    /// The edges of a run, at least a pixel and a half wide; `None` where it is out of sight.
    pub fn span(&self, first: u32, last: u32) -> Option<Rangef> {
        let (left, right) = (self.left(first), self.left(last + 1));
        if right <= self.x.min || left >= self.x.max {
            return None;
        }
        let (left, right) = (left.max(self.x.min), right.min(self.x.max));
        Some(Rangef::new(left, right.max(left + 1.5)))
    }

    /// The frame under `x`, the nearest one beyond the ends.
    pub fn frame_at(&self, x: f32) -> FrameIndex {
        let share = f64::from((x - self.x.min) / self.x.span().max(1.0));
        let frame = (self.shown.0 + share * (self.shown.1 - self.shown.0)).floor();
        FrameIndex(frame.clamp(0.0, f64::from(self.count.saturating_sub(1))) as u32)
    }

    /// The frames in sight, first and last.
    pub fn in_sight(&self) -> (u32, u32) {
        let last = (self.shown.1.ceil() as u32).min(self.count).saturating_sub(1);
        (self.shown.0.floor() as u32, last)
    }

    /// Zoomed by `factor` about `x`.
    #[must_use]
    pub fn zoomed(&self, factor: f64, x: f32) -> Self {
        let share = f64::from(((x - self.x.min) / self.x.span().max(1.0)).clamp(0.0, 1.0));
        let length = self.shown.1 - self.shown.0;
        let about = self.shown.0 + share * length;
        let wanted = length / factor;
        Self::part(self.x, self.count, about - share * wanted, wanted)
    }

    /// Moved by `points` on the screen.
    #[must_use]
    pub fn moved(&self, points: f32) -> Self {
        let by = f64::from(points / self.frame_width());
        Self::part(self.x, self.count, self.shown.0 + by, self.shown.1 - self.shown.0)
    }

    /// Moved so that `frame` is in sight.
    #[must_use]
    pub fn showing(&self, frame: u32) -> Self {
        let (at, length) = (f64::from(frame), self.shown.1 - self.shown.0);
        if at >= self.shown.0 && at + 1.0 <= self.shown.1 {
            return *self;
        }
        Self::part(self.x, self.count, at - 0.5 * length, length)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_frame_is_found_where_it_is_drawn(count in 1_u32..9_000, at in 0.0_f64..1.0, zoom in 1.0_f64..50.0) {
            let frame = (f64::from(count - 1) * at) as u32;
            let scale = Scale::whole(Rangef::new(80.0, 1380.0), count).zoomed(zoom, 400.0).showing(frame);
            prop_assert!(scale.shown.0 >= 0.0 && scale.shown.1 <= f64::from(count) + 1e-9);
            let found = scale.frame_at(scale.middle(frame)).0;
            // With 9,000 frames in 1,300 points a frame is a seventh of a point: rounding of f32 remains.
            prop_assert!(found.abs_diff(frame) <= 1, "{found} instead of {frame}");
        }
    }

    #[test]
    fn zooming_keeps_the_frame_under_the_pointer() {
        let scale = Scale::whole(Rangef::new(0.0, 1000.0), 1000);
        let near = scale.zoomed(4.0, 300.0);
        assert_eq!(near.frame_at(300.5), FrameIndex(300));
        assert!((near.shown.1 - near.shown.0 - 250.0).abs() < 1e-9);
    }
}
