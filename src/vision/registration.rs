//! Registering one view of the background with another: homography, then what parallax leaves.

use std::sync::OnceLock;

use nalgebra::{Matrix3, Vector3};
use opencv::{
    core::{
        BORDER_CONSTANT, BORDER_REPLICATE, CV_32FC1, CV_32FC3, Mat, MatTrait, MatTraitConst,
        MatTraitConstManual, MatTraitManual, Point2f, Rect, Scalar, Size as CvSize, TermCriteria,
        TermCriteria_COUNT, TermCriteria_EPS, Vec3b, Vec3f, Vector,
    },
    imgproc, video,
};

use super::{BackgroundMotion, FlowQuality, WorkScale, dense_flow, fill_smoothly, motion_fit::fitted_motion};

/// A picture of the background with holes, at work scale.
#[derive(Debug)]
pub struct View {
    /// How the work picture maps to the full one.
    pub scale: WorkScale,
    /// CV_8UC3, RGB, work size.
    pub colour: Mat,
    /// CV_8UC1, work size.
    pub gray: Mat,
    /// CV_8UC1, work size: 255 where the background is really shown, 0 where an actor, an object
    /// or nothing is.
    pub valid: Mat,
    /// Corners of the background, found when first asked for.
    corners: OnceLock<Vec<Point2f>>,
}

impl View {
    /// A view of `picture` (CV_8UC3, RGB, full size), of which `blocked` (CV_8UC1, full size,
    /// non-zero inside) does not show the background.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn new(scale: WorkScale, picture: &Mat, blocked: &Mat) -> opencv::Result<Self> {
        let colour = scale.shrink(picture)?;
        let mut gray = Mat::default();
        imgproc::cvt_color_def(&colour, &mut gray, imgproc::COLOR_RGB2GRAY)?;
        let shrunk = scale.shrink(blocked)?;
        let mut valid = Mat::default();
        imgproc::threshold(&shrunk, &mut valid, 0.0, 255.0, imgproc::THRESH_BINARY_INV)?;
        Ok(Self { scale, colour, gray, valid, corners: OnceLock::new() })
    }

    /// Shi-Tomasi corners of the background, at most [`CORNERS`].
    fn corners(&self) -> opencv::Result<&[Point2f]> {
        if let Some(corners) = self.corners.get() {
            return Ok(corners);
        }
        let mut found = Vector::<Point2f>::new();
        let spacing = (f64::from(self.gray.cols()) / 64.0).max(4.0);
        imgproc::good_features_to_track(
            &self.gray,
            &mut found,
            4 * CORNERS,
            0.001,
            spacing,
            &self.valid,
            5,
            false,
            0.04,
        )?;
        let spread = spread_corners(&found, (self.gray.cols(), self.gray.rows()));
        Ok(self.corners.get_or_init(|| spread))
    }

    /// How this view's background moved into `shown` (CV_8UC1, work size): corners that lie inside
    /// `usable` there, tracked by pyramidal Lucas-Kanade, by the likeliest motion that they agree on.
    ///
    /// `None` with fewer than 12 agreeing corners or less than 20 % agreement.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn motion_into(&self, shown: &Mat, usable: Option<&Mat>) -> opencv::Result<Option<Matrix3<f64>>> {
        let mut from = Vector::<Point2f>::new();
        for corner in self.corners()? {
            let inside = match usable {
                Some(usable) => *usable.at_2d::<u8>(corner.y as i32, corner.x as i32)? != 0,
                None => true,
            };
            if inside {
                from.push(*corner);
            }
        }
        if from.len() < 12 {
            return Ok(None);
        }
        let (mut to, mut seen, mut errors) =
            (Vector::<Point2f>::new(), Vector::<u8>::new(), Vector::<f32>::new());
        let stop = TermCriteria::new(TermCriteria_COUNT + TermCriteria_EPS, 20, 0.02)?;
        let window = CvSize::new(15, 15);
        video::calc_optical_flow_pyr_lk(
            &self.gray,
            shown,
            &from,
            &mut to,
            &mut seen,
            &mut errors,
            window,
            3,
            stop,
            0,
            1e-4,
        )?;
        let (mut a, mut b) = (Vector::<Point2f>::new(), Vector::<Point2f>::new());
        for i in 0..from.len() {
            if seen.get(i)? != 0 && errors.get(i)? < 20.0 {
                a.push(from.get(i)?);
                b.push(to.get(i)?);
            }
        }
        fitted(&a, &b, (self.gray.cols(), self.gray.rows()))
    }
}

