//! How much a frame differs from the background behind it, moving head included.

use nalgebra::Matrix3;
use opencv::{
    core::{CV_8UC3, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar},
    imgproc,
};
use rayon::prelude::*;

use super::{Clip, runs, work_frame::WorkFrame};
use crate::{
    clip::FrameIndex,
    segment::SegmentError,
    vision::{BackgroundMotion, background_motion, binary},
};

/// Samples that one plate is the median of.
const SAMPLES: usize = 9;
/// In a sample: an arm is there.
pub(super) const HIDDEN: u8 = 255;
/// In a sample: an arm could be there, so the sample cannot prove that a pixel is background.
pub(super) const DOUBTFUL: u8 = 128;
/// The smallest change reported where only doubtful samples exist: evidence for neither side.
pub(super) const NEUTRAL: u8 = 15;
/// The change where the background was never seen.
pub(super) const UNKNOWN: u8 = 255;
/// The change reported for the background in shadow: none.
pub(super) const SHADOW: u8 = 0;
/// Key frames over the whole clip.
const KEYFRAMES: usize = 40;

/// Frames at work scale spread over the clip, with the homography of every frame to the first.
pub(super) struct Plate {
    /// From each frame to the first of its unbroken run, and the run's number.
    placed: Vec<(usize, Matrix3<f64>)>,
    keyframes: Vec<Keyframe>,
}

struct Keyframe {
    index: usize,
    lab: Mat,
    /// [`HIDDEN`], [`DOUBTFUL`] or 0.
    hidden: Mat,
}

impl Plate {
    /// Aligns the clip at work scale; `table` is the colour model so far.
    pub fn build(clip: &Clip<'_>, table: &[u8]) -> Result<Self, SegmentError> {
        let stride = clip.count().div_ceil(KEYFRAMES).max(1);
        let parts = runs(clip.count())
            .into_par_iter()
            .map(|run| align_run(clip, table, run, stride))
            .collect::<Result<Vec<_>, SegmentError>>()?;
        let mut placed: Vec<(usize, Matrix3<f64>)> = Vec::with_capacity(clip.count());
        let mut keyframes = Vec::new();
        for part in parts {
            for step in part.steps {
                placed.push(match (placed.last(), step) {
                    (Some((run, to_first)), Some(motion)) => (*run, to_first * motion.homography),
                    (Some((run, _)), None) => (run + 1, Matrix3::identity()),
                    (None, _) => (0, Matrix3::identity()),
                });
            }
            keyframes.extend(part.keyframes);
        }
        Ok(Self { placed, keyframes })
    }

    /// Lab distance of `frame` from the median of aligned key frames, CV_8UC1, at most 254;
    /// [`UNKNOWN`] where fewer than two key frames saw the background.
    pub fn change(&self, index: usize, frame: &WorkFrame) -> opencv::Result<Mat> {
        let samples = self.samples(index)?;
        let (rows, cols) = (frame.grey.rows(), frame.grey.cols());
        let mut change = binary::empty(rows, cols)?;
        let labs = samples
            .iter()
            .map(|(lab, hidden)| Ok((lab.data_bytes()?.as_chunks::<3>().0, hidden.data_bytes()?)))
            .collect::<opencv::Result<Vec<_>>>()?;
        let pixels = frame.pixels()?;
        let mut plate_light: Vec<u8> = pixels.iter().map(|lab| lab[0]).collect();
        let mut shadowed = vec![Shade::No; pixels.len()];
        for (position, value) in change.data_bytes_mut()?.iter_mut().enumerate() {
            let mut seen = [[0_u8; SAMPLES]; 3];
            let (mut count, mut certain) = (0, 0);
            for (lab, hidden) in &labs {
                if hidden[position] != HIDDEN {
                    for channel in 0..3 {
                        seen[channel][count] = lab[position][channel];
                    }
                    count += 1;
                    certain += usize::from(hidden[position] == 0);
                }
            }
            if count < 2 {
                *value = UNKNOWN;
                continue;
            }
            let median = [0, 1, 2].map(|channel| {
                let values = &mut seen[channel][..count];
                values.sort_unstable();
                values[count / 2]
            });
            plate_light[position] = median[0];
            shadowed[position] = is_shaded(pixels[position], median);
            let squared: f32 = (0..3)
                .map(|channel| (f32::from(pixels[position][channel]) - f32::from(median[channel])).powi(2))
                .sum();
            let difference = squared.sqrt().min(254.0) as u8;
            *value = if certain < 2 { difference.max(NEUTRAL) } else { difference };
        }
        let light: Vec<u8> = pixels.iter().map(|lab| lab[0]).collect();
        let alike = same_texture(&light, &plate_light, (rows, cols))?;
        for ((value, shade), alike) in change.data_bytes_mut()?.iter_mut().zip(shadowed).zip(alike) {
            let shadow = match shade {
                Shade::Surely => alike != Texture::Other,
                Shade::Perhaps => alike == Texture::Same,
                Shade::No => false,
            };
            if shadow {
                *value = SHADOW;
            }
        }
        Ok(change)
    }

