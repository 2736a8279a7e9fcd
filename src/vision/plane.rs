//! One-channel float pictures with sub-pixel access.

use opencv::{
    core::{CV_8UC1, CV_32FC1, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar},
    imgproc,
};

/// A one-channel float picture, row after row.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` values.
    pub data: Vec<f32>,
}

impl Plane {
    /// A plane of zeros.
    pub fn zeros(width: usize, height: usize) -> Self {
        Self { width, height, data: vec![0.0; width * height] }
    }

    /// A plane made by asking `value(x, y)` for every pixel.
    pub fn from_fn(width: usize, height: usize, value: impl Fn(usize, usize) -> f32) -> Self {
        let data = (0..width * height).map(|index| value(index % width, index / width)).collect();
        Self { width, height, data }
    }

    /// From a CV_8UC1 or CV_32FC1 matrix.
    ///
    /// # Errors
    /// When the matrix has another type.
    pub fn from_mat(mat: &Mat) -> opencv::Result<Self> {
        let (width, height) = (mat.cols() as usize, mat.rows() as usize);
        let mat = if mat.is_continuous() { mat.clone() } else { mat.try_clone()? };
        let data = match mat.typ() {
            CV_8UC1 => mat.data_bytes()?.iter().map(|value| f32::from(*value)).collect(),
            _ => mat.data_typed::<f32>()?.to_vec(),
        };
        Ok(Self { width, height, data })
    }

    /// As a CV_32FC1 matrix.
    ///
    /// # Errors
    /// When OpenCV cannot allocate.
    pub fn to_mat(&self) -> opencv::Result<Mat> {
        let (rows, cols) = (self.height as i32, self.width as i32);
        let mut mat = Mat::new_rows_cols_with_default(rows, cols, CV_32FC1, Scalar::all(0.0))?;
        mat.data_typed_mut::<f32>()?.copy_from_slice(&self.data);
        Ok(mat)
    }

    /// The value in column `x`, row `y`.
    pub fn at(&self, x: usize, y: usize) -> f32 {
        self.data[y * self.width + x]
    }

    /// The value nearest to column `x`, row `y`, the border repeated outwards.
    pub fn clamped(&self, x: i64, y: i64) -> f32 {
        let x = x.clamp(0, self.width as i64 - 1) as usize;
        let y = y.clamp(0, self.height as i64 - 1) as usize;
        self.data[y * self.width + x]
    }

    /// Bilinear sample; `None` outside the picture.
    pub fn sample(&self, x: f64, y: f64) -> Option<f32> {
        if !(x >= 0.0 && y >= 0.0 && x <= (self.width - 1) as f64 && y <= (self.height - 1) as f64) {
            return None;
        }
        let (x0, y0) = ((x as usize).min(self.width - 2), (y as usize).min(self.height - 2));
        let (fx, fy) = ((x - x0 as f64) as f32, (y - y0 as f64) as f32);
        let at = y0 * self.width + x0;
        let top = self.data[at] * (1.0 - fx) + self.data[at + 1] * fx;
        let low = self.data[at + self.width] * (1.0 - fx) + self.data[at + self.width + 1] * fx;
        Some(top * (1.0 - fy) + low * fy)
    }

    /// Gaussian blur with standard deviation `sigma` pixels.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn blurred(&self, sigma: f64) -> opencv::Result<Self> {
        let mut out = Mat::default();
        let kernel = opencv::core::Size::new(0, 0);
        let border = opencv::core::BORDER_REPLICATE;
        imgproc::gaussian_blur(&self.to_mat()?, &mut out, kernel, sigma, sigma, border)?;
        Self::from_mat(&out)
    }
}
