//! One frame at work scale, with what is known about arms on it.

use opencv::{
    core::{CV_8UC1, Mat, MatTraitConst, MatTraitConstManual, Point, Rect, Scalar, Vector},
    imgproc,
};

use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::Pixel,
    landmarks::{LandmarkTrack, keypoint},
    progress::Watch,
    segment::{MaskTrack, SegmentError},
    vision::{ColourModel, Plane, WorkScale},
};

use super::ObjectParams;

/// Everything a sweep reads.
pub(crate) struct Scene<'a> {
    pub frames: &'a dyn FrameSource,
    pub arms: &'a MaskTrack,
    pub landmarks: &'a LandmarkTrack,
    pub params: &'a ObjectParams,
    pub scale: WorkScale,
    /// Colours of arms over the whole clip, where any were seen.
    pub arm_colours: Option<ColourModel>,
    pub watch: &'a dyn Watch,
}

/// How sure it is that a pixel shows an arm.
pub(crate) mod arm {
    /// Not on the arm mask and not beside it.
    pub const NONE: u8 = 0;
    /// Within a few pixels of the arm mask or on the hand's skeleton.
    pub const NEAR: u8 = 1;
    /// On the arm mask, away from the hand's skeleton.
    pub const MASK: u8 = 2;
    /// On the arm mask and on the hand's skeleton.
    pub const SKELETON: u8 = 3;
}

/// A frame at work scale.
#[derive(Clone)]
pub(crate) struct View {
    pub width: usize,
    pub height: usize,
    /// CV_8UC3, RGB.
    pub rgb: Mat,
    /// CV_8UC1.
    pub gray: Mat,
    pub gray_plane: Plane,
    /// 8-bit Lab.
    pub lab: Vec<[u8; 3]>,
    /// One of [`arm`] a pixel.
    pub arms: Vec<u8>,
}

impl Scene<'_> {
    /// Loads frame `index`.
    pub fn view(&self, index: FrameIndex) -> Result<View, SegmentError> {
        let rgb = self.scale.shrink(&self.frames.frame(index)?.to_mat()?)?;
        let mut gray = Mat::default();
        imgproc::cvt_color(&rgb, &mut gray, imgproc::COLOR_RGB2GRAY, 0)?;
        let mut lab = Mat::default();
        imgproc::cvt_color(&rgb, &mut lab, imgproc::COLOR_RGB2Lab, 0)?;
        let lab = lab.data_bytes()?.as_chunks::<3>().0.to_vec();
        let (width, height) = (rgb.cols() as usize, rgb.rows() as usize);
        let arms = self.arm_classes(index)?;
        Ok(View { width, height, gray_plane: Plane::from_mat(&gray)?, rgb, gray, lab, arms })
    }

    fn arm_classes(&self, index: FrameIndex) -> Result<Vec<u8>, SegmentError> {
        let mask = self.scale.shrink_mask(&self.arms.frame(index).mask.decode().to_mat()?)?;
        let skeleton = self.skeleton(index)?;
        let mut near = Mat::default();
        let kernel = ellipse(4)?;
        dilate(&mask, &mut near, &kernel)?;
        let (mask, near, skeleton) = (mask.data_bytes()?, near.data_bytes()?, skeleton.data_bytes()?);
        let class = |at: usize| match (mask[at] != 0, skeleton[at] != 0, near[at] != 0) {
            (true, true, _) => arm::SKELETON,
            (true, false, _) => arm::MASK,
            (false, true, _) | (false, false, true) => arm::NEAR,
            _ => arm::NONE,
        };
        Ok((0..mask.len()).map(class).collect())
    }

    /// Palms and fingers drawn from the landmarks, CV_8UC1 at work scale.
    fn skeleton(&self, index: FrameIndex) -> Result<Mat, SegmentError> {
        let work = self.scale.work;
        let (rows, cols) = (work.height as i32, work.width as i32);
        let mut picture = Mat::new_rows_cols_with_default(rows, cols, CV_8UC1, Scalar::all(0.0))?;
        let Some(hands) = self.landmarks.get(index.as_usize()) else { return Ok(picture) };
        let white = Scalar::all(255.0);
        for (_, hand) in hands.iter() {
            let Some(hand) = hand else { continue };
            let points: Vec<Pixel> = hand.keypoints.iter().map(|p| self.scale.to_work(*p)).collect();
            let at = |k: usize| Point::new(points[k].x.round() as i32, points[k].y.round() as i32);
            let palm = points[5].distance(points[17]).max(0.4 * points[0].distance(points[9]));
            let hull: Vector<Point> = [0, 1, 5, 9, 13, 17].iter().map(|k| at(*k)).collect();
            imgproc::fill_poly(&mut picture, &hull, white, imgproc::LINE_8, 0, Point::default())?;
            let thickness = (0.2 * palm).round().clamp(1.0, 60.0) as i32;
            for (k, parent) in keypoint::PARENT.iter().enumerate() {
                imgproc::line(&mut picture, at(k), at(*parent), white, thickness, imgproc::LINE_8, 0)?;
            }
        }
        Ok(picture)
    }

    /// Learns the colours of arms from some frames of the clip.
    pub fn learn_arm_colours(&mut self) -> Result<(), SegmentError> {
        let count = self.frames.frame_count();
        let step = (count / 10).max(1);
        let mut samples = Vec::new();
        for index in (0..count).step_by(step) {
            if self.arms.frames[index].mask.is_empty() {
                continue;
            }
            let view = self.view(FrameIndex(index as u32))?;
            let sure = view.arms.contains(&arm::SKELETON);
            let grip = self.grip(FrameIndex(index as u32));
            for (at, (class, lab)) in view.arms.iter().zip(&view.lab).enumerate() {
                let (x, y) = ((at % view.width) as f64, (at / view.width) as f64);
                // An arm mask may have taken along what the fingers hold.
                let gripped = |(tip, reach): &(Pixel, f64)| (tip.x - x).hypot(tip.y - y) < *reach;
                let weight = match *class {
                    arm::SKELETON => 1.0,
                    arm::MASK if sure && !grip.iter().any(gripped) => 0.5,
                    arm::MASK if !sure => 0.25,
                    _ => continue,
                };
                samples.push((*lab, weight));
            }
        }
        self.arm_colours = ColourModel::learn(samples.into_iter());
        Ok(())
    }

    /// Work pixels around which a hand may hold something, with the reach of the grip.
    pub fn grip(&self, index: FrameIndex) -> Vec<(Pixel, f64)> {
        let Some(hands) = self.landmarks.get(index.as_usize()) else { return Vec::new() };
        let mut grip = Vec::new();
        for (_, hand) in hands.iter() {
            let Some(hand) = hand else { continue };
            let points: Vec<Pixel> = hand.keypoints.iter().map(|p| self.scale.to_work(*p)).collect();
            let palm = points[5].distance(points[17]).max(0.4 * points[0].distance(points[9]));
            grip.extend(keypoint::TIPS.iter().map(|k| (points[*k], palm)));
        }
        grip
    }
}

