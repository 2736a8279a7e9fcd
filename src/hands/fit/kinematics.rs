//! Forward kinematics of the hand and their derivatives.

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, UnitQuaternion, Vector3};

use super::shape::{HandShape, SHAPE_DOF};
use crate::landmarks::KEYPOINT_COUNT;

/// Parameters of a pose: wrist position (3), rotation (3), thumb (5), four fingers (4 each).
pub(super) const POSE_DOF: usize = 27;
/// Joint angles of a pose.
pub(super) const ANGLES: usize = 21;
/// A change of all pose parameters: metres, then radians.
pub(super) type PoseVector = SVector<f64, POSE_DOF>;

/// A hand's pose in the camera frame.
///
/// Angles in radians: thumb CMC flexion, abduction, twist, MCP, IP; then for index to little
/// finger abduction (towards the thumb) and flexion of MCP, PIP, DIP.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HandPose {
    pub wrist: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    pub angles: SVector<f64, ANGLES>,
}

impl HandPose {
    /// The pose after a step; the rotation's step is a rotation vector in camera axes.
    pub fn stepped(&self, step: &PoseVector) -> Self {
        Self {
            wrist: self.wrist + step.fixed_rows::<3>(0),
            rotation: UnitQuaternion::from_scaled_axis(step.fixed_rows::<3>(3).into_owned()) * self.rotation,
            angles: self.angles + step.fixed_rows::<ANGLES>(6),
        }
    }

    /// The step that leads from `other` to this pose.
    pub fn difference(&self, other: &Self) -> PoseVector {
        let mut step = PoseVector::zeros();
        step.fixed_rows_mut::<3>(0).copy_from(&(self.wrist - other.wrist));
        step.fixed_rows_mut::<3>(3).copy_from(&(self.rotation * other.rotation.inverse()).scaled_axis());
        step.fixed_rows_mut::<ANGLES>(6).copy_from(&(self.angles - other.angles));
        step
    }
}

/// The 21 joints in the camera frame.
pub(super) type Joints = [Vector3<f64>; KEYPOINT_COUNT];

/// Joints and their derivatives.
#[derive(Debug)]
pub(super) struct Posed {
    pub joints: Joints,
    /// d joint / d pose, metres per metre or radian.
    pub by_pose: [SMatrix<f64, 3, POSE_DOF>; KEYPOINT_COUNT],
    /// d joint / d shape.
    pub by_shape: [SMatrix<f64, 3, SHAPE_DOF>; KEYPOINT_COUNT],
}

/// Straight fingers' direction towards the thumb, index to little, radians.
const FAN: [f64; 4] = [0.09, 0.0, -0.09, -0.21];

/// One turn of a chain: which angle, about which axis of the frame it has reached, which way.
type Turn = (usize, Vector3<f64>);

/// Turns before each of a finger's three bones.
fn turns(finger: usize) -> [Vec<Turn>; 3] {
    let (flex, abduct, twist) = (-Vector3::z(), -Vector3::y(), Vector3::x());
    if finger == 0 {
        [vec![(1, abduct), (0, flex), (2, twist)], vec![(3, flex)], vec![(4, flex)]]
    } else {
        let first = 5 + 4 * (finger - 1);
        [vec![(first, abduct), (first + 1, flex)], vec![(first + 2, flex)], vec![(first + 3, flex)]]
    }
}

/// The frame of a finger at rest in the hand frame: x along it, −y the way it bends.
fn rest_frame(finger: usize) -> Rotation3<f64> {
    if finger == 0 {
        let x = Vector3::new(0.70, -0.42, 0.52).normalize();
        // A thumb bends towards a point over the palm's middle.
        let bend = Vector3::new(0.81, -0.50, -0.36);
        let y = -(bend - x * bend.dot(&x)).normalize();
        Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]))
    } else {
        Rotation3::from_axis_angle(&Vector3::y_axis(), -FAN[finger - 1])
    }
}

/// The joints alone.
pub(super) fn joints(shape: &HandShape, pose: &HandPose) -> Joints {
    let mut joints = [pose.wrist; KEYPOINT_COUNT];
    for finger in 0..5 {
        let mut frame = rest_frame(finger);
        let mut point = shape.bases[finger];
        let first = 1 + 4 * finger;
        joints[first] = pose.rotation * point + pose.wrist;
        for (bone, turns) in turns(finger).iter().enumerate() {
            for (angle, axis) in turns {
                frame *= Rotation3::from_scaled_axis(axis * pose.angles[*angle]);
            }
            point += frame * Vector3::x() * shape.bones[finger][bone];
            joints[first + 1 + bone] = pose.rotation * point + pose.wrist;
        }
    }
    joints
}

