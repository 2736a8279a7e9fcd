//! The part of a picture that a regressor sees: a square around the hand, left hands mirrored.

use opencv::{
    core::{
        BORDER_CONSTANT, BORDER_REPLICATE, CV_8UC3, Mat, MatTraitConst, MatTraitConstManual, Rect, Scalar,
        Size as CvSize,
    },
    imgproc::{INTER_LINEAR, WARP_INVERSE_MAP, gaussian_blur, warp_affine},
};

use super::contract::BoxRule;
use crate::{
    geometry::{Pixel, PixelBox, Side},
    onnx::{ChannelOrder, Layout, Normalisation},
};

/// Side of the regressor's picture, pixels.
pub const CROP_SIDE: usize = 256;
/// ImageNet's mean and deviation of red, green and blue, from 0 to 1.
const MEAN: [f32; 3] = [0.485, 0.456, 0.406];
const DEVIATION: [f32; 3] = [0.229, 0.224, 0.225];
/// Shrinking by more than twice this is preceded by a blur.
const UNBLURRED: f64 = 1.1;
/// Reach of a blur in its spreads, as scikit-image has it.
const REACH: f64 = 4.0;

/// A square of a picture, in pixels of the picture as it is (never of its mirror).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crop {
    /// Its centre.
    pub centre: Pixel,
    /// Its side.
    pub side: f64,
    /// Whose hand is in it.
    pub hand: Side,
}

impl Crop {
    /// The square for a hand in the box `bounds`.
    pub fn around(bounds: &PixelBox, hand: Side, rule: BoxRule, rescale: f64) -> Self {
        let (width, height) = (bounds.width(), bounds.height());
        let longer = match rule {
            BoxRule::Aspect => height.max(4.0 / 3.0 * width),
            BoxRule::Square => height.max(width),
        };
        Self { centre: bounds.centre(), side: (rescale * longer).max(1.0), hand }
    }

    /// Spread of the blur that keeps small things from flickering, pixels of the picture; `None` where none is needed.
    pub fn blur(&self) -> Option<f64> {
        let factor = self.side / CROP_SIDE as f64 / 2.0;
        (factor > UNBLURRED).then_some((factor - 1.0) / 2.0)
    }

    /// The square as a picture of 256×256 (CV_8UC3 like `picture`), black beyond the picture's borders.
    ///
    /// The centre comes to (128, 128). A left hand's is the right hand's of the mirrored picture, whose centre lies at
    /// W − x − 1: column by column that is the same square read from right to left.
    pub fn draw(&self, picture: &Mat) -> opencv::Result<Mat> {
        let blur = self.blur();
        let radius = blur.map_or(0, |sigma| (REACH * sigma + 0.5) as i32);
        let reach = (0.5 * self.side).min(1e6) + 2.0;
        let (x, y) = (self.centre.x.clamp(-1e6, 1e6), self.centre.y.clamp(-1e6, 1e6));
        let from = |at: f64| (at - reach).floor() as i32 - radius;
        let to = |at: f64| (at + reach).ceil() as i32 + radius;
        let (x0, y0) = (from(x).max(0), from(y).max(0));
        let (x1, y1) = (to(x).min(picture.cols()), to(y).min(picture.rows()));
        let side = CROP_SIDE as i32;
        if x1 <= x0 || y1 <= y0 {
            return Mat::new_rows_cols_with_default(side, side, CV_8UC3, Scalar::all(0.0));
        }
        let part = Mat::roi(picture, Rect::new(x0, y0, x1 - x0, y1 - y0))?;
        let mut source = part.try_clone()?;
        if let Some(sigma) = blur {
            let size = CvSize::new(2 * radius + 1, 2 * radius + 1);
            let mut soft = Mat::default();
            gaussian_blur(&part, &mut soft, size, sigma, sigma, BORDER_REPLICATE)?;
            source = soft;
        }
        let step = self.side / CROP_SIDE as f64;
        let across = if self.hand == Side::Left { -step } else { step };
        let middle = 0.5 * CROP_SIDE as f64;
        let map = Mat::from_slice_2d(&[
            [across, 0.0, x - f64::from(x0) - across * middle],
            [0.0, step, y - f64::from(y0) - step * middle],
        ])?;
        let mut crop = Mat::default();
        let (size, how) = (CvSize::new(side, side), INTER_LINEAR | WARP_INVERSE_MAP);
        warp_affine(&source, &mut crop, &map, size, how, BORDER_CONSTANT, Scalar::all(0.0))?;
        Ok(crop)
    }
}

/// How a regressor wants its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CropPixels {
    /// Order of axes.
    pub layout: Layout,
    /// Order of channels.
    pub colour: ChannelOrder,
    /// Range of values.
    pub normalisation: Normalisation,
}

impl CropPixels {
    /// The tensor's shape.
    pub fn shape(&self) -> [usize; 4] {
        match self.layout {
            Layout::Nchw => [1, 3, CROP_SIDE, CROP_SIDE],
            Layout::Nhwc => [1, CROP_SIDE, CROP_SIDE, 3],
        }
    }

