//! The loaded network.

use opencv::{
    core::{
        BORDER_REFLECT_101, CV_8UC3, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar,
        Size as CvSize, copy_make_border,
    },
    imgproc::{INTER_AREA, INTER_LINEAR, resize},
};

use super::contract::IMAGE_INPAINT;
use crate::{
    inpaint::InpaintError,
    onnx::{CheckedModel, Graph, OnnxError, Runtime, Sizes, Value},
};

/// Side of the network's picture where neither graph nor description says it: LaMa's.
const USUAL_SIDE: usize = 512;
/// Sides are multiples of this.
const MULTIPLE: usize = 8;
/// Largest side that a description may ask for.
const LARGEST_SIDE: usize = 4096;

/// A network that closes a hole in one picture.
#[derive(Debug)]
pub struct ImageNetwork {
    graph: Graph,
    side: usize,
    name: String,
}

impl ImageNetwork {
    /// Loads the network of `model`.
    ///
    /// # Errors
    /// When it is no such network.
    pub fn open(runtime: &Runtime, model: &CheckedModel) -> Result<Self, OnnxError> {
        let spec = &IMAGE_INPAINT.graphs[0];
        let mut sizes = Sizes::default();
        let graph = Graph::open(runtime, model.file(spec.name)?, spec, &mut sizes)?;
        let side = model.size(&sizes, "S").unwrap_or(USUAL_SIDE);
        if !side.is_multiple_of(MULTIPLE) || !(MULTIPLE..=LARGEST_SIDE).contains(&side) {
            return Err(model.wrong(format!("S = {side}: a multiple of {MULTIPLE} expected")));
        }
        Ok(Self { graph, side, name: model.description().name.clone() })
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Side of its pictures, pixels.
    pub fn side(&self) -> usize {
        self.side
    }

    /// `picture` (CV_8UC3, RGB, any size) with what is under `hole` (CV_8UC1) made up. A picture that is not square is
    /// mirrored beyond its edges, one larger than the network's is shrunk and enlarged again: take the colours under the
    /// hole alone.
    ///
    /// # Errors
    /// When OpenCV or the graph fails.
    pub fn restored(&mut self, picture: &Mat, hole: &Mat) -> Result<Mat, InpaintError> {
        let (columns, rows) = (picture.cols(), picture.rows());
        let square = columns.max(rows).max(self.side as i32);
        let (picture, hole) = (squared(picture, square)?, squared(hole, square)?);
        let side = self.side as i32;
        let small = |mat: &Mat| -> opencv::Result<Mat> {
            let mut small = Mat::default();
            resize(mat, &mut small, CvSize::new(side, side), 0.0, 0.0, INTER_AREA)?;
            Ok(small)
        };
        let (near, hidden) = (small(&picture)?, small(&hole)?);
        let output = self.run(&near, &hidden)?;
        let mut large = Mat::default();
        resize(&output, &mut large, CvSize::new(square, square), 0.0, 0.0, INTER_LINEAR)?;
        let whole = opencv::core::Rect::new(0, 0, columns, rows);
        Ok(Mat::roi(&large, whole)?.try_clone()?)
    }

    /// One call of the graph on pictures of its own size.
    fn run(&mut self, picture: &Mat, hole: &Mat) -> Result<Mat, InpaintError> {
        let (pixels, hidden) = (picture.data_bytes()?, hole.data_bytes()?);
        let plane = self.side * self.side;
        let mut image = Vec::with_capacity(3 * plane);
        for channel in 0..3 {
            let values = pixels.iter().skip(channel).step_by(3).zip(hidden);
            image
                .extend(values.map(|(value, hole)| if *hole == 0 { f32::from(*value) / 255.0 } else { 0.0 }));
        }
        let mask = hidden.iter().map(|hole| if *hole == 0 { 0.0 } else { 1.0 }).collect();
        let image = Value::floats(&[1, 3, self.side, self.side], image)?;
        let mask = Value::floats(&[1, 1, self.side, self.side], mask)?;
        let outputs = self.graph.run(&[("image", &image), ("mask", &mask)])?;
        let values = outputs.floats("output")?;
        if values.len() < 3 * plane {
            let reason = format!("returned {} numbers, {} expected", values.len(), 3 * plane);
            return Err(OnnxError::Run { graph: IMAGE_INPAINT.id, reason }.into());
        }
        let mut restored =
            Mat::new_rows_cols_with_default(self.side as i32, self.side as i32, CV_8UC3, Scalar::all(0.0))?;
        for (at, byte) in restored.data_bytes_mut()?.iter_mut().enumerate() {
            // What the network says of known places would bleed into the hole when it is enlarged. What is not a number
            // becomes black.
            *byte = match hidden[at / 3] {
                0 => pixels[at],
                _ => values[(at % 3) * plane + at / 3].round().clamp(0.0, 255.0) as u8,
            };
        }
        Ok(restored)
    }
}

/// A picture or mask continued to the right and below by its mirror image.
fn squared(picture: &Mat, side: i32) -> opencv::Result<Mat> {
    let mut out = picture.try_clone()?;
    // A mirror image is at most as large as what it shows.
    while out.cols() < side || out.rows() < side {
        let right = (side - out.cols()).min((out.cols() - 1).max(1));
        let below = (side - out.rows()).min((out.rows() - 1).max(1));
        let from = out;
        out = Mat::default();
        copy_make_border(&from, &mut out, 0, below, 0, right, BORDER_REFLECT_101, Scalar::all(0.0))?;
    }
    Ok(out)
}
