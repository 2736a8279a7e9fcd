//! Putting a path onto another by a fitted transform. Only by option: a fit hides a constant error.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// How a path is brought into the frame of the one it is compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Alignment {
    /// By the known transforms alone.
    #[default]
    None,
    /// And by the rotation and translation that fit best.
    Rigid,
    /// And by the rotation, translation and scale that fit best.
    Similarity,
}

impl Alignment {
    /// Its name on the command line and in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rigid => "rigid",
            Self::Similarity => "similarity",
        }
    }

    /// `path` brought onto `onto`, fitted over the points that `counts`; unchanged where nothing can be fitted.
    pub fn apply(self, path: &[Vector3<f64>], onto: &[Vector3<f64>], counts: &[bool]) -> Vec<Vector3<f64>> {
        let chosen = |points: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
            points.iter().zip(counts).filter(|(_, counts)| **counts).map(|(point, _)| *point).collect()
        };
        let fitted = match self {
            Self::None => None,
            Self::Rigid => umeyama(&chosen(path), &chosen(onto), false),
            Self::Similarity => umeyama(&chosen(path), &chosen(onto), true),
        };
        match fitted {
            Some(fitted) => path.iter().map(|point| fitted.apply(point)).collect(),
            None => path.to_vec(),
        }
    }
}

/// `scale · rotation · p + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Uniform scale.
    pub scale: f64,
    /// Rotation.
    pub rotation: Matrix3<f64>,
    /// Translation, metres.
    pub translation: Vector3<f64>,
}

impl Similarity {
    /// The transformed point.
    pub fn apply(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.scale * (self.rotation * point) + self.translation
    }
}

/// The transform of `from` that is nearest to `to` in the sense of least squares (Umeyama 1991), with or without
/// scale; `None` for fewer than 3 pairs, lists of different lengths, or points that all coincide.
pub fn umeyama(from: &[Vector3<f64>], to: &[Vector3<f64>], scaled: bool) -> Option<Similarity> {
    if from.len() < 3 || from.len() != to.len() {
        return None;
    }
    let count = from.len() as f64;
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / count;
    let (centre_from, centre_to) = (mean(from), mean(to));
    let mut covariance = Matrix3::zeros();
    let mut spread = 0.0;
    for (a, b) in from.iter().zip(to) {
        covariance += (b - centre_to) * (a - centre_from).transpose() / count;
        spread += (a - centre_from).norm_squared() / count;
    }
    if spread < 1e-18 || !covariance.iter().all(|value| value.is_finite()) {
        return None;
    }
    let decomposed = covariance.svd(true, true);
    let (u, v_t) = (decomposed.u?, decomposed.v_t?);
    let mut signs = Vector3::repeat(1.0);
    if u.determinant() * v_t.determinant() < 0.0 {
        let least = decomposed.singular_values.imin();
        signs[least] = -1.0;
    }
    let rotation = u * Matrix3::from_diagonal(&signs) * v_t;
    let scale = if scaled { decomposed.singular_values.dot(&signs) / spread } else { 1.0 };
    Some(Similarity { scale, rotation, translation: centre_to - scale * (rotation * centre_from) })
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;
    use proptest::prelude::*;

    use super::*;

    fn curve() -> Vec<Vector3<f64>> {
        (0..40).map(f64::from).map(|t| Vector3::new((0.2 * t).cos(), (0.31 * t).sin(), 0.02 * t)).collect()
    }

    proptest! {
        #[test]
        fn a_known_transform_is_found_again(
            angles in prop::array::uniform3(-3.0_f64..3.0),
            shift in prop::array::uniform3(-2.0_f64..2.0),
            scale in 0.3_f64..3.0,
        ) {
            let rotation = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]).into_inner();
            let known = Similarity { scale, rotation, translation: Vector3::from(shift) };
            let moved: Vec<_> = curve().iter().map(|point| known.apply(point)).collect();
            let found = umeyama(&curve(), &moved, true).unwrap();
            prop_assert!((found.scale - scale).abs() < 1e-9);
            prop_assert!((found.rotation - rotation).amax() < 1e-9);
            prop_assert!((found.translation - known.translation).amax() < 1e-9);
            let rigid = umeyama(&curve(), &moved, false).unwrap();
            prop_assert!((rigid.rotation - rotation).amax() < 1e-9 && rigid.scale == 1.0);
        }
    }

    #[test]
    fn a_mirror_image_is_not_taken_for_a_rotation() {
        let mirrored: Vec<_> = curve().iter().map(|p| Vector3::new(-p.x, p.y, p.z)).collect();
        let found = umeyama(&curve(), &mirrored, false).unwrap();
        assert!((found.rotation.determinant() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_constant_error_is_hidden_only_where_it_is_asked_for() {
        let moved: Vec<_> = curve().iter().map(|point| point + Vector3::repeat(0.1)).collect();
        let counts = vec![true; moved.len()];
        let off = |alignment: Alignment| (alignment.apply(&moved, &curve(), &counts)[7] - curve()[7]).norm();
        assert!(off(Alignment::None) > 0.17 && off(Alignment::Rigid) < 1e-9);
        assert!(off(Alignment::Similarity) < 1e-9);
        assert!(umeyama(&[Vector3::x(); 5], &[Vector3::y(); 5], true).is_none());
    }
}
