//! Dense optical flow (Kroeger et al. 2016, DIS) with forward-backward consistency.

use opencv::{
    core::{CV_32FC1, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar},
    imgproc,
    prelude::*,
    video::DISOpticalFlow,
};
use serde::{Deserialize, Serialize};

use crate::geometry::{Pixel, Size};

/// Speed against density of the flow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FlowQuality {
    /// About 3 ms at 320×240.
    #[default]
    Fast,
    /// About 8 ms at 320×240, finer.
    Medium,
}

/// A displacement in pixels for every pixel: `p` in the first picture lies at `p + flow(p)` in the second.
#[derive(Clone, Debug)]
pub struct Flow {
    size: Size,
    vectors: Vec<[f32; 2]>,
}

/// The flow from `first` to `second`, both CV_8UC1 of one size.
///
/// # Errors
/// When the pictures do not match or OpenCV fails.
pub fn dense_flow(first: &Mat, second: &Mat, quality: FlowQuality) -> opencv::Result<Flow> {
    let preset = match quality {
        FlowQuality::Fast => opencv::video::DISOpticalFlow_PRESET_FAST,
        FlowQuality::Medium => opencv::video::DISOpticalFlow_PRESET_MEDIUM,
    };
    let mut estimator = DISOpticalFlow::create(preset)?;
    let mut field = Mat::default();
    estimator.calc(first, second, &mut field)?;
    let size = Size::new(first.cols() as u32, first.rows() as u32);
    let vectors: Vec<[f32; 2]> =
        field.data_typed::<opencv::core::Vec2f>()?.iter().map(|v| [v[0], v[1]]).collect();
    Ok(Flow { size, vectors })
}

impl Flow {
    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// All displacements, row after row.
    pub fn vectors(&self) -> &[[f32; 2]] {
        &self.vectors
    }

    /// The displacement at column `x`, row `y`.
    pub fn at(&self, x: u32, y: u32) -> [f32; 2] {
        self.vectors[y as usize * self.size.width as usize + x as usize]
    }

    /// The displacement at the pixel nearest to `p`; zero outside the picture.
    pub fn near(&self, p: Pixel) -> [f32; 2] {
        let (x, y) = (p.x.round(), p.y.round());
        if x < 0.0 || y < 0.0 || x >= f64::from(self.size.width) || y >= f64::from(self.size.height) {
            return [0.0, 0.0];
        }
        self.at(x as u32, y as u32)
    }

    /// Samples `picture` (any type, of the flow's second picture) at `p + flow(p)`: the second
    /// picture's content drawn on the first picture's grid. Outside the picture: zero.
    ///
    /// To carry a mask from frame t to t+1, pass the flow from t+1 to t.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn pull(&self, picture: &Mat) -> opencv::Result<Mat> {
        let (rows, cols) = (self.size.height as i32, self.size.width as i32);
        let mut map_x = Mat::new_rows_cols_with_default(rows, cols, CV_32FC1, Scalar::all(0.0))?;
        let mut map_y = map_x.try_clone()?;
        {
            let xs = map_x.data_typed_mut::<f32>()?;
            let ys = map_y.data_typed_mut::<f32>()?;
            let width = self.size.width as usize;
            for (index, vector) in self.vectors.iter().enumerate() {
                xs[index] = (index % width) as f32 + vector[0];
                ys[index] = (index / width) as f32 + vector[1];
            }
        }
        let mut out = Mat::default();
        let border = opencv::core::BORDER_CONSTANT;
        imgproc::remap(picture, &mut out, &map_x, &map_y, imgproc::INTER_LINEAR, border, Scalar::all(0.0))?;
        Ok(out)
    }

    /// Per pixel of the first picture, whether `backward` (second to first) returns to it:
    /// |w + w'|² ≤ 0.01 (|w|² + |w'|²) + 0.5 (Sundaram et al. 2010).
    pub fn consistency(&self, backward: &Self) -> Vec<bool> {
        let width = self.size.width as usize;
        let consistent = |(index, w): (usize, &[f32; 2])| {
            let target = Pixel::new(
                (index % width) as f64 + f64::from(w[0]),
                (index / width) as f64 + f64::from(w[1]),
            );
            let inside = target.x > -0.5
                && target.y > -0.5
                && target.x < f64::from(self.size.width) - 0.5
                && target.y < f64::from(self.size.height) - 0.5;
            let b = backward.near(target);
            let error = (w[0] + b[0]).powi(2) + (w[1] + b[1]).powi(2);
            let length = w[0] * w[0] + w[1] * w[1] + b[0] * b[0] + b[1] * b[1];
            inside && error <= 0.01 * length + 0.5
        };
        self.vectors.iter().enumerate().map(consistent).collect()
    }
}