/// Share of the corners that must agree: weak ones often stray.
const AGREEING: f64 = 0.2;
/// Corners tracked a view, at most.
const CORNERS: i32 = 350;
/// Cells along each side of the picture from which corners are taken evenly.
const CORNER_CELLS: usize = 8;

/// The strongest corners of every part of the picture, from `found`, strongest first: a plain table must not be
/// outvoted by the one thing on it that is patterned.
fn spread_corners(found: &Vector<Point2f>, (cols, rows): (i32, i32)) -> Vec<Point2f> {
    let cell = |at: f32, length: i32| {
        (at / length.max(1) as f32 * CORNER_CELLS as f32).clamp(0.0, CORNER_CELLS as f32 - 1.0) as usize
    };
    let each = (CORNERS as usize).div_ceil(CORNER_CELLS * CORNER_CELLS);
    let mut taken = [0; CORNER_CELLS * CORNER_CELLS];
    let mut kept = Vec::new();
    for corner in found {
        let count = &mut taken[cell(corner.y, rows) * CORNER_CELLS + cell(corner.x, cols)];
        *count += 1;
        if *count <= each {
            kept.push(corner);
        }
    }
    kept
}

/// The likeliest motion, if points agree on it within 1.5 px.
fn fitted(
    from: &Vector<Point2f>,
    to: &Vector<Point2f>,
    size: (i32, i32),
) -> opencv::Result<Option<Matrix3<f64>>> {
    if from.len() < 12 {
        return Ok(None);
    }
    let found = fitted_motion(from, to, size, 1.5)?;
    let agreed = found.filter(|f| f.inliers >= 12 && f.inliers as f64 >= AGREEING * from.len() as f64);
    Ok(agreed.map(|found| found.homography))
}

/// Where each pixel of a target view lies in a source view.
#[derive(Clone, Debug)]
pub struct Warp {
    target: WorkScale,
    /// Full-size target pixels to full-size source pixels.
    homography: Matrix3<f64>,
    /// What parallax leaves: a displacement in target full-size pixels, before the homography.
    residual: Option<Residual>,
}

#[derive(Clone, Debug)]
struct Residual {
    width: usize,
    height: usize,
    vectors: Vec<[f32; 2]>,
}

/// How views are registered.
#[derive(Clone, Copy, Debug)]
pub struct Registration {
    /// Follow parallax with a dense residual flow, completed smoothly where either view is blocked.
    pub parallax: bool,
}

impl Registration {
    /// Registers `source` with `target`, starting from `guess`, which takes work pixels of `target`
    /// to work pixels of `source`. A camera that stands still keeps `still`, the full-size
    /// homography that is exact then, if one is given.
    ///
    /// `None` when the views do not agree.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn register(
        &self,
        target: &View,
        source: &View,
        guess: &Matrix3<f64>,
        still: Option<&Matrix3<f64>>,
    ) -> opencv::Result<Option<Warp>> {
        let shown = warp_work(&source.gray, guess, target, imgproc::INTER_LINEAR)?;
        let usable = both_valid(target, source, guess)?;
        let Some(motion) = target.motion_into(&shown, Some(&usable))? else {
            return Ok(None);
        };
        let work = guess * motion;
        let homography = to_full_size(&work, target.scale, source.scale);
        if let Some(still) = still
            && farthest_corner(&homography, still, target.scale) < STILL
        {
            return Ok(Some(Warp { target: target.scale, homography: *still, residual: None }));
        }
        let residual = if self.parallax { residual_flow(target, source, &work)? } else { None };
        Ok(Some(Warp { target: target.scale, homography, residual }))
    }
}

