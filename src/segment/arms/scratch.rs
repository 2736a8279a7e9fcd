//! The clip at work scale in a scratch file: every frame is read and shrunk once, and what is found out about
//! it is kept beside it, so that memory does not grow with the clip.

use std::{fs::File, io, os::unix::fs::FileExt, path::Path};

use opencv::{
    core::{CV_8UC1, CV_8UC3, CV_32FC2, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar},
    imgproc,
};

use super::work_frame::WorkFrame;
use crate::{geometry::Size, segment::SegmentError, vision::Flow};

/// Flow vectors are kept for every fourth pixel: the estimator's own finest grid.
pub(super) const FLOW_STRIDE: u32 = 4;
/// Steps a pixel of a kept flow vector.
const FLOW_STEPS: f32 = 16.0;

/// What is kept of a frame, with its bytes a pixel in the file's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layer {
    /// Change against the background plate, CV_8UC1.
    Change,
    /// P(arm), CV_8UC1.
    Likely,
    /// P(arm | colour), CV_8UC1.
    Colour,
}

/// Which neighbour a flow leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Towards {
    /// The frame before.
    Before,
    /// The frame after.
    After,
}

/// The scratch file; it has no name and vanishes with the last handle.
#[derive(Debug)]
pub(super) struct Scratch {
    file: File,
    size: Size,
}

impl Scratch {
    /// An empty scratch file in `folder` for pictures of `size`.
    pub fn create(folder: &Path, size: Size) -> Result<Self, SegmentError> {
        let file = tempfile::tempfile_in(folder).map_err(|source| failed(folder, source))?;
        Ok(Self { file, size })
    }

    fn flow_size(&self) -> (usize, usize) {
        (self.size.width.div_ceil(FLOW_STRIDE) as usize, self.size.height.div_ceil(FLOW_STRIDE) as usize)
    }

    fn offset(&self, index: usize, within: usize) -> u64 {
        let flow = self.flow_size();
        (index * (7 * self.size.area() + 8 * flow.0 * flow.1) + within) as u64
    }

    fn write(&self, index: usize, within: usize, bytes: &[u8]) -> Result<(), SegmentError> {
        let written = self.file.write_all_at(bytes, self.offset(index, within));
        written.map_err(|source| failed(Path::new("(unnamed)"), source))
    }

    fn read(&self, index: usize, within: usize, bytes: &mut [u8]) -> Result<(), SegmentError> {
        let read = self.file.read_exact_at(bytes, self.offset(index, within));
        read.map_err(|source| failed(Path::new("(unnamed)"), source))
    }

    fn matrix(&self, kind: i32) -> opencv::Result<Mat> {
        let (rows, cols) = (self.size.height as i32, self.size.width as i32);
        Mat::new_rows_cols_with_default(rows, cols, kind, Scalar::all(0.0))
    }

    /// Keeps frame `index`.
    pub fn put_frame(&self, index: usize, frame: &WorkFrame) -> Result<(), SegmentError> {
        self.write(index, 0, frame.lab.data_bytes()?)?;
        self.write(index, 3 * self.size.area(), frame.grey.data_bytes()?)
    }

    /// Frame `index` as it was kept.
    pub fn frame(&self, index: usize) -> Result<WorkFrame, SegmentError> {
        let mut lab = self.matrix(CV_8UC3)?;
        self.read(index, 0, lab.data_bytes_mut()?)?;
        Ok(WorkFrame { lab, grey: self.grey(index)? })
    }

    /// The luminance of frame `index` alone.
    pub fn grey(&self, index: usize) -> Result<Mat, SegmentError> {
        let mut grey = self.matrix(CV_8UC1)?;
        self.read(index, 3 * self.size.area(), grey.data_bytes_mut()?)?;
        Ok(grey)
    }

    fn layer_start(&self, layer: Layer) -> usize {
        let position = match layer {
            Layer::Change => 4,
            Layer::Likely => 5,
            Layer::Colour => 6,
        };
        position * self.size.area()
    }

    /// Keeps a layer of frame `index`.
    pub fn put(&self, index: usize, layer: Layer, values: &Mat) -> Result<(), SegmentError> {
        self.write(index, self.layer_start(layer), values.data_bytes()?)
    }

    /// A layer of frame `index` as it was kept.
    pub fn get(&self, index: usize, layer: Layer) -> Result<Mat, SegmentError> {
        let mut values = self.matrix(CV_8UC1)?;
        self.read(index, self.layer_start(layer), values.data_bytes_mut()?)?;
        Ok(values)
    }

    fn flow_start(&self, towards: Towards) -> usize {
        let (cols, rows) = self.flow_size();
        7 * self.size.area() + if towards == Towards::After { 4 * cols * rows } else { 0 }
    }