    /// The numbers of `crop`, CV_8UC3 in RGB.
    ///
    /// # Errors
    /// When `crop` is no such picture.
    pub fn numbers(&self, crop: &Mat) -> opencv::Result<Vec<f32>> {
        let channels = match self.colour {
            ChannelOrder::Rgb => [0, 1, 2],
            ChannelOrder::Bgr => [2, 1, 0],
        };
        let tables = channels.map(|channel| self.table(channel));
        let pixels = crop.data_bytes()?;
        let mut numbers = Vec::with_capacity(pixels.len());
        match self.layout {
            Layout::Nchw => {
                for (channel, table) in channels.into_iter().zip(&tables) {
                    numbers.extend(pixels.chunks_exact(3).map(|pixel| table[usize::from(pixel[channel])]));
                }
            }
            Layout::Nhwc => {
                for pixel in pixels.chunks_exact(3) {
                    numbers.extend((0..3).map(|at| tables[at][usize::from(pixel[channels[at]])]));
                }
            }
        }
        Ok(numbers)
    }

    /// What each byte of a channel becomes.
    fn table(&self, channel: usize) -> [f32; 256] {
        std::array::from_fn(|byte| {
            let byte = byte as f32;
            match self.normalisation {
                Normalisation::Bytes => byte,
                Normalisation::Unit => byte / 255.0,
                Normalisation::ImageNet => (byte - 255.0 * MEAN[channel]) / (255.0 * DEVIATION[channel]),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::Size, image::Rgb8};

    fn picture(mirrored: bool) -> Mat {
        let size = Size::new(400, 300);
        let mut picture = Rgb8::new(size);
        for y in 0..size.height {
            for x in 0..size.width {
                let at = if mirrored { size.width - 1 - x } else { x };
                picture.set_pixel(x, y, [(at / 2) as u8, (y / 2) as u8, ((at + y) / 3) as u8]);
            }
        }
        picture.to_mat().unwrap()
    }

    #[test]
    fn both_box_rules_give_the_squares_of_their_authors() {
        let high = PixelBox { x0: 10.0, y0: 20.0, x1: 70.0, y1: 120.0 };
        let wide = PixelBox { x0: 10.0, y0: 20.0, x1: 130.0, y1: 80.0 };
        let side = |bounds: &PixelBox, rule: BoxRule| {
            Crop::around(bounds, Side::Right, rule, rule.usual_rescale()).side
        };
        assert_eq!((side(&high, BoxRule::Aspect), side(&high, BoxRule::Square)), (200.0, 250.0));
        assert_eq!((side(&wide, BoxRule::Aspect), side(&wide, BoxRule::Square)), (320.0, 300.0));
        assert_eq!(Crop::around(&wide, Side::Left, BoxRule::Square, 2.5).centre, Pixel::new(70.0, 50.0));
    }

    #[test]
    fn a_left_hand_is_the_right_hand_of_the_mirrored_picture() {
        let left = Crop { centre: Pixel::new(130.0, 140.0), side: 181.0, hand: Side::Left };
        let right = Crop { centre: Pixel::new(400.0 - 130.0 - 1.0, 140.0), hand: Side::Right, ..left };
        let (one, other) = (left.draw(&picture(false)).unwrap(), right.draw(&picture(true)).unwrap());
        let pairs = one.data_bytes().unwrap().iter().zip(other.data_bytes().unwrap());
        // Positions are rounded to 1/32 of a pixel, here and there to the other side.
        assert!(pairs.into_iter().all(|(a, b)| a.abs_diff(*b) <= 1));
    }

    #[test]
    fn the_centre_comes_to_the_middle_and_beyond_the_border_is_black() {
        let crop = Crop { centre: Pixel::new(60.0, 80.0), side: 256.0, hand: Side::Right };
        let drawn = crop.draw(&picture(false)).unwrap();
        let at = |x: usize, y: usize| &drawn.data_bytes().unwrap()[(y * CROP_SIDE + x) * 3..][..3];
        assert_eq!(at(128, 128), [30, 40, 46]);
        assert_eq!(at(20, 128), [0; 3]);
        let nowhere = Crop { centre: Pixel::new(-5000.0, 80.0), ..crop };
        assert!(nowhere.draw(&picture(false)).unwrap().data_bytes().unwrap().iter().all(|value| *value == 0));
    }

    #[test]
    fn only_strong_shrinking_is_preceded_by_a_blur() {
        let of = |side: f64| Crop { centre: Pixel::default(), side, hand: Side::Right }.blur();
        assert_eq!(of(256.0 * 2.2), None);
        assert!((of(256.0 * 3.0).unwrap() - 0.25).abs() < 1e-12);
        let crop = Crop { centre: Pixel::new(200.0, 150.0), side: 1500.0, hand: Side::Right };
        assert_eq!(crop.draw(&picture(false)).unwrap().rows(), 256);
    }

    #[test]
    fn numbers_come_as_the_model_wants_them() {
        let pixel =
            Mat::from_slice(&[opencv::core::Vec3b::from([255, 0, 127])]).unwrap().try_clone().unwrap();
        let want = |layout, colour, normalisation| {
            CropPixels { layout, colour, normalisation }.numbers(&pixel).unwrap()
        };
        use {ChannelOrder::*, Layout::*, Normalisation::*};
        assert_eq!(want(Nhwc, Bgr, Bytes), [127.0, 0.0, 255.0]);
        assert_eq!(want(Nchw, Rgb, Unit), [1.0, 0.0, 127.0 / 255.0]);
        let net = want(Nchw, Bgr, ImageNet);
        assert!((net[2] - (1.0 - 0.485) / 0.229).abs() < 1e-5 && (net[1] + 0.456 / 0.224).abs() < 1e-5);
    }
}