    /// Key frames of the same run drawn on the grid of frame `index`, with what is not to be used.
    fn samples(&self, index: usize) -> opencv::Result<Vec<(Mat, Mat)>> {
        let (run, to_first) = self.placed[index];
        let near: Vec<&Keyframe> = self
            .keyframes
            .iter()
            .filter(|key| self.placed[key.index].0 == run && key.index != index)
            .collect();
        let stride = near.len().div_ceil(SAMPLES).max(1);
        let mut samples = Vec::new();
        for key in near.iter().skip(stride / 2).step_by(stride).take(SAMPLES) {
            let Some(inverse) = self.placed[key.index].1.try_inverse() else { continue };
            let motion = BackgroundMotion { homography: inverse * to_first, inlier_share: 1.0, inliers: 0 };
            samples.push(warped(key, &motion)?);
        }
        Ok(samples)
    }
}

/// Whether a pixel may be the background in shadow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shade {
    No,
    /// Darker and of a similar hue: shadow if the background's texture shows through.
    Perhaps,
    /// Darker and of the very same hue.
    Surely,
}

/// A shadow scales lightness and with it chroma (both in OpenCV's 8-bit Lab).
fn is_shaded(pixel: [u8; 3], background: [u8; 3]) -> Shade {
    let ratio = f32::from(pixel[0]) / f32::from(background[0]).max(1.0);
    if !(0.35..0.95).contains(&ratio) || background[0] < 40 {
        return Shade::No;
    }
    let chroma = |lab: [u8; 3]| [f32::from(lab[1]) - 128.0, f32::from(lab[2]) - 128.0];
    let (now, before) = (chroma(pixel), chroma(background));
    let error = (now[0] - ratio * before[0]).hypot(now[1] - ratio * before[1]);
    match error {
        error if error < 2.5 => Shade::Surely,
        error if error < 7.0 => Shade::Perhaps,
        _ => Shade::No,
    }
}

/// How two pictures compare within 7×7 pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Texture {
    /// Neither has any.
    Flat,
    /// They vary together (correlation above a half).
    Same,
    Other,
}

fn same_texture(first: &[u8], second: &[u8], (rows, cols): (i32, i32)) -> opencv::Result<Vec<Texture>> {
    let plane = |value: &dyn Fn(usize) -> f32| -> opencv::Result<Mat> {
        let values: Vec<f32> = (0..first.len()).map(value).collect();
        let raw = Mat::new_rows_cols_with_data(rows, cols, &values)?;
        let mut mean = Mat::default();
        let (kernel, anchor) = (opencv::core::Size::new(7, 7), opencv::core::Point::new(-1, -1));
        imgproc::blur(&raw, &mut mean, kernel, anchor, opencv::core::BORDER_REPLICATE)?;
        Ok(mean)
    };
    let (a, b) = (|i: usize| f32::from(first[i]), |i: usize| f32::from(second[i]));
    let means = [
        plane(&a)?,
        plane(&b)?,
        plane(&|i| a(i) * a(i))?,
        plane(&|i| b(i) * b(i))?,
        plane(&|i| a(i) * b(i))?,
    ];
    let [ma, mb, maa, mbb, mab] = [0, 1, 2, 3, 4].map(|i: usize| means[i].data_typed::<f32>());
    let (ma, mb, maa, mbb, mab) = (ma?, mb?, maa?, mbb?, mab?);
    let together = |i: usize| {
        let (va, vb) = (maa[i] - ma[i] * ma[i], mbb[i] - mb[i] * mb[i]);
        let covariance = mab[i] - ma[i] * mb[i];
        // Variances below two grey levels are noise.
        if va < 4.0 && vb < 4.0 {
            Texture::Flat
        } else if va >= 4.0 && vb >= 4.0 && covariance > 0.5 * (va * vb).sqrt() {
            Texture::Same
        } else {
            Texture::Other
        }
    };
    Ok((0..first.len()).map(together).collect())
}

