//! MANO's rotations as a regressor gives them.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::contract::Rotations;
use crate::geometry::Side;

/// `count` rotations of a right hand, from the numbers of a tensor; `None` where these are too few or no rotations.
pub(super) fn rotations(
    numbers: &[f32],
    count: usize,
    kind: Option<Rotations>,
) -> Option<Vec<UnitQuaternion<f64>>> {
    let each = numbers.len() / count.max(1);
    let kind = kind.unwrap_or(if each >= 9 { Rotations::Matrix } else { Rotations::AxisAngle });
    let size = match kind {
        Rotations::Matrix => 9,
        Rotations::AxisAngle => 3,
    };
    if numbers.len() < size * count || numbers.iter().any(|number| !number.is_finite()) {
        return None;
    }
    let parts = numbers.chunks_exact(size).take(count);
    let rotation = |part: &[f32]| {
        let part: Vec<f64> = part.iter().map(|number| f64::from(*number)).collect();
        match kind {
            Rotations::AxisAngle => Some(UnitQuaternion::from_scaled_axis(Vector3::from_column_slice(&part))),
            Rotations::Matrix => of_matrix(&Matrix3::from_row_slice(&part)),
        }
    };
    parts.map(rotation).collect()
}

/// The rotation whose first two columns a matrix all but has (Gram and Schmidt); `None` where they span no plane.
fn of_matrix(matrix: &Matrix3<f64>) -> Option<UnitQuaternion<f64>> {
    let (first, second) = (matrix.column(0).into_owned(), matrix.column(1).into_owned());
    let first = first.try_normalize(1e-6)?;
    let second = (second - first * first.dot(&second)).try_normalize(1e-6)?;
    let columns = Matrix3::from_columns(&[first, second, first.cross(&second)]);
    Some(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns)))
}

/// The rotation of a left hand that a right hand's is in the mirror: `diag(−1, 1, 1) R diag(−1, 1, 1)`.
pub(super) fn of_side(rotation: UnitQuaternion<f64>, side: Side) -> UnitQuaternion<f64> {
    match side {
        Side::Right => rotation,
        Side::Left => {
            let axis = rotation.scaled_axis();
            UnitQuaternion::from_scaled_axis(Vector3::new(axis.x, -axis.y, -axis.z))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_and_axis_angles_are_told_apart_by_their_size() {
        let turned = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.8, 0.5));
        let matrix: Vec<f32> =
            turned.to_rotation_matrix().matrix().transpose().iter().map(|number| *number as f32).collect();
        let axis: Vec<f32> = turned.scaled_axis().iter().map(|number| *number as f32).collect();
        for numbers in [matrix, axis] {
            let found = rotations(&numbers, 1, None).expect("a rotation");
            assert!(found[0].angle_to(&turned) < 1e-5);
        }
        assert_eq!(rotations(&[0.0; 8], 1, Some(Rotations::Matrix)), None);
        assert_eq!(rotations(&[f32::NAN; 3], 1, None), None);
        assert_eq!(rotations(&[0.0; 9], 1, None), None);
    }

    #[test]
    fn a_left_hand_turns_as_its_mirror_image() {
        let turned = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.8, 0.5));
        let mirror = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0));
        let expected = mirror * turned.to_rotation_matrix().matrix() * mirror;
        let found = of_side(turned, Side::Left).to_rotation_matrix();
        assert!((found.matrix() - expected).norm() < 1e-12);
        assert_eq!(of_side(turned, Side::Right), turned);
    }
}
