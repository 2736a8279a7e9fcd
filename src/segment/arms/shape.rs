//! A hand's landmarks as regions on the work picture.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Point, Scalar, Vector},
    imgproc,
};

use crate::{
    geometry::Pixel,
    landmarks::{HandLandmarks, KEYPOINT_COUNT, keypoint},
    vision::{WorkScale, binary},
};

/// A hand on the work picture.
#[derive(Clone, Debug)]
pub(super) struct HandShape {
    points: [Pixel; KEYPOINT_COUNT],
    /// Index base to pinky base, but never less than the palm's length suggests, pixels.
    pub palm_width: f64,
    /// Wrist to the farthest fingertip, pixels.
    pub length: f64,
    /// Unit vector from the finger bases to the wrist: where the forearm lies.
    pub towards_arm: Pixel,
}

/// How far from straight below a forearm comes up to a hand bent at the wrist, degrees.
pub(super) const FROM_BELOW: f64 = 60.0;

const WHITE: Scalar = Scalar::new(255.0, 0.0, 0.0, 0.0);

impl HandShape {
    /// `None` when the landmarks are not finite or too small to mean anything.
    pub fn new(landmarks: &HandLandmarks, scale: &WorkScale) -> Option<Self> {
        let points = landmarks.keypoints.map(|p| scale.to_work(p));
        let limit = 4.0 * scale.work.diagonal();
        if points.iter().any(|p| !(p.x.abs() < limit && p.y.abs() < limit)) {
            return None;
        }
        let wrist = points[keypoint::WRIST];
        let bases = &keypoint::BASES[1..];
        let count = bases.len() as f64;
        let centre = Pixel::new(
            bases.iter().map(|i| points[*i].x).sum::<f64>() / count,
            bases.iter().map(|i| points[*i].y).sum::<f64>() / count,
        );
        let palm_length = wrist.distance(centre);
        let palm_width = points[5].distance(points[17]).max(0.6 * palm_length);
        let length = keypoint::TIPS.iter().map(|i| wrist.distance(points[*i])).fold(palm_length, f64::max);
        if palm_width < 3.0 || palm_length < 1.0 {
            return None;
        }
        let towards_arm = Pixel::new((wrist.x - centre.x) / palm_length, (wrist.y - centre.y) / palm_length);
        Some(Self { points, palm_width, length, towards_arm })
    }

    /// The wrist.
    pub fn wrist(&self) -> Pixel {
        self.points[keypoint::WRIST]
    }

    fn rounded(&self, index: usize) -> Point {
        Point::new(self.points[index].x.round() as i32, self.points[index].y.round() as i32)
    }

    /// Draws what certainly is hand: the palm and the bones, `thickness` palm widths thick.
    pub fn draw_core(&self, mask: &mut Mat, thickness: f64) -> opencv::Result<()> {
        let palm: Vector<Point> = [0, 1, 5, 9, 13, 17].into_iter().map(|i| self.rounded(i)).collect();
        let mut hull = Vector::<Point>::new();
        imgproc::convex_hull(&palm, &mut hull, false, true)?;
        imgproc::fill_convex_poly(mask, &hull, WHITE, imgproc::LINE_8, 0)?;
        let thickness = (thickness * self.palm_width).round().max(1.0) as i32;
        for (child, parent) in keypoint::PARENT.iter().enumerate().skip(1) {
            let (from, to) = (self.rounded(*parent), self.rounded(child));
            imgproc::line(mask, from, to, WHITE, thickness, imgproc::LINE_8, 0)?;
        }
        Ok(())
    }

    /// Draws the hull of all keypoints, grown by `margin` palm widths: where the hand may be.
    pub fn draw_hull(&self, mask: &mut Mat, margin: f64) -> opencv::Result<()> {
        let all: Vector<Point> = (0..KEYPOINT_COUNT).map(|i| self.rounded(i)).collect();
        let mut hull = Vector::<Point>::new();
        imgproc::convex_hull(&all, &mut hull, false, true)?;
        let mut outline = Vector::<Vector<Point>>::new();
        outline.push(hull.clone());
        imgproc::fill_convex_poly(mask, &hull, WHITE, imgproc::LINE_8, 0)?;
        let thickness = (2.0 * margin * self.palm_width).round().max(1.0) as i32;
        imgproc::polylines(mask, &outline, true, WHITE, thickness, imgproc::LINE_8, 0)
    }

    /// Draws where the forearm may be: within `half_angle` (below 90) degrees of its direction as seen from
    /// the wrist, at most `reach` pixels away.
    pub fn draw_cone(&self, mask: &mut Mat, half_angle: f64, reach: f64) -> opencv::Result<()> {
        self.draw_cone_towards(self.towards_arm, mask, half_angle, reach)
    }