/// What one run of frames adds.
struct Aligned {
    /// The background's motion from each frame to the one before.
    steps: Vec<Option<BackgroundMotion>>,
    keyframes: Vec<Keyframe>,
}

fn align_run(
    clip: &Clip<'_>,
    table: &[u8],
    run: std::ops::Range<usize>,
    stride: usize,
) -> Result<Aligned, SegmentError> {
    let read =
        |index: usize| WorkFrame::read(clip.frames, FrameIndex(index as u32), &clip.scale).map(|(f, _)| f);
    let mut before = run.start.checked_sub(1).map(read).transpose()?;
    let mut aligned = Aligned { steps: Vec::new(), keyframes: Vec::new() };
    for index in run {
        clip.watch.check()?;
        let frame = read(index)?;
        let hidden = binary::dilated(&clip.hidden(index, &frame, table)?, 4)?;
        let step = match &before {
            Some(before) => {
                let arms = binary::map2(&hidden, &hidden, |grade, _| u8::from(grade == HIDDEN))?;
                background_motion(&frame.grey, &before.grey, Some(&arms))?
            }
            None => None,
        };
        aligned.steps.push(step);
        if index % stride == 0 {
            aligned.keyframes.push(Keyframe { index, lab: frame.lab.try_clone()?, hidden });
        }
        before = Some(frame);
    }
    Ok(aligned)
}

/// The key frame as seen from the frame whose pixels `motion` takes to it; hidden where unseen.
fn warped(key: &Keyframe, motion: &BackgroundMotion) -> opencv::Result<(Mat, Mat)> {
    let size = key.lab.size()?;
    let matrix = motion.to_mat()?;
    let flags = imgproc::INTER_LINEAR | imgproc::WARP_INVERSE_MAP;
    let border = opencv::core::BORDER_CONSTANT;
    let mut lab = Mat::new_size_with_default(size, CV_8UC3, Scalar::all(0.0))?;
    imgproc::warp_perspective(&key.lab, &mut lab, &matrix, size, flags, border, Scalar::all(0.0))?;
    let mut hidden = Mat::default();
    let nearest = imgproc::INTER_NEAREST | imgproc::WARP_INVERSE_MAP;
    imgproc::warp_perspective(&key.hidden, &mut hidden, &matrix, size, nearest, border, Scalar::all(255.0))?;
    Ok((lab, hidden))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shadow_scales_lightness_and_chroma_and_skin_does_not_pass_for_it() {
        assert_eq!(is_shaded([120, 131, 140], [180, 133, 146]), Shade::Surely);
        assert_eq!(is_shaded([150, 148, 148], [200, 130, 135]), Shade::No);
        assert_eq!(is_shaded([190, 133, 146], [180, 133, 146]), Shade::No);
    }

    #[test]
    fn texture_that_shows_through_is_told_from_texture_that_does_not() {
        let stripes = |period: usize, scale: u8| -> Vec<u8> {
            (0..32 * 32)
                .map(|i| if ((i % 32) / period).is_multiple_of(2) { 100 / scale } else { 200 / scale })
                .collect()
        };
        let at_centre = |a: &[u8], b: &[u8]| same_texture(a, b, (32, 32)).unwrap()[16 * 32 + 16];
        assert_eq!(at_centre(&stripes(2, 1), &stripes(2, 2)), Texture::Same);
        assert_eq!(at_centre(&stripes(2, 1), &vec![90; 32 * 32]), Texture::Other);
        assert_eq!(at_centre(&vec![120; 32 * 32], &vec![90; 32 * 32]), Texture::Flat);
    }
}