/// Work pixels by which the corners may miss the still map of a camera that does not move.
const STILL: f64 = 0.3;

/// How far apart two full-size maps take the target's corners, in work pixels.
fn farthest_corner(a: &Matrix3<f64>, b: &Matrix3<f64>, scale: WorkScale) -> f64 {
    let (right, bottom) = (f64::from(scale.full.width) - 1.0, f64::from(scale.full.height) - 1.0);
    let corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)];
    let distance = |(x, y): (f64, f64)| {
        let (p, q) = (a * Vector3::new(x, y, 1.0), b * Vector3::new(x, y, 1.0));
        (p.x / p.z - q.x / q.z).hypot(p.y / p.z - q.y / q.z)
    };
    scale.factors().0 * corners.into_iter().map(distance).fold(0.0, f64::max)
}

/// A homography between work pictures as one between full-size pictures.
pub fn to_full_size(work: &Matrix3<f64>, target: WorkScale, source: WorkScale) -> Matrix3<f64> {
    let shrink = |scale: WorkScale| {
        let (sx, sy) = scale.factors();
        Matrix3::new(sx, 0.0, 0.5 * sx - 0.5, 0.0, sy, 0.5 * sy - 0.5, 0.0, 0.0, 1.0)
    };
    let (sx, sy) = source.factors();
    let enlarge = Matrix3::new(1.0 / sx, 0.0, 0.5 / sx - 0.5, 0.0, 1.0 / sy, 0.5 / sy - 0.5, 0.0, 0.0, 1.0);
    enlarge * work * shrink(target)
}

/// Draws a work picture of the source on the target's work grid.
fn warp_work(source: &Mat, map: &Matrix3<f64>, target: &View, interpolation: i32) -> opencv::Result<Mat> {
    let motion = BackgroundMotion::known(*map);
    let mut out = Mat::default();
    let size = CvSize::new(target.gray.cols(), target.gray.rows());
    let flags = interpolation | imgproc::WARP_INVERSE_MAP;
    imgproc::warp_perspective(
        source,
        &mut out,
        &motion.to_mat()?,
        size,
        flags,
        BORDER_CONSTANT,
        Scalar::all(0.0),
    )?;
    Ok(out)
}

/// 255 where both views show the background and the source covers the target.
fn both_valid(target: &View, source: &View, map: &Matrix3<f64>) -> opencv::Result<Mat> {
    let warped = warp_work(&source.valid, map, target, imgproc::INTER_LINEAR)?;
    let (mut certain, mut both) = (Mat::default(), Mat::default());
    imgproc::threshold(&warped, &mut certain, 250.0, 255.0, imgproc::THRESH_BINARY)?;
    opencv::core::bitwise_and_def(&certain, &target.valid, &mut both)?;
    Ok(both)
}

