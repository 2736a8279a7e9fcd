//! Conversion between our pictures and OpenCV matrices.
//!
//! Matrices keep RGB channel order: say so (`COLOR_RGB2…`) wherever OpenCV expects BGR.

use opencv::core::{
    CV_8UC1, CV_8UC3, CV_8UC4, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar,
};

use super::{Mask, Rgb8, Rgba8};
use crate::geometry::Size;

fn to_mat(size: Size, kind: i32, bytes: &[u8]) -> opencv::Result<Mat> {
    let (rows, cols) = (size.height as i32, size.width as i32);
    let mut mat = Mat::new_rows_cols_with_default(rows, cols, kind, Scalar::all(0.0))?;
    mat.data_bytes_mut()?.copy_from_slice(bytes);
    Ok(mat)
}

fn bytes_of(mat: &Mat, kind: i32) -> opencv::Result<(Size, Vec<u8>)> {
    if mat.typ() != kind {
        let message = format!("expected matrix type {kind}, found {}", mat.typ());
        return Err(opencv::Error::new(opencv::core::StsUnmatchedFormats, message));
    }
    let size = Size::new(mat.cols() as u32, mat.rows() as u32);
    let bytes = if mat.is_continuous() {
        mat.data_bytes()?.to_vec()
    } else {
        mat.try_clone()?.data_bytes()?.to_vec()
    };
    Ok((size, bytes))
}

fn wrong_length() -> opencv::Error {
    opencv::Error::new(opencv::core::StsUnmatchedSizes, "matrix bytes do not match its size")
}

impl Rgb8 {
    /// A CV_8UC3 matrix in RGB order.
    ///
    /// # Errors
    /// When OpenCV cannot allocate.
    pub fn to_mat(&self) -> opencv::Result<Mat> {
        to_mat(self.size(), CV_8UC3, self.data())
    }

    /// From a CV_8UC3 matrix in RGB order.
    ///
    /// # Errors
    /// When the matrix has another type.
    pub fn from_mat(mat: &Mat) -> opencv::Result<Self> {
        let (size, bytes) = bytes_of(mat, CV_8UC3)?;
        Self::from_data(size, bytes).ok_or_else(wrong_length)
    }
}

impl Rgb8 {
    /// The picture at another size, averaged where it shrinks.
    ///
    /// # Errors
    /// When OpenCV cannot allocate.
    pub fn resized(&self, size: Size) -> opencv::Result<Self> {
        let mut small = Mat::default();
        let to = opencv::core::Size::new(size.width as i32, size.height as i32);
        opencv::imgproc::resize(&self.to_mat()?, &mut small, to, 0.0, 0.0, opencv::imgproc::INTER_AREA)?;
        Self::from_mat(&small)
    }
}

impl Rgba8 {
    /// A CV_8UC4 matrix in RGBA order.
    ///
    /// # Errors
    /// When OpenCV cannot allocate.
    pub fn to_mat(&self) -> opencv::Result<Mat> {
        to_mat(self.size(), CV_8UC4, self.data())
    }

    /// From a CV_8UC4 matrix in RGBA order.
    ///
    /// # Errors
    /// When the matrix has another type.
    pub fn from_mat(mat: &Mat) -> opencv::Result<Self> {
        let (size, bytes) = bytes_of(mat, CV_8UC4)?;
        Self::from_data(size, bytes).ok_or_else(wrong_length)
    }
}

impl Mask {
    /// A CV_8UC1 matrix, 0 or 255.
    ///
    /// # Errors
    /// When OpenCV cannot allocate.
    pub fn to_mat(&self) -> opencv::Result<Mat> {
        to_mat(self.size(), CV_8UC1, self.data())
    }

    /// From a CV_8UC1 matrix; every non-zero value is inside.
    ///
    /// # Errors
    /// When the matrix has another type.
    pub fn from_mat(mat: &Mat) -> opencv::Result<Self> {
        let (size, bytes) = bytes_of(mat, CV_8UC1)?;
        Self::from_bytes(size, bytes).ok_or_else(wrong_length)
    }
}