/// An elliptical kernel of `radius` pixels.
pub(crate) fn ellipse(radius: i32) -> opencv::Result<Mat> {
    let size = opencv::core::Size::new(2 * radius + 1, 2 * radius + 1);
    imgproc::get_structuring_element(imgproc::MORPH_ELLIPSE, size, Point::new(-1, -1))
}

/// Dilation with nothing beyond the border.
pub(crate) fn dilate(from: &Mat, to: &mut Mat, kernel: &Mat) -> opencv::Result<()> {
    let border = imgproc::morphology_default_border_value()?;
    imgproc::dilate(from, to, kernel, Point::new(-1, -1), 1, opencv::core::BORDER_CONSTANT, border)
}

/// A rectangle of pixels inside the work picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Roi {
    pub x: usize,
    pub y: usize,
    pub width: usize,
    pub height: usize,
}

impl Roi {
    /// The part of `x0..x1`, `y0..y1` inside a `width` × `height` picture, at least 64 pixels a side
    /// (where the picture has them): flow needs room for its pyramid.
    pub fn around(bounds: (f64, f64, f64, f64), margin: f64, width: usize, height: usize) -> Self {
        let span = |low: f64, high: f64, limit: usize| {
            let limit = limit as f64;
            let low = (low - margin).floor().clamp(0.0, (limit - 64.0).max(0.0));
            let high = (high + margin).ceil().clamp((low + 64.0).min(limit), limit.max(low + 1.0));
            (low as usize, (high.min(limit)) as usize)
        };
        let (x0, x1) = span(bounds.0, bounds.2, width);
        let (y0, y1) = span(bounds.1, bounds.3, height);
        Self { x: x0, y: y0, width: x1 - x0, height: y1 - y0 }
    }

    /// The smallest rectangle around both.
    pub fn union(&self, other: &Self) -> Self {
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        let right = (self.x + self.width).max(other.x + other.width);
        let low = (self.y + self.height).max(other.y + other.height);
        Self { x, y, width: right - x, height: low - y }
    }

    /// As OpenCV has it.
    pub fn rect(&self) -> Rect {
        Rect::new(self.x as i32, self.y as i32, self.width as i32, self.height as i32)
    }

    /// Pixels.
    pub fn area(&self) -> usize {
        self.width * self.height
    }

    /// Copies the rectangle out of a row-major picture `width` wide.
    pub fn crop<T: Copy>(&self, data: &[T], width: usize) -> Vec<T> {
        let rows = self.y..self.y + self.height;
        rows.flat_map(|y| data[y * width + self.x..y * width + self.x + self.width].iter().copied()).collect()
    }

    /// Copies the rectangle out of a matrix.
    pub fn crop_mat(&self, mat: &Mat) -> opencv::Result<Mat> {
        Mat::roi(mat, self.rect())?.try_clone()
    }

    /// A plane's rectangle.
    pub fn crop_plane(&self, plane: &Plane) -> Plane {
        Plane { width: self.width, height: self.height, data: self.crop(&plane.data, plane.width) }
    }
}
