//! Which part of the picture is on screen, and how large.

use agenticfocus::geometry::{Pixel, Size};
use egui::{Pos2, Rect, Vec2, vec2};

/// Screen pixels a picture pixel, at least and at most.
const ZOOMS: (f32, f32) = (0.05, 64.0);
/// Points of the picture that stay on screen however far it is moved.
const STAYS: f32 = 48.0;
/// What one key press zooms by.
const KEY_STEP: f32 = 1.25;

/// Zoom and place of the picture; stays as it is when the window changes its size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct View {
    /// `None` fits the picture in.
    free: Option<Free>,
}

/// A view that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Free {
    /// Screen pixels a picture pixel.
    zoom: f32,
    /// Position in the middle of the screen, columns and rows from the picture's top-left corner.
    middle: Vec2,
}

/// A view on a certain screen rectangle: where every pixel is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// The picture's top-left corner, points.
    origin: Pos2,
    /// Points a picture pixel.
    pub scale: f32,
    /// The picture.
    pub size: Size,
    /// Screen pixels a picture pixel.
    pub zoom: f32,
}

impl View {
    /// Where pixels are when the picture is shown in `rect`.
    pub fn projection(&self, rect: Rect, size: Size, pixels_per_point: f32) -> Projection {
        let extent = vec2(size.width.max(1) as f32, size.height.max(1) as f32);
        let (zoom, middle) = match self.free {
            Some(free) => (free.zoom, free.middle),
            None => {
                let fitting = rect.size().max(Vec2::ONE) / extent * pixels_per_point;
                (fitting.min_elem().clamp(ZOOMS.0, ZOOMS.1), extent / 2.0)
            }
        };
        let scale = zoom / pixels_per_point;
        Projection { origin: rect.center() - middle * scale, scale, size, zoom }
    }

    /// Shows the whole picture.
    pub fn fit(&mut self) {
        self.free = None;
    }

    /// Whether the whole picture is shown, whatever the window's size.
    pub fn is_fit(&self) -> bool {
        self.free.is_none()
    }

    /// Shows the picture at `zoom` screen pixels a pixel; what is at `anchor` (points) stays there.
    pub fn zoom_to(&mut self, zoom: f32, anchor: Pos2, rect: Rect, now: &Projection) {
        if !(zoom.is_finite() && anchor.x.is_finite() && anchor.y.is_finite()) {
            return;
        }
        let zoom = zoom.clamp(ZOOMS.0, ZOOMS.1);
        let scale = now.scale * zoom / now.zoom;
        let at = (anchor - now.origin) / now.scale;
        self.free = Some(Free { zoom, middle: at + (rect.center() - anchor) / scale });
        self.keep_near(now.size, rect, scale);
    }

    /// Zooms in by `steps` key presses (out where negative) about the middle of the screen.
    pub fn zoom_by_steps(&mut self, steps: f32, rect: Rect, now: &Projection) {
        self.zoom_to(now.zoom * KEY_STEP.powf(steps), rect.center(), rect, now);
    }

    /// Moves the picture by `delta` points.
    pub fn pan(&mut self, delta: Vec2, rect: Rect, now: &Projection) {
        let middle = (rect.center() - now.origin) / now.scale - delta / now.scale;
        self.free = Some(Free { zoom: now.zoom, middle });
        self.keep_near(now.size, rect, now.scale);
    }

    /// Some of the picture stays on screen: it cannot be lost.
    fn keep_near(&mut self, size: Size, rect: Rect, scale: f32) {
        if let Some(free) = &mut self.free {
            let beyond = ((rect.size() / 2.0 - Vec2::splat(STAYS)) / scale).max(Vec2::ZERO);
            let extent = vec2(size.width as f32, size.height as f32);
            free.middle = free.middle.clamp(-beyond, extent + beyond);
        }
    }
}

impl Projection {
    /// Where the picture is on screen.
    pub fn picture_rect(&self) -> Rect {
        let extent = vec2(self.size.width as f32, self.size.height as f32);
        Rect::from_min_size(self.origin, extent * self.scale)
    }

