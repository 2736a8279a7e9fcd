//! A hand as a parallel gripper: grasp point, orientation, width (Masquerade's action from keypoints).

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::{
    hands::HandFrame,
    landmarks::keypoint::{BASES, TIPS},
    robot::{SIDE_DOF, SideChain, SidePosture},
};

/// The points that the gripper is read off, metres, in any one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct GraspPoints {
    pub thumb_tip: Vector3<f64>,
    pub index_base: Vector3<f64>,
    pub index_tip: Vector3<f64>,
    pub middle_tip: Vector3<f64>,
}

/// A gripper in the frame of its points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grasp {
    /// Grasp point and orientation R_ee.
    pub pose: Isometry3<f64>,
    /// Thumb tip to index tip, metres.
    pub width: f64,
}

impl GraspPoints {
    /// Of a human hand, camera axes; `None` where it is not valid or not finite.
    pub fn of_human(frame: &HandFrame) -> Option<Self> {
        if !frame.is_valid() || !frame.joints.iter().all(|joint| joint.is_finite()) {
            return None;
        }
        let at = |index: usize| frame.joints[index].xyz;
        Some(Self {
            thumb_tip: at(TIPS[0]),
            index_base: at(BASES[1]),
            index_tip: at(TIPS[1]),
            middle_tip: at(TIPS[2]),
        })
    }

    /// Of the robot's hand with the six hand angles `hand`, in its wrist frame.
    pub fn of_robot(chain: &SideChain, hand: &[f64; 6]) -> Self {
        let mut angles = [0.0; SIDE_DOF];
        angles[7..].copy_from_slice(hand);
        let mut posture = SidePosture::default();
        chain.pose(&angles, &mut posture);
        let local = |point: Vector3<f64>| posture.wrist_rotation.inverse() * (point - posture.wrist);
        Self {
            thumb_tip: local(posture.tips[0]),
            index_base: chain.palm_in_wrist() * chain.bases_in_palm()[1],
            index_tip: local(posture.tips[1]),
            middle_tip: local(posture.tips[2]),
        }
    }

    /// The grasp point, midway between thumb tip and middle tip.
    pub fn point(&self) -> Vector3<f64> {
        (self.thumb_tip + self.middle_tip) / 2.0
    }

    /// With thumb tip P4, index base P5, index tip P8, middle tip P12: the grasp point is (P4 + P12)/2, the
    /// width ‖P4 − P8‖. The axes are x along P4 − P8, z away from the index base, R_ee = [x y z]·R_z(90°).
    /// `None` where thumb and index tip meet, or lie on one line with the index base.
    pub fn grasp(&self) -> Option<Grasp> {
        let closing = self.thumb_tip - self.index_tip;
        let middle = (self.thumb_tip + self.index_tip) / 2.0;
        let to_base = self.index_base - middle;
        let mut x = closing.try_normalize(1e-6)?;
        let away = -to_base.try_normalize(1e-6)?;
        let mut y = away.cross(&x).try_normalize(1e-6)?;
        let mut z = x.cross(&y);
        if z.dot(&to_base) > 0.0 {
            (x, y, z) = (-x, -y, -z);
        }
        if Matrix3::from_columns(&[x, y, z]).determinant() < 0.0 {
            x = -x;
        }
        let axes = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, z]));
        let quarter = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
        let rotation = UnitQuaternion::from_rotation_matrix(&axes) * quarter;
        Some(Grasp {
            pose: Isometry3::from_parts(Translation3::from(self.point()), rotation),
            width: closing.norm(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(map: impl Fn(Vector3<f64>) -> Vector3<f64>) -> GraspPoints {
        GraspPoints {
            thumb_tip: map(Vector3::new(0.04, 0.0, 0.1)),
            index_base: map(Vector3::new(0.0, 0.0, 0.0)),
            index_tip: map(Vector3::new(-0.04, 0.0, 0.1)),
            middle_tip: map(Vector3::new(-0.04, 0.02, 0.1)),
        }
    }

    #[test]
    fn a_small_case_by_hand() {
        let grasp = points(|point| point).grasp().unwrap();
        assert!((grasp.width - 0.08).abs() < 1e-12);
        assert!((grasp.pose.translation.vector - Vector3::new(0.0, 0.01, 0.1)).norm() < 1e-12);
        // x = (1, 0, 0), z = (0, 0, 1): a quarter turn about z is left.
        assert!((grasp.pose.rotation * Vector3::x() - Vector3::y()).norm() < 1e-12);
        assert!((grasp.pose.rotation * Vector3::z() - Vector3::z()).norm() < 1e-12);
    }

    #[test]
    fn fingertips_that_meet_have_no_closing_direction() {
        let mut meeting = points(|point| point);
        meeting.index_tip = meeting.thumb_tip;
        assert!(meeting.grasp().is_none());
    }

    proptest! {
        #[test]
        fn a_rigid_motion_of_the_camera_moves_the_gripper_along(
            turn in prop::array::uniform3(-3.0_f64..3.0),
            shift in prop::array::uniform3(-1.0_f64..1.0),
            noise in prop::array::uniform12(-0.02_f64..0.02),
        ) {
            let mut hand = points(|point| point);
            for (point, noise) in
                [&mut hand.thumb_tip, &mut hand.index_base, &mut hand.index_tip, &mut hand.middle_tip]
                    .into_iter()
                    .zip(noise.chunks(3))
            {
                *point += Vector3::from_column_slice(noise);
            }
            let motion = Isometry3::new(shift.into(), turn.into());
            let moved = |point: Vector3<f64>| (motion * nalgebra::Point3::from(point)).coords;
            let there = GraspPoints {
                thumb_tip: moved(hand.thumb_tip),
                index_base: moved(hand.index_base),
                index_tip: moved(hand.index_tip),
                middle_tip: moved(hand.middle_tip),
            };
            let (before, after) = (hand.grasp().unwrap(), there.grasp().unwrap());
            let expected = motion * before.pose;
            prop_assert!((after.pose.translation.vector - expected.translation.vector).norm() < 1e-9);
            prop_assert!(after.pose.rotation.angle_to(&expected.rotation) < 1e-6);
            prop_assert!((after.width - before.width).abs() < 1e-9);
        }
    }
}
