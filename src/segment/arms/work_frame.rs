//! One frame at work scale, in the colour spaces that the arm masks need.

use opencv::{
    core::{Mat, MatTraitConstManual, Vec3b},
    imgproc,
};

use crate::{
    clip::{FrameIndex, FrameSource},
    segment::SegmentError,
    vision::{LabHistogram, WorkScale, binary, box_blurred},
};

/// A frame at work scale.
#[derive(Debug)]
pub(super) struct WorkFrame {
    /// Lab, CV_8UC3, lightly blurred.
    pub lab: Mat,
    /// Luminance, CV_8UC1.
    pub grey: Mat,
}

impl WorkFrame {
    /// Reads and shrinks frame `index`.
    pub fn read(
        frames: &dyn FrameSource,
        index: FrameIndex,
        scale: &WorkScale,
    ) -> Result<Self, SegmentError> {
        let picture = frames.frame(index)?;
        let (rows, cols) = (picture.size().height as i32, picture.size().width as i32);
        let borrowed = Mat::new_rows_cols_with_bytes::<Vec3b>(rows, cols, picture.data())?;
        let small = scale.shrink(&borrowed)?;
        drop(borrowed);
        let mut soft = Mat::default();
        let kernel = opencv::core::Size::new(3, 3);
        imgproc::gaussian_blur(&small, &mut soft, kernel, 0.8, 0.8, opencv::core::BORDER_REPLICATE)?;
        let (mut lab, mut grey) = (Mat::default(), Mat::default());
        imgproc::cvt_color(&soft, &mut lab, imgproc::COLOR_RGB2Lab, 0)?;
        imgproc::cvt_color(&small, &mut grey, imgproc::COLOR_RGB2GRAY, 0)?;
        Ok(Self { lab, grey })
    }

    /// Lab pixels in row order.
    pub fn pixels(&self) -> opencv::Result<&[[u8; 3]]> {
        Ok(self.lab.data_bytes()?.as_chunks::<3>().0)
    }

    /// P(arm | colour), 0 to 255, averaged over 3×3 pixels.
    pub fn posterior(&self, table: &[u8]) -> opencv::Result<Mat> {
        use opencv::core::{MatTraitConst, MatTraitManual};
        let mut raw = binary::empty(self.lab.rows(), self.lab.cols())?;
        for (value, lab) in raw.data_bytes_mut()?.iter_mut().zip(self.pixels()?) {
            *value = LabHistogram::look_up(table, *lab);
        }
        box_blurred(&raw, 3)
    }
}
