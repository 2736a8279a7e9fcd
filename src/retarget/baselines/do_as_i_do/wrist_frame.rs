//! The wrist's orientation from four points of the palm.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::{geometry::Side, robot::SideChain};

/// z = J9 − J0 (wrist → middle base), y' = J5 − J13 on the right hand and J13 − J5 on the left (ring and index
/// bases), x = y' × z, y = z × x, all normalised. `None` when the points do not span a plane.
pub(super) fn wrist_rotation(
    side: Side,
    wrist: &Vector3<f64>,
    index_base: &Vector3<f64>,
    middle_base: &Vector3<f64>,
    ring_base: &Vector3<f64>,
) -> Option<UnitQuaternion<f64>> {
    let z = (middle_base - wrist).try_normalize(1e-6)?;
    let across = if side == Side::Right { index_base - ring_base } else { ring_base - index_base };
    let x = across.cross(&z).try_normalize(1e-6)?;
    let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
    Some(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes)))
}

/// The same frame on the robot's hand, in its wrist frame: constant, since the palm does not bend.
pub(super) fn frame_in_wrist(side: Side, chain: &SideChain) -> UnitQuaternion<f64> {
    let bases = chain.bases_in_palm().map(|base| chain.palm_in_wrist() * base);
    wrist_rotation(side, &Vector3::zeros(), &bases[1], &bases[2], &bases[3]).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn z_points_to_the_fingers_and_the_axes_are_right_handed() {
        let at = |x: f64, y: f64| Vector3::new(x, y, 0.0);
        for side in Side::BOTH {
            let rotation =
                wrist_rotation(side, &at(0.0, 0.0), &at(0.08, 0.02), &at(0.09, 0.0), &at(0.08, -0.02))
                    .unwrap();
            assert!((rotation * Vector3::z() - Vector3::x()).norm() < 1e-12);
            // Index towards ring on the left, ring towards index on the right.
            let across = if side == Side::Right { Vector3::y() } else { -Vector3::y() };
            assert!((rotation * Vector3::y() - across).norm() < 1e-12);
        }
    }
}