    /// Draws where a first-person forearm may be when the hand is bent at the wrist, whatever way the palm points:
    /// it comes from below.
    pub fn draw_below(&self, mask: &mut Mat, half_angle: f64, reach: f64) -> opencv::Result<()> {
        self.draw_cone_towards(Pixel::new(0.0, 1.0), mask, half_angle, reach)
    }

    fn draw_cone_towards(
        &self,
        towards: Pixel,
        mask: &mut Mat,
        half_angle: f64,
        reach: f64,
    ) -> opencv::Result<()> {
        let cols = mask.cols() as usize;
        let wrist = self.wrist();
        // The apex lies within the palm, so that the cone's mouth is as wide as the wrist.
        let apex = Pixel::new(
            wrist.x - 0.3 * self.palm_width * towards.x,
            wrist.y - 0.3 * self.palm_width * towards.y,
        );
        let cosine = half_angle.to_radians().cos();
        let (farthest, widest) = ((reach * reach) as f32, (cosine * cosine) as f32);
        let (toward_x, toward_y) = (towards.x as f32, towards.y as f32);
        for (y, row) in mask.data_bytes_mut()?.chunks_exact_mut(cols).enumerate() {
            let dy = y as f32 - apex.y as f32;
            for (x, value) in row.iter_mut().enumerate() {
                let dx = x as f32 - apex.x as f32;
                let squared = dx * dx + dy * dy;
                let along = dx * toward_x + dy * toward_y;
                let inside = squared <= farthest && along >= 0.0 && along * along >= widest * squared;
                *value |= if inside { 255 } else { 0 };
            }
        }
        Ok(())
    }

    /// Pixels from the wrist to the picture's border along the forearm; zero when the wrist lies outside.
    pub fn distance_to_border(&self, width: f64, height: f64) -> f64 {
        let (wrist, d) = (self.wrist(), self.towards_arm);
        let along = |position: f64, direction: f64, length: f64| {
            if direction.abs() < 1e-6 {
                return f64::INFINITY;
            }
            let edge = if direction > 0.0 { length } else { 0.0 };
            ((edge - position) / direction).max(0.0)
        };
        along(wrist.x, d.x, width).min(along(wrist.y, d.y, height))
    }

    /// Whether `other` is the same hand found twice.
    pub fn is_same_as(&self, other: &Self) -> bool {
        let pairs = self.points.iter().zip(&other.points);
        let mean = pairs.map(|(a, b)| a.distance(*b)).sum::<f64>() / KEYPOINT_COUNT as f64;
        mean < 0.6 * self.palm_width.min(other.palm_width)
    }

    /// Share of the core that `mask` covers.
    pub fn core_covered(&self, mask: &Mat) -> opencv::Result<f64> {
        let mut core = binary::empty(mask.rows(), mask.cols())?;
        self.draw_core(&mut core, 0.2)?;
        let (mut inside, mut all) = (0_usize, 0_usize);
        for (core, mask) in core.data_bytes()?.iter().zip(mask.data_bytes()?) {
            all += usize::from(*core != 0);
            inside += usize::from(*core != 0 && *mask != 0);
        }
        Ok(if all == 0 { 0.0 } else { inside as f64 / all as f64 })
    }

    /// Distance of every pixel to the hand's bones and the line of its forearm, CV_32FC1.
    pub fn distances(&self, like: &Mat) -> opencv::Result<Mat> {
        let mut drawn = binary::empty(like.rows(), like.cols())?;
        self.draw_core(&mut drawn, 0.1)?;
        let reach = 3.0 * self.length;
        let wrist = self.wrist();
        let elbow = Pixel::new(wrist.x + reach * self.towards_arm.x, wrist.y + reach * self.towards_arm.y);
        let end = Point::new(elbow.x.round() as i32, elbow.y.round() as i32);
        imgproc::line(&mut drawn, self.rounded(keypoint::WRIST), end, WHITE, 1, imgproc::LINE_8, 0)?;
        let inverse = binary::map2(&drawn, &drawn, |value, _| 255 - value)?;
        let mut distances = Mat::default();
        imgproc::distance_transform(&inverse, &mut distances, imgproc::DIST_L2, 3, opencv::core::CV_32F)?;
        Ok(distances)
    }
}

/// The pixels of `mask` where `mine` is not larger than `other` (CV_32FC1 distances).
pub(super) fn nearer(mask: &Mat, mine: &Mat, other: &Mat) -> opencv::Result<Mat> {
    let mut out = mask.try_clone()?;
    let distances = mine.data_typed::<f32>()?.iter().zip(other.data_typed::<f32>()?);
    for (value, (mine, other)) in out.data_bytes_mut()?.iter_mut().zip(distances) {
        if mine > other {
            *value = 0;
        }
    }
    Ok(out)
}
