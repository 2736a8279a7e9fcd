//! A picture as a detector takes it: shrunk or enlarged to fit a square, grey beside it.

use opencv::{
    core::{BORDER_CONSTANT, Mat, Scalar, Size as CvSize, copy_make_border},
    imgproc::{INTER_LINEAR, resize},
};

use crate::geometry::{PixelBox, Size};

/// The grey beside the picture, as Ultralytics' loaders have it.
const GREY: f64 = 114.0;

/// How a picture lies in the detector's square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Letterbox {
    /// Pixels of the square a pixel of the picture.
    pub scale: f64,
    /// Grey columns on the left and rows above.
    pub margin: (i32, i32),
    inner: Size,
    side: u32,
}

impl Letterbox {
    /// The largest place for a picture of `size` in a square of `side`, centred.
    pub fn new(size: Size, side: u32) -> Self {
        let share = |own: u32| f64::from(side) / f64::from(own.max(1));
        let scale = share(size.width).min(share(size.height));
        let scaled = |own: u32| ((f64::from(own) * scale).round() as u32).clamp(1, side);
        let inner = Size::new(scaled(size.width), scaled(size.height));
        let before = |inner: u32| (f64::from(side - inner) / 2.0 - 0.1).round().max(0.0) as i32;
        Self { scale, margin: (before(inner.width), before(inner.height)), inner, side }
    }

    /// `picture` (CV_8UC3) in the square.
    pub fn draw(&self, picture: &Mat) -> opencv::Result<Mat> {
        let (mut small, mut square) = (Mat::default(), Mat::default());
        let size = CvSize::new(self.inner.width as i32, self.inner.height as i32);
        resize(picture, &mut small, size, 0.0, 0.0, INTER_LINEAR)?;
        let (left, above) = self.margin;
        let (right, below) =
            ((self.side - self.inner.width) as i32 - left, (self.side - self.inner.height) as i32 - above);
        let grey = Scalar::all(GREY);
        copy_make_border(&small, &mut square, above, below, left, right, BORDER_CONSTANT, grey)?;
        Ok(square)
    }

    /// A box of the square in pixels of the picture.
    pub fn back(&self, found: PixelBox) -> PixelBox {
        let x = |x: f64| (x - f64::from(self.margin.0)) / self.scale;
        let y = |y: f64| (y - f64::from(self.margin.1)) / self.scale;
        PixelBox { x0: x(found.x0), y0: y(found.y0), x1: x(found.x1), y1: y(found.y1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_picture_gets_grey_above_and_below_and_boxes_come_back() {
        let letterbox = Letterbox::new(Size::new(1280, 720), 640);
        assert_eq!((letterbox.scale, letterbox.margin), (0.5, (0, 140)));
        let found = letterbox.back(PixelBox { x0: 100.0, y0: 190.0, x1: 200.0, y1: 240.0 });
        assert_eq!(found, PixelBox { x0: 200.0, y0: 100.0, x1: 400.0, y1: 200.0 });
    }

    #[test]
    fn a_small_picture_is_enlarged() {
        let letterbox = Letterbox::new(Size::new(320, 240), 640);
        assert_eq!((letterbox.scale, letterbox.margin), (2.0, (0, 80)));
        // An odd rest has its extra row below, as the authors' rounding gives it.
        assert_eq!(Letterbox::new(Size::new(640, 479), 640).margin, (0, 80));
    }
}
