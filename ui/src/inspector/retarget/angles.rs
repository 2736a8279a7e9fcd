//! Pitch, yaw and roll of a camera rotation, however it was given.

use agenticfocus::retarget::{CameraAngles, CameraRotation};

/// The angles of `rotation`. Straight up or down, where yaw and roll are one, roll is 0.
pub(super) fn angles_of(rotation: &CameraRotation) -> CameraAngles {
    if let CameraRotation::Angles(angles) = rotation {
        return *angles;
    }
    let Ok(matrix) = rotation.matrix() else { return CameraAngles::default() };
    let forward = matrix.column(2);
    let pitch = (-forward.z).clamp(-1.0, 1.0).asin();
    let (yaw, roll) = if forward.x.hypot(forward.y) < 1e-6 {
        // Without roll the camera's right is (sin yaw, -cos yaw, 0).
        (matrix[(0, 0)].atan2(-matrix[(1, 0)]), 0.0)
    } else {
        // Without roll the camera's right is level and its down is -cos(pitch) high.
        (forward.y.atan2(forward.x), (-matrix[(2, 0)]).atan2(-matrix[(2, 1)]))
    };
    CameraAngles { pitch_deg: pitch.to_degrees(), yaw_deg: yaw.to_degrees(), roll_deg: roll.to_degrees() }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_angles_of_a_matrix_make_that_matrix(
            pitch in -80.0..80.0_f64,
            yaw in -170.0..170.0_f64,
            roll in -170.0..170.0_f64,
        ) {
            let given = CameraRotation::Angles(CameraAngles { pitch_deg: pitch, yaw_deg: yaw, roll_deg: roll });
            let matrix = given.matrix().unwrap();
            let rows = std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]));
            let again = CameraRotation::Angles(angles_of(&CameraRotation::Rows(rows))).matrix().unwrap();
            prop_assert!((again - matrix).amax() < 1e-6, "{again} {matrix}");
        }
    }
}