/// Dense flow that the homography leaves, at half work size, completed where a view is blocked.
fn residual_flow(target: &View, source: &View, map: &Matrix3<f64>) -> opencv::Result<Option<Residual>> {
    let half = WorkScale::fit(target.scale.work, target.scale.work.width.max(target.scale.work.height) / 2);
    let usable = both_valid(target, source, map)?;
    let shown = warp_work(&source.gray, map, target, imgproc::INTER_LINEAR)?;
    // What is blocked is made equal in both, so that the flow estimator sees no motion there.
    let mut filled = target.gray.try_clone()?;
    shown.copy_to_masked(&mut filled, &usable)?;
    let (first, second) = (half.shrink(&target.gray)?, half.shrink(&filled)?);
    let flow = dense_flow(&first, &second, FlowQuality::Fast)?;
    let pulled = flow.pull(&second)?;
    let usable = half.shrink(&usable)?;
    let (width, height) = (first.cols() as usize, first.rows() as usize);
    let (a, b, u) = (first.data_typed::<u8>()?, pulled.data_typed::<u8>()?, usable.data_typed::<u8>()?);
    let mut vectors = flow.vectors().to_vec();
    let mut weights = vec![0.0_f32; width * height];
    let (mut sum, mut count) = (0.0_f64, 0_usize);
    for (i, weight) in weights.iter_mut().enumerate() {
        let length = vectors[i][0].hypot(vectors[i][1]);
        if u[i] == 255 && a[i].abs_diff(b[i]) < 20 && length < 0.05 * width as f32 {
            *weight = 1.0;
            sum += f64::from(length);
            count += 1;
        }
    }
    if count == 0 || sum / (count as f64) < 0.03 {
        return Ok(None);
    }
    fill_smoothly(&mut vectors, &weights, width, height);
    let (gx, gy) = (
        f64::from(target.scale.full.width) / width as f64,
        f64::from(target.scale.full.height) / height as f64,
    );
    for vector in &mut vectors {
        *vector = [(f64::from(vector[0]) * gx) as f32, (f64::from(vector[1]) * gy) as f32];
    }
    Ok(Some(Residual { width, height, vectors }))
}

impl Warp {
    /// Follows `work`, which takes work pixels of the target to work pixels of the source, without looking at
    /// the pictures.
    pub fn along(work: &Matrix3<f64>, target: WorkScale, source: WorkScale) -> Self {
        Self { target, homography: to_full_size(work, target, source), residual: None }
    }

