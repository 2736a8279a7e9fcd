//! The work scale: costly vision runs on a smaller picture.

use std::sync::Once;

use opencv::{
    core::{CV_8UC1, Mat, MatTraitConst, Rect, Size as CvSize, ToInputArray},
    imgproc,
};

use crate::geometry::{Pixel, Size};

/// Switches OpenCV's own thread pool off, once for the process.
pub fn single_threaded() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // A failure leaves the pool on, which costs only determinism of float reductions.
        let _ = opencv::core::set_num_threads(1);
    });
}

/// How a full-size picture maps to the smaller one that a stage works on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkScale {
    /// The clip's size.
    pub full: Size,
    /// The size worked on; never larger than `full`.
    pub work: Size,
}

impl WorkScale {
    /// Scales `full` down so that its longer side has at most `longest` pixels.
    pub fn fit(full: Size, longest: u32) -> Self {
        let side = full.width.max(full.height).max(1);
        if side <= longest {
            return Self { full, work: full };
        }
        let scale = f64::from(longest) / f64::from(side);
        let scaled = |length: u32| ((f64::from(length) * scale).round() as u32).max(1);
        Self { full, work: Size::new(scaled(full.width), scaled(full.height)) }
    }

    /// Work pixels a full pixel, along x and y.
    pub fn factors(&self) -> (f64, f64) {
        (
            f64::from(self.work.width) / f64::from(self.full.width),
            f64::from(self.work.height) / f64::from(self.full.height),
        )
    }

    /// The box of the whole full-size picture.
    pub fn whole(&self) -> Rect {
        Rect::new(0, 0, self.full.width as i32, self.full.height as i32)
    }

    /// A full-size position on the work picture.
    pub fn to_work(&self, p: Pixel) -> Pixel {
        let (sx, sy) = self.factors();
        Pixel::new((p.x + 0.5) * sx - 0.5, (p.y + 0.5) * sy - 0.5)
    }

    /// A work position on the full-size picture.
    pub fn to_full(&self, p: Pixel) -> Pixel {
        let (sx, sy) = self.factors();
        Pixel::new((p.x + 0.5) / sx - 0.5, (p.y + 0.5) / sy - 0.5)
    }

    /// A picture at work size (area averaging).
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn shrink(&self, picture: &(impl MatTraitConst + ToInputArray)) -> opencv::Result<Mat> {
        resized(picture, self.work, imgproc::INTER_AREA)
    }

    /// A mask at work size: inside where at least half of the area is.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn shrink_mask(&self, mask: &Mat) -> opencv::Result<Mat> {
        let shrunk = resized(mask, self.work, imgproc::INTER_AREA)?;
        let mut binary = Mat::default();
        imgproc::threshold(&shrunk, &mut binary, 127.0, 255.0, imgproc::THRESH_BINARY)?;
        debug_assert_eq!(binary.typ(), CV_8UC1);
        Ok(binary)
    }

    /// A work picture at full size (bilinear).
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn enlarge(&self, picture: &Mat) -> opencv::Result<Mat> {
        resized(picture, self.full, imgproc::INTER_LINEAR)
    }
}

fn resized(
    picture: &(impl MatTraitConst + ToInputArray),
    size: Size,
    interpolation: i32,
) -> opencv::Result<Mat> {
    if picture.cols() == size.width as i32 && picture.rows() == size.height as i32 {
        return picture.try_clone();
    }
    let mut out = Mat::default();
    let target = CvSize::new(size.width as i32, size.height as i32);
    imgproc::resize(picture, &mut out, target, 0.0, 0.0, interpolation)?;
    Ok(out)
}
