//! The background's motion between two frames, as a homography.

use nalgebra::Matrix3;
use opencv::{
    calib3d,
    core::{
        Mat, MatTraitConst, Point2f, Scalar, Size as CvSize, TermCriteria, TermCriteria_COUNT,
        TermCriteria_EPS, Vector, no_array,
    },
    imgproc, video,
};

use crate::geometry::Pixel;

/// How the background moved from one frame to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackgroundMotion {
    /// Takes pixels of the first frame to the second.
    pub homography: Matrix3<f64>,
    /// Share of the tracked features that agree within 2 px.
    pub inlier_share: f64,
    /// How many agree.
    pub inliers: usize,
}

impl BackgroundMotion {
    /// Nothing moved.
    pub fn still() -> Self {
        Self::known(Matrix3::identity())
    }

    /// A motion that is known, not measured from features.
    pub fn known(homography: Matrix3<f64>) -> Self {
        Self { homography, inlier_share: 1.0, inliers: 0 }
    }

    /// Where `p` of the first frame lies in the second.
    pub fn apply(&self, p: Pixel) -> Pixel {
        let q = self.homography * nalgebra::Vector3::new(p.x, p.y, 1.0);
        let w = if q.z.abs() < 1e-12 { 1e-12 } else { q.z };
        Pixel::new(q.x / w, q.y / w)
    }

    /// The homography as a CV_64FC1 matrix.
    ///
    /// # Errors
    /// When OpenCV cannot allocate.
    pub fn to_mat(&self) -> opencv::Result<Mat> {
        let h = &self.homography;
        let rows = [0, 1, 2].map(|r| [h[(r, 0)], h[(r, 1)], h[(r, 2)]]);
        Mat::from_slice_2d(&rows)
    }
}

/// Features in pixels; pairs (first, second).
type Pairs = (Vector<Point2f>, Vector<Point2f>);

/// Features that [`background_motion`] looks for at most.
const MOST_FEATURES: i32 = 600;

/// The homography of the background from `first` to `second` (CV_8UC1, one size): Shi-Tomasi
/// features outside `exclude` (CV_8UC1, non-zero where actors or objects are in `first`), tracked
/// by pyramidal Lucas-Kanade there and back, fitted by seeded RANSAC at 2 px.
///
/// `None` with fewer than 12 agreeing features or less than 30 % agreement: textureless or blurred.
///
/// # Errors
/// When the pictures do not match or OpenCV fails.
pub fn background_motion(
    first: &Mat,
    second: &Mat,
    exclude: Option<&Mat>,
) -> opencv::Result<Option<BackgroundMotion>> {
    background_motion_from(first, second, exclude, MOST_FEATURES)
}

/// As [`background_motion`], from `most` features: fewer are faster.
///
/// # Errors
/// When the pictures do not match or OpenCV fails.
pub fn background_motion_from(
    first: &Mat,
    second: &Mat,
    exclude: Option<&Mat>,
    most: i32,
) -> opencv::Result<Option<BackgroundMotion>> {
    let (from, to) = tracked_features(first, second, exclude, most)?;
    if from.len() < 12 {
        return Ok(None);
    }
    let mut inlier_mask = Mat::default();
    opencv::core::set_rng_seed(1)?;
    let fitted = calib3d::find_homography(&from, &to, &mut inlier_mask, calib3d::RANSAC, 2.0)?;
    if fitted.empty() {
        return Ok(None);
    }
    let inliers = opencv::core::count_non_zero(&inlier_mask)? as usize;
    let inlier_share = inliers as f64 / from.len() as f64;
    if inliers < 12 || inlier_share < 0.3 {
        return Ok(None);
    }
    let mut homography = Matrix3::zeros();
    for row in 0..3 {
        for col in 0..3 {
            homography[(row as usize, col as usize)] = *fitted.at_2d::<f64>(row, col)?;
        }
    }
    let finite = homography.iter().all(|v| v.is_finite()) && homography.determinant().abs() > 1e-9;
    Ok(finite.then_some(BackgroundMotion { homography, inlier_share, inliers }))
}

fn tracked_features(first: &Mat, second: &Mat, exclude: Option<&Mat>, most: i32) -> opencv::Result<Pairs> {
    let mut allowed = Mat::default();
    if let Some(exclude) = exclude {
        opencv::core::compare(exclude, &Scalar::all(0.0), &mut allowed, opencv::core::CMP_EQ)?;
    }
    let mut corners = Vector::<Point2f>::new();
    let spacing = (f64::from(first.cols()) / 64.0).max(4.0);
    imgproc::good_features_to_track(first, &mut corners, most, 0.005, spacing, &allowed, 5, false, 0.04)?;
    if corners.is_empty() {
        return Ok((Vector::new(), Vector::new()));
    }
    let (there, seen_there) = lucas_kanade(first, second, &corners)?;
    let (back, seen_back) = lucas_kanade(second, first, &there)?;
    let mut pairs: Pairs = (Vector::new(), Vector::new());
    for index in 0..corners.len() {
        let (start, end, again) = (corners.get(index)?, there.get(index)?, back.get(index)?);
        let error = (start.x - again.x).hypot(start.y - again.y);
        if seen_there.get(index)? != 0 && seen_back.get(index)? != 0 && error < 1.0 {
            pairs.0.push(start);
            pairs.1.push(end);
        }
    }
    Ok(pairs)
}

fn lucas_kanade(
    first: &Mat,
    second: &Mat,
    points: &Vector<Point2f>,
) -> opencv::Result<(Vector<Point2f>, Vector<u8>)> {
    let mut moved = Vector::<Point2f>::new();
    let mut seen = Vector::<u8>::new();
    let stop = TermCriteria::new(TermCriteria_COUNT + TermCriteria_EPS, 20, 0.03)?;
    let window = CvSize::new(15, 15);
    let mut errors = no_array();
    video::calc_optical_flow_pyr_lk(
        first,
        second,
        points,
        &mut moved,
        &mut seen,
        &mut errors,
        window,
        3,
        stop,
        0,
        1e-4,
    )?;
    Ok((moved, seen))
}