/// The joints with their derivatives: each angle moves what comes after it about its axis.
pub(super) fn posed(shape: &HandShape, pose: &HandPose) -> Posed {
    let rotation = pose.rotation.to_rotation_matrix();
    let mut posed = Posed {
        joints: [pose.wrist; KEYPOINT_COUNT],
        by_pose: [SMatrix::zeros(); KEYPOINT_COUNT],
        by_shape: [SMatrix::zeros(); KEYPOINT_COUNT],
    };
    for jacobian in &mut posed.by_pose {
        jacobian.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
    }
    for finger in 0..5 {
        let mut frame = rotation * rest_frame(finger);
        let mut point = rotation * shape.bases[finger];
        // Angle, axis and pivot of every turn so far; bone vectors so far.
        let mut moved: Vec<(usize, Vector3<f64>, Vector3<f64>)> = Vec::with_capacity(5);
        let mut bones: Vec<Vector3<f64>> = Vec::with_capacity(3);
        let first = 1 + 4 * finger;
        let mut record = |joint: usize,
                          point: Vector3<f64>,
                          moved: &[(usize, Vector3<f64>, Vector3<f64>)],
                          bones: &[Vector3<f64>]| {
            posed.joints[joint] = point + pose.wrist;
            let by_pose = &mut posed.by_pose[joint];
            by_pose.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-point.cross_matrix()));
            for (angle, axis, pivot) in moved {
                by_pose.set_column(6 + angle, &axis.cross(&(point - pivot)));
            }
            let by_shape = &mut posed.by_shape[joint];
            by_shape.fixed_view_mut::<3, 3>(0, 3 * finger).copy_from(rotation.matrix());
            for (bone, vector) in bones.iter().enumerate() {
                by_shape.set_column(15 + 3 * finger + bone, vector);
            }
        };
        record(first, point, &moved, &bones);
        for (bone, turns) in turns(finger).iter().enumerate() {
            for (angle, axis) in turns {
                moved.push((*angle, frame * axis, point));
                frame *= Rotation3::from_scaled_axis(axis * pose.angles[*angle]);
            }
            let vector = frame * Vector3::x() * shape.bones[finger][bone];
            point += vector;
            bones.push(vector);
            record(first + 1 + bone, point, &moved, &bones);
        }
    }
    posed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hands::fit::shape::ShapeVector;

    fn example() -> (HandShape, HandPose) {
        let angles = SVector::from_fn(|k, _| 0.1 + 0.07 * k as f64 % 0.9);
        let rotation = UnitQuaternion::from_euler_angles(0.4, -0.9, 1.3);
        (HandShape::average(0.187), HandPose { wrist: Vector3::new(0.05, -0.1, 0.45), rotation, angles })
    }

    #[test]
    fn derivatives_agree_with_finite_differences() {
        let (shape, pose) = example();
        let exact = posed(&shape, &pose);
        let h = 1e-6;
        for k in 0..POSE_DOF {
            let step = |s: f64| PoseVector::from_fn(|i, _| if i == k { s } else { 0.0 });
            let (a, b) = (joints(&shape, &pose.stepped(&step(h))), joints(&shape, &pose.stepped(&step(-h))));
            for j in 0..KEYPOINT_COUNT {
                let numeric = (a[j] - b[j]) / (2.0 * h);
                assert!((numeric - exact.by_pose[j].column(k)).norm() < 1e-7, "joint {j}, pose {k}");
            }
        }
        for k in 0..SHAPE_DOF {
            let step = |s: f64| ShapeVector::from_fn(|i, _| if i == k { s } else { 0.0 });
            let (a, b) = (joints(&shape.stepped(&step(h)), &pose), joints(&shape.stepped(&step(-h)), &pose));
            for j in 0..KEYPOINT_COUNT {
                let numeric = (a[j] - b[j]) / (2.0 * h);
                assert!((numeric - exact.by_shape[j].column(k)).norm() < 1e-7, "joint {j}, shape {k}");
            }
        }
    }

    #[test]
    fn a_straight_hand_has_the_stated_length() {
        let shape = HandShape::average(0.187);
        let (_, mut pose) = example();
        pose.angles.fill(0.0);
        let joints = joints(&shape, &pose);
        assert!((joints[12] - joints[0]).norm() - 0.187 < 1e-12);
        assert!((shape.length() - 0.187).abs() < 1e-12);
    }
}