    /// Draws the part `region` of the full-size target from `source` (full size, any type) with
    /// an OpenCV interpolation; `outside` is what lies beyond the source, `None` repeats its border.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn draw(
        &self,
        source: &Mat,
        region: Rect,
        interpolation: i32,
        outside: Option<Scalar>,
    ) -> opencv::Result<Mat> {
        let maps = self.residual.as_ref().map(|residual| self.maps(residual, region)).transpose()?;
        self.draw_by(maps.as_ref(), source, region, interpolation, outside)
    }

    /// [`Self::draw`] of a picture with its border repeated, by bicubic interpolation, and of a `mask` of the
    /// same size with an interpolation and value `outside` of its own: cheaper than one after the other.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn draw_with_mask(
        &self,
        picture: &Mat,
        mask: &Mat,
        region: Rect,
        interpolation: i32,
        outside: f64,
    ) -> opencv::Result<(Mat, Mat)> {
        let maps = self.residual.as_ref().map(|residual| self.maps(residual, region)).transpose()?;
        let picture = self.draw_by(maps.as_ref(), picture, region, imgproc::INTER_CUBIC, None)?;
        let outside = Some(Scalar::all(outside));
        Ok((picture, self.draw_by(maps.as_ref(), mask, region, interpolation, outside)?))
    }

    fn draw_by(
        &self,
        maps: Option<&(Mat, Mat)>,
        source: &Mat,
        region: Rect,
        interpolation: i32,
        outside: Option<Scalar>,
    ) -> opencv::Result<Mat> {
        let mut out = Mat::default();
        let border = if outside.is_some() { BORDER_CONSTANT } else { BORDER_REPLICATE };
        let value = outside.unwrap_or_default();
        if let Some((xs, ys)) = maps {
            imgproc::remap(source, &mut out, xs, ys, interpolation, border, value)?;
            return Ok(out);
        }
        let offset =
            Matrix3::new(1.0, 0.0, f64::from(region.x), 0.0, 1.0, f64::from(region.y), 0.0, 0.0, 1.0);
        let motion = BackgroundMotion::known(self.homography * offset);
        let flags = interpolation | imgproc::WARP_INVERSE_MAP;
        let size = CvSize::new(region.width, region.height);
        imgproc::warp_perspective(source, &mut out, &motion.to_mat()?, size, flags, border, value)?;
        Ok(out)
    }

    fn maps(&self, residual: &Residual, region: Rect) -> opencv::Result<(Mat, Mat)> {
        let zero = Scalar::all(0.0);
        let mut xs = Mat::new_rows_cols_with_default(region.height, region.width, CV_32FC1, zero)?;
        let mut ys = xs.try_clone()?;
        let full = self.target.full;
        let step = (residual.width as f32 / full.width as f32, residual.height as f32 / full.height as f32);
        {
            let (xs, ys) = (xs.data_typed_mut::<f32>()?, ys.data_typed_mut::<f32>()?);
            let width = region.width as usize;
            let h = self.homography.map(|value| value as f32);
            let last = residual.width - 1;
            let columns: Vec<(usize, f32)> = (0..width)
                .map(|column| {
                    let x = ((region.x + column as i32) as f32 + 0.5) * step.0 - 0.5;
                    let x = x.clamp(0.0, last as f32);
                    let left = (x as usize).min(last.saturating_sub(1));
                    (left, x - left as f32)
                })
                .collect();
            for (row, (xs, ys)) in xs.chunks_exact_mut(width).zip(ys.chunks_exact_mut(width)).enumerate() {
                let y = (region.y + row as i32) as f32;
                let vectors = residual.row((y + 0.5) * step.1 - 0.5);
                let mut x = region.x as f32;
                for ((left, share), (x_out, y_out)) in columns.iter().zip(xs.iter_mut().zip(ys)) {
                    let (a, b) = (vectors[*left], vectors[(left + 1).min(last)]);
                    let (u, v) = (x + a[0] + (b[0] - a[0]) * share, y + a[1] + (b[1] - a[1]) * share);
                    x += 1.0;
                    let scale = 1.0 / (h[(2, 0)] * u + h[(2, 1)] * v + h[(2, 2)]);
                    *x_out = (h[(0, 0)] * u + h[(0, 1)] * v + h[(0, 2)]) * scale;
                    *y_out = (h[(1, 0)] * u + h[(1, 1)] * v + h[(1, 2)]) * scale;
                }
            }
        }
        Ok((xs, ys))
    }

    /// [`Self::draw`] of the source's colours on the target's whole work grid, and 255 where the
    /// source really shows the background.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn draw_work(&self, source: &View) -> opencv::Result<(Mat, Mat)> {
        let warp = self.at_work(source.scale);
        let region = warp.target.whole();
        let colour = warp.draw(&source.colour, region, imgproc::INTER_LINEAR, None)?;
        Ok((colour, self.draw_work_mask(&source.valid, source.scale)?))
    }

    /// 255 on the target's work grid where `mask`, on the work grid of a source of `scale`, surely is.
    ///
    /// # Errors
    /// When OpenCV fails.
    pub fn draw_work_mask(&self, mask: &Mat, scale: WorkScale) -> opencv::Result<Mat> {
        let warp = self.at_work(scale);
        let shown = warp.draw(mask, warp.target.whole(), imgproc::INTER_LINEAR, Some(Scalar::all(0.0)))?;
        let mut inside = Mat::default();
        imgproc::threshold(&shown, &mut inside, 250.0, 255.0, imgproc::THRESH_BINARY)?;
        Ok(inside)
    }

    /// This warp between the work pictures, which then play the full-size ones.
    fn at_work(&self, source: WorkScale) -> Self {
        let full = self.target;
        // At work scale the view itself plays the full-size picture.
        let work = WorkScale { full: full.work, work: full.work };
        let homography = to_work_size(&self.homography, full, source);
        let residual = self.residual.as_ref().map(|residual| {
            let (sx, sy) = full.factors();
            let vectors = residual.vectors.iter();
            let vectors = vectors.map(|v| [v[0] * sx as f32, v[1] * sy as f32]).collect();
            Residual { vectors, ..*residual }
        });
        Self { target: work, homography, residual }
    }
}

