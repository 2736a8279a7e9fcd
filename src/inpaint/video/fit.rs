//! A clip's frames at a network's size: shrunk to fit, padded by mirroring their right and bottom parts.

use opencv::{
    core::{BORDER_REFLECT, Mat, MatTraitConst, Rect, Scalar, Size as CvSize},
    imgproc::{INTER_AREA, INTER_LINEAR, INTER_NEAREST, resize},
};

use crate::geometry::Size;

/// How frames of one size lie in a network's picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fit {
    /// The clip's size.
    pub clip: Size,
    /// The size it is shrunk or enlarged to; the aspect is kept.
    pub inner: Size,
    /// The network's size; `inner` lies at its top left.
    pub outer: Size,
}

impl Fit {
    /// The largest place for frames of size `clip` in a network's picture.
    pub fn new(clip: Size, outer: Size) -> Self {
        let share = |own: u32, theirs: u32| f64::from(theirs) / f64::from(own.max(1));
        let scale = share(clip.width, outer.width).min(share(clip.height, outer.height));
        let scaled = |own: u32, most: u32| ((f64::from(own) * scale).round() as u32).clamp(1, most);
        let inner = Size::new(scaled(clip.width, outer.width), scaled(clip.height, outer.height));
        Self { clip, inner, outer }
    }

    /// The smallest size of those sides' multiples that holds `size`: what a graph of open size is fed.
    pub fn padded_size(size: Size, multiple: Size) -> Size {
        let up = |own: u32, step: u32| own.div_ceil(step.max(1)) * step.max(1);
        Size::new(up(size.width, multiple.width), up(size.height, multiple.height))
    }

    /// A picture in the network's frame. The edge row and column are repeated by the mirroring, as in the published
    /// procedure.
    pub fn shrink(&self, picture: &Mat) -> opencv::Result<Mat> {
        let method = if self.inner.width < self.clip.width { INTER_AREA } else { INTER_LINEAR };
        let mut small = Mat::default();
        resize(picture, &mut small, cv(self.inner), 0.0, 0.0, method)?;
        self.pad(&small)
    }

    /// As [`Self::shrink`] for masks.
    pub fn shrink_mask(&self, mask: &Mat) -> opencv::Result<Mat> {
        let mut small = Mat::default();
        resize(mask, &mut small, cv(self.inner), 0.0, 0.0, INTER_NEAREST)?;
        self.pad(&small)
    }

    /// A network's picture at the clip's size.
    pub fn enlarge(&self, picture: &Mat) -> opencv::Result<Mat> {
        let inner = Rect::new(0, 0, self.inner.width as i32, self.inner.height as i32);
        let inner = Mat::roi(picture, inner)?;
        let mut out = Mat::default();
        resize(&inner, &mut out, cv(self.clip), 0.0, 0.0, INTER_LINEAR)?;
        Ok(out)
    }

    fn pad(&self, small: &Mat) -> opencv::Result<Mat> {
        let (right, below) =
            (self.outer.width as i32 - small.cols(), self.outer.height as i32 - small.rows());
        let mut out = Mat::default();
        opencv::core::copy_make_border(
            small,
            &mut out,
            0,
            below,
            0,
            right,
            BORDER_REFLECT,
            Scalar::all(0.0),
        )?;
        Ok(out)
    }
}

fn cv(size: Size) -> CvSize {
    CvSize::new(size.width as i32, size.height as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use opencv::core::MatTraitConstManual;

    #[test]
    fn open_graphs_are_fed_the_padded_sizes_of_the_published_procedure() {
        let padded = |height, width| Fit::padded_size(Size::new(width, height), Size::new(108, 60));
        assert_eq!(padded(240, 432), Size::new(432, 240));
        assert_eq!(padded(480, 854), Size::new(864, 480));
        assert_eq!(padded(720, 1280), Size::new(1296, 720));
        assert_eq!(padded(256, 456), Size::new(540, 300));
        assert_eq!(padded(1080, 1920), Size::new(1944, 1080));
    }

    #[test]
    fn padding_mirrors_with_the_edge_repeated_even_where_it_is_wider_than_the_picture() {
        let row = Mat::from_slice(&[1_u8, 2, 3]).unwrap().try_clone().unwrap();
        let fit = Fit { clip: Size::new(3, 1), inner: Size::new(3, 1), outer: Size::new(8, 2) };
        let padded = fit.shrink(&row).unwrap();
        assert_eq!(padded.data_typed::<u8>().unwrap(), [1, 2, 3, 3, 2, 1, 1, 2, 1, 2, 3, 3, 2, 1, 1, 2]);
    }

    #[test]
    fn a_frame_comes_back_at_its_size_from_the_part_that_is_not_padding() {
        let fit = Fit::new(Size::new(640, 480), Size::new(432, 240));
        assert_eq!(fit.inner, Size::new(320, 240));
        let frame =
            Mat::new_rows_cols_with_default(480, 640, opencv::core::CV_8UC1, Scalar::all(77.0)).unwrap();
        let small = fit.shrink(&frame).unwrap();
        assert_eq!((small.cols(), small.rows()), (432, 240));
        let back = fit.enlarge(&small).unwrap();
        assert_eq!((back.cols(), back.rows()), (640, 480));
        assert!(back.data_typed::<u8>().unwrap().iter().all(|value| *value == 77));
    }
}