    /// Where a position of the picture is on screen; a pixel's centre has integer coordinates.
    pub fn to_screen(&self, pixel: Pixel) -> Pos2 {
        self.corner_to_screen(pixel.x + 0.5, pixel.y + 0.5)
    }

    /// Where the top-left corner of column `x`, row `y` is on screen.
    pub fn corner_to_screen(&self, x: f64, y: f64) -> Pos2 {
        // In doubles up to the last step: far outside, floats are too coarse.
        let scale = f64::from(self.scale);
        Pos2::new(
            (f64::from(self.origin.x) + x * scale) as f32,
            (f64::from(self.origin.y) + y * scale) as f32,
        )
    }

    /// Which position of the picture is at a point of the screen.
    pub fn to_picture(&self, at: Pos2) -> Pixel {
        let scale = f64::from(self.scale);
        Pixel::new(
            (f64::from(at.x) - f64::from(self.origin.x)) / scale - 0.5,
            (f64::from(at.y) - f64::from(self.origin.y)) / scale - 0.5,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::new(320, 240);

    fn rect() -> Rect {
        Rect::from_min_size(Pos2::new(40.0, 30.0), vec2(800.0, 480.0))
    }

    #[test]
    fn fitting_shows_the_whole_picture_in_the_middle() {
        let projection = View::default().projection(rect(), SIZE, 2.0);
        assert_eq!(projection.picture_rect().height(), 480.0);
        assert_eq!(projection.picture_rect().center(), rect().center());
        assert_eq!(projection.zoom, 4.0);
    }

    #[test]
    fn screen_and_picture_are_inverse_to_each_other() {
        let mut view = View::default();
        view.zoom_to(7.3, Pos2::new(300.0, 200.0), rect(), &view.projection(rect(), SIZE, 1.5));
        let projection = view.projection(rect(), SIZE, 1.5);
        for pixel in [Pixel::new(0.0, 0.0), Pixel::new(17.25, 99.5), Pixel::new(319.0, 239.0)] {
            let again = projection.to_picture(projection.to_screen(pixel));
            assert!(again.distance(pixel) < 1e-3, "{pixel:?} came back as {again:?}");
        }
        // The centre of a pixel is half a pixel right of and below its corner.
        let (corner, centre) =
            (projection.corner_to_screen(3.0, 4.0), projection.to_screen(Pixel::new(3.0, 4.0)));
        assert!((centre - corner - Vec2::splat(0.5 * projection.scale)).length() < 1e-3);
    }

    #[test]
    fn zooming_keeps_what_is_under_the_pointer() {
        let mut view = View::default();
        let anchor = Pos2::new(333.0, 222.0);
        for zoom in [2.0, 9.0, 31.0, 1.1] {
            let now = view.projection(rect(), SIZE, 1.0);
            let before = now.to_picture(anchor);
            view.zoom_to(zoom, anchor, rect(), &now);
            let after = view.projection(rect(), SIZE, 1.0).to_picture(anchor);
            assert!(before.distance(after) < 1e-2, "{before:?} moved to {after:?}");
        }
    }

    #[test]
    fn a_chosen_view_survives_another_window_size() {
        let mut view = View::default();
        let now = view.projection(rect(), SIZE, 1.0);
        view.zoom_to(3.0, Pos2::new(200.0, 200.0), rect(), &now);
        let middle = |rect: Rect| view.projection(rect, SIZE, 1.0).to_picture(rect.center());
        let smaller = Rect::from_min_size(Pos2::ZERO, vec2(300.0, 200.0));
        assert!(middle(rect()).distance(middle(smaller)) < 1e-3);
        assert_eq!(view.projection(smaller, SIZE, 1.0).zoom, 3.0);
    }

    #[test]
    fn nothing_hostile_moves_the_picture_out_of_reach() {
        let mut view = View::default();
        let now = view.projection(rect(), SIZE, 1.0);
        view.zoom_to(f32::NAN, Pos2::ZERO, rect(), &now);
        assert!(view.is_fit());
        view.pan(vec2(1e9, -1e9), rect(), &now);
        let picture = view.projection(rect(), SIZE, 1.0).picture_rect();
        assert!(picture.intersects(rect()), "{picture:?}");
    }
}