fn to_work_size(full: &Matrix3<f64>, target: WorkScale, source: WorkScale) -> Matrix3<f64> {
    // The inverse scaling of each side: swap full and work.
    let swap = |scale: WorkScale| WorkScale { full: scale.work, work: scale.full };
    to_full_size(full, swap(target), swap(source))
}

impl Residual {
    /// The vectors along row `y` of the residual's own grid, between two of its rows.
    fn row(&self, y: f32) -> Vec<[f32; 2]> {
        let y = y.clamp(0.0, (self.height - 1) as f32);
        let above = y as usize;
        let below = (above + 1).min(self.height - 1);
        let share = y - above as f32;
        let row = |y: usize| &self.vectors[y * self.width..(y + 1) * self.width];
        let pairs = row(above).iter().zip(row(below));
        pairs.map(|(a, b)| [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share]).collect()
    }
}

/// What to add to `source` (CV_8UC3) so that its colours meet `target`'s (CV_8UC3), given where both are
/// valid (CV_8UC1, 255): measured in cells of `cell` pixels, completed smoothly, at cell resolution
/// (CV_32FC3). Differences that leave the median by more than `limit` levels count as shadow or misregistration
/// and are ignored.
///
/// # Errors
/// When OpenCV fails.
pub fn colour_offset(target: &Mat, source: &Mat, valid: &Mat, cell: i32, limit: f32) -> opencv::Result<Mat> {
    let size = CvSize::new((target.cols() / cell).max(1), (target.rows() / cell).max(1));
    let (mut a, mut b, mut difference) = (Mat::default(), Mat::default(), Mat::default());
    target.convert_to(&mut a, CV_32FC3, 1.0, 0.0)?;
    source.convert_to(&mut b, CV_32FC3, 1.0, 0.0)?;
    opencv::core::subtract_def(&a, &b, &mut difference)?;
    let mut invalid = Mat::default();
    opencv::core::bitwise_not_def(valid, &mut invalid)?;
    difference.set_to(&Scalar::all(0.0), &invalid)?;
    let (mut means, mut shares) = (Mat::default(), Mat::default());
    imgproc::resize(&difference, &mut means, size, 0.0, 0.0, imgproc::INTER_AREA)?;
    imgproc::resize(valid, &mut shares, size, 0.0, 0.0, imgproc::INTER_AREA)?;
    let (means, shares) = (means.data_typed::<Vec3f>()?, shares.data_typed::<u8>()?);
    let mut values = vec![[0.0_f32; 3]; means.len()];
    let mut weights = vec![0.0_f32; means.len()];
    for (i, (mean, share)) in means.iter().zip(shares).enumerate() {
        if *share >= 64 {
            let whole = 255.0 / f32::from(*share);
            values[i] = [mean[0] * whole, mean[1] * whole, mean[2] * whole];
            weights[i] = f32::from(*share) / 255.0;
        }
    }
    let typical = medians(&values, &weights);
    for (value, weight) in values.iter().zip(&mut weights) {
        if value.iter().zip(typical).any(|(v, typical)| (v - typical).abs() > limit) {
            *weight = 0.0;
        }
    }
    fill_smoothly(&mut values, &weights, size.width as usize, size.height as usize);
    let mut offset = Mat::new_rows_cols_with_default(size.height, size.width, CV_32FC3, Scalar::all(0.0))?;
    for (to, value) in offset.data_typed_mut::<Vec3f>()?.iter_mut().zip(&values) {
        *to = Vec3f::from(*value);
    }
    let mut smooth = Mat::default();
    imgproc::gaussian_blur(&offset, &mut smooth, CvSize::new(5, 5), 1.0, 1.0, BORDER_REPLICATE)?;
    Ok(smooth)
}