    /// Keeps the flow from frame `index` to a neighbour.
    pub fn put_flow(&self, index: usize, towards: Towards, flow: &Flow) -> Result<(), SegmentError> {
        let (cols, rows) = self.flow_size();
        let mut bytes = Vec::with_capacity(4 * cols * rows);
        let centre = |cell: usize, length: u32| {
            (cell as u32 * FLOW_STRIDE + FLOW_STRIDE / 2).min(length.saturating_sub(1))
        };
        for cell in 0..rows * cols {
            let (x, y) = (centre(cell % cols, self.size.width), centre(cell / cols, self.size.height));
            for component in flow.at(x, y) {
                bytes.extend(((component * FLOW_STEPS).round() as i16).to_le_bytes());
            }
        }
        self.write(index, self.flow_start(towards), &bytes)
    }

    /// The kept flow, one vector for every [`FLOW_STRIDE`]th pixel in rows of the length that comes with it.
    pub fn flow(&self, index: usize, towards: Towards) -> Result<(Vec<[f32; 2]>, usize), SegmentError> {
        let (cols, rows) = self.flow_size();
        let mut bytes = vec![0; 4 * cols * rows];
        self.read(index, self.flow_start(towards), &mut bytes)?;
        let component = |pair: [u8; 2]| f32::from(i16::from_le_bytes(pair)) / FLOW_STEPS;
        let vectors = bytes.as_chunks::<4>().0.iter();
        Ok((vectors.map(|[a, b, c, d]| [component([*a, *b]), component([*c, *d])]).collect(), cols))
    }

    /// Draws `picture` of the neighbour on the grid of frame `index`, along the kept flow.
    pub fn pulled(&self, index: usize, towards: Towards, picture: &Mat) -> Result<Mat, SegmentError> {
        let (cols, rows) = self.flow_size();
        let (vectors, _) = self.flow(index, towards)?;
        let vectors = vectors.as_flattened();
        let coarse = Mat::new_rows_cols_with_data(rows as i32, 2 * cols as i32, vectors)?;
        let coarse = coarse.reshape(2, rows as i32)?;
        let padded =
            opencv::core::Size::new((cols as u32 * FLOW_STRIDE) as i32, (rows as u32 * FLOW_STRIDE) as i32);
        let mut fine = Mat::default();
        imgproc::resize(&coarse, &mut fine, padded, 0.0, 0.0, imgproc::INTER_LINEAR)?;
        let mut map = self.matrix(CV_32FC2)?;
        let width = self.size.width as usize;
        let wide = padded.width as usize;
        let fine = fine.data_typed::<opencv::core::Vec2f>()?;
        for (position, value) in map.data_typed_mut::<opencv::core::Vec2f>()?.iter_mut().enumerate() {
            let (x, y) = (position % width, position / width);
            let vector = fine[y * wide + x];
            value[0] = x as f32 + vector[0];
            value[1] = y as f32 + vector[1];
        }
        let mut out = Mat::default();
        // What flows in over the border continues what is there.
        let (nothing, border) = (Mat::default(), opencv::core::BORDER_REPLICATE);
        imgproc::remap(picture, &mut out, &map, &nothing, imgproc::INTER_LINEAR, border, Scalar::all(0.0))?;
        Ok(out)
    }
}

fn failed(path: &Path, source: io::Error) -> SegmentError {
    SegmentError::Scratch { path: path.into(), source }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::{FlowQuality, binary, dense_flow};

    fn texture(shift: i32) -> Mat {
        let mut grey = binary::empty(60, 80).unwrap();
        for (i, value) in grey.data_bytes_mut().unwrap().iter_mut().enumerate() {
            let (x, y) = ((i % 80) as i32 - shift, (i / 80) as i32);
            *value =
                (128.0 + 60.0 * (0.4 * f64::from(x)).sin() + 50.0 * (0.3 * f64::from(y + x)).cos()) as u8;
        }
        grey
    }

    #[test]
    fn what_was_kept_comes_back_and_the_kept_flow_carries_a_mask_along() {
        let folder = tempfile::tempdir().unwrap();
        let scratch = Scratch::create(folder.path(), Size::new(80, 60)).unwrap();
        let (first, second) = (texture(0), texture(3));
        scratch.put(2, Layer::Change, &first).unwrap();
        assert_eq!(scratch.get(2, Layer::Change).unwrap().data_bytes().unwrap(), first.data_bytes().unwrap());

        let flow = dense_flow(&second, &first, FlowQuality::Fast).unwrap();
        scratch.put_flow(1, Towards::Before, &flow).unwrap();
        let block = |left: usize| {
            let empty = binary::empty(60, 80).unwrap();
            let mut mask = binary::map2(&empty, &empty, |_, _| 0).unwrap();
            for (i, value) in mask.data_bytes_mut().unwrap().iter_mut().enumerate() {
                let inside = (left..left + 20).contains(&(i % 80)) && (20..40).contains(&(i / 80));
                *value = if inside { 255 } else { 0 };
            }
            mask
        };
        let carried = scratch.pulled(1, Towards::Before, &block(30)).unwrap();
        let carried = binary::map2(&carried, &carried, |v, _| if v > 127 { 255 } else { 0 }).unwrap();
        assert!(binary::iou(&carried, &block(33)).unwrap() > 0.85);
    }
}
