//! Placements as numbers that can be averaged: centre, size, turn and a little shear.

use nalgebra::{Matrix2, Matrix3, Vector4};

/// An affine placement of a template about its own centre.
///
/// The linear part is `e^size · R(turn) · S` with `S` symmetric, of determinant one, given by
/// `aspect` and `shear` (a polar decomposition).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    /// Where the template's centre lies, pixels.
    pub centre: (f64, f64),
    /// Natural logarithm of the scale.
    pub size: f64,
    /// Angle, rad.
    pub turn: f64,
    pub aspect: f64,
    pub shear: f64,
}

impl Pose {
    /// Reads an affine `transform` of a template whose centre is `centre`.
    pub fn of(transform: &Matrix3<f64>, centre: (f64, f64)) -> Self {
        let linear = transform.fixed_view::<2, 2>(0, 0).into_owned();
        let turn = (linear[(1, 0)] - linear[(0, 1)]).atan2(linear[(0, 0)] + linear[(1, 1)]);
        let scale = linear.determinant().abs().max(1e-9).sqrt();
        let own = nalgebra::Rotation2::new(-turn).matrix() * linear / scale;
        Self {
            centre: crate::segment::object::apply(transform, centre.0, centre.1),
            size: scale.ln(),
            turn,
            aspect: 0.5 * (own[(0, 0)] - own[(1, 1)]),
            shear: 0.5 * (own[(0, 1)] + own[(1, 0)]),
        }
    }

    /// The linear part.
    pub fn linear(&self) -> Matrix2<f64> {
        let (a, b) = (self.aspect, self.shear);
        let base = (1.0 + a * a + b * b).sqrt();
        let own = Matrix2::new(base + a, b, b, base - a);
        nalgebra::Rotation2::new(self.turn).matrix() * own * self.size.exp()
    }

    /// The transform of a template whose centre is `centre`.
    pub fn transform(&self, centre: (f64, f64)) -> Matrix3<f64> {
        let m = self.linear();
        let x = self.centre.0 - m[(0, 0)] * centre.0 - m[(0, 1)] * centre.1;
        let y = self.centre.1 - m[(1, 0)] * centre.0 - m[(1, 1)] * centre.1;
        Matrix3::new(m[(0, 0)], m[(0, 1)], x, m[(1, 0)], m[(1, 1)], y, 0.0, 0.0, 1.0)
    }

    /// Centre, size and turn as a vector.
    pub fn vector(&self) -> Vector4<f64> {
        Vector4::new(self.centre.0, self.centre.1, self.size, self.turn)
    }

    /// The same aspect and shear with another centre, size and turn.
    pub fn with_vector(&self, v: &Vector4<f64>) -> Self {
        Self { centre: (v[0], v[1]), size: v[2], turn: v[3], ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_gives_its_transform_back() {
        let transform = Matrix3::new(1.1, -0.3, 20.0, 0.25, 0.9, -7.0, 0.0, 0.0, 1.0);
        let again = Pose::of(&transform, (31.0, 12.0)).transform((31.0, 12.0));
        assert!((transform - again).abs().max() < 1e-9, "{again}");
    }
}