/// The median of each channel over values with any weight; zeros without one.
fn medians(values: &[[f32; 3]], weights: &[f32]) -> [f32; 3] {
    std::array::from_fn(|channel| {
        let known = values.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
        let mut known: Vec<f32> = known.map(|(value, _)| value[channel]).collect();
        known.sort_by(f32::total_cmp);
        known.get(known.len() / 2).copied().unwrap_or(0.0)
    })
}

/// Where the scene itself changed between two registered work pictures (CV_8UC3, colours already alike):
/// per cell of `cell` pixels the share of change other than of brightness, 0 to 1, measured where both are valid and carried
/// smoothly into the rest (CV_32FC1). Cell means that differ by more than `limit` levels count as change.
///
/// # Errors
/// When OpenCV fails.
pub fn scene_change(target: &Mat, source: &Mat, valid: &Mat, cell: i32, limit: f32) -> opencv::Result<Mat> {
    let size = CvSize::new((target.cols() / cell).max(1), (target.rows() / cell).max(1));
    let mut invalid = Mat::default();
    opencv::core::bitwise_not_def(valid, &mut invalid)?;
    let means = |picture: &Mat| -> opencv::Result<Mat> {
        let (mut kept, mut coarse) = (picture.try_clone()?, Mat::default());
        kept.set_to(&Scalar::all(0.0), &invalid)?;
        imgproc::resize(&kept, &mut coarse, size, 0.0, 0.0, imgproc::INTER_AREA)?;
        Ok(coarse)
    };
    let (a, b) = (means(target)?, means(source)?);
    let mut shares = Mat::default();
    imgproc::resize(valid, &mut shares, size, 0.0, 0.0, imgproc::INTER_AREA)?;
    let (a, b, shares) = (a.data_typed::<Vec3b>()?, b.data_typed::<Vec3b>()?, shares.data_typed::<u8>()?);
    let mut values = vec![[0.0_f32; 1]; shares.len()];
    let mut weights = vec![0.0_f32; shares.len()];
    for (i, share) in shares.iter().enumerate().filter(|(_, share)| **share >= 128) {
        let whole = 255.0 / f32::from(*share);
        let (a, b) = (a[i].0.map(f32::from), b[i].0.map(f32::from));
        // A shadow scales all channels alike: only what no plausible scale explains is change.
        let scale = (a.iter().sum::<f32>() / b.iter().sum::<f32>().max(1.0)).clamp(0.4, 2.5);
        let differs = (0..3).any(|c| (a[c] - scale * b[c]).abs() * whole > limit * scale.max(1.0));
        values[i] = [if differs { 1.0 } else { 0.0 }];
        weights[i] = f32::from(*share) / 255.0;
    }
    fill_smoothly(&mut values, &weights, size.width as usize, size.height as usize);
    let mut change = Mat::new_rows_cols_with_default(size.height, size.width, CV_32FC1, Scalar::all(0.0))?;
    for (to, value) in change.data_typed_mut::<f32>()?.iter_mut().zip(&values) {
        *to = value[0];
    }
    Ok(change)
}

/// The part `region` of a full-size picture of size `full`, enlarged from a coarse map of the whole of it.
///
/// # Errors
/// When OpenCV fails.
pub fn enlarged_part(coarse: &Mat, full: crate::geometry::Size, region: Rect) -> opencv::Result<Mat> {
    let (sx, sy) =
        (f64::from(coarse.cols()) / f64::from(full.width), f64::from(coarse.rows()) / f64::from(full.height));
    let place = |at: i32, s: f64| (f64::from(at) + 0.5) * s - 0.5;
    let map = Mat::from_slice_2d(&[[sx, 0.0, place(region.x, sx)], [0.0, sy, place(region.y, sy)]])?;
    let mut part = Mat::default();
    let size = CvSize::new(region.width, region.height);
    let flags = imgproc::INTER_LINEAR | imgproc::WARP_INVERSE_MAP;
    imgproc::warp_affine(coarse, &mut part, &map, size, flags, BORDER_REPLICATE, Scalar::default())?;
    Ok(part)
}
