//! The terms of one frame: what the pose says against what was seen and what hands can do.

use nalgebra::{Matrix2x3, SMatrix, SVector, Vector2, Vector3};

use super::{
    kinematics::{ANGLES, HandPose, POSE_DOF, PoseVector, Posed, joints, posed},
    priors::{AnglePrior, DIP_SHARE, DIP_SIGMA, LIMIT_SIGMA, angle_priors},
    shape::{HandShape, SHAPE_DOF, ShapeVector},
};
use crate::landmarks::{KEYPOINT_COUNT, keypoint::PARENT};

/// What was seen of a hand on a frame, mirrored for right hands.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    /// Normalised picture coordinates: ((u − cx) / fx, (v − cy) / fy).
    pub rays: [Vector2<f64>; KEYPOINT_COUNT],
    /// Spread of a keypoint in normalised coordinates.
    pub sigma: f64,
    /// Unit directions of the bones into each joint, as the estimator's model believes them.
    pub bone_hints: Option<[Vector3<f64>; KEYPOINT_COUNT]>,
}

/// Residuals beyond this many spreads count linearly (Huber).
const HUBER: f64 = 2.5;
/// Spread of a hinted bone direction (chord of the unit sphere).
const HINT_SIGMA: f64 = 0.45;
/// Joints must stay this far in front of the camera, metres.
const NEAREST: f64 = 0.02;

/// Second-order picture of a frame's cost around a pose and a shape.
#[derive(Clone, Debug)]
pub(super) struct Normal {
    pub cost: f64,
    pub gradient: PoseVector,
    pub hessian: SMatrix<f64, POSE_DOF, POSE_DOF>,
    pub shape_gradient: ShapeVector,
    pub shape_hessian: SMatrix<f64, SHAPE_DOF, SHAPE_DOF>,
    pub cross: SMatrix<f64, POSE_DOF, SHAPE_DOF>,
}

impl Normal {
    fn new() -> Self {
        Self {
            cost: 0.0,
            gradient: PoseVector::zeros(),
            hessian: SMatrix::zeros(),
            shape_gradient: ShapeVector::zeros(),
            shape_hessian: SMatrix::zeros(),
            cross: SMatrix::zeros(),
        }
    }
}

/// Huber's cost and the weight of the equivalent least-squares term, for a residual in spreads.
fn huber(norm: f64) -> (f64, f64) {
    if norm <= HUBER { (0.5 * norm * norm, 1.0) } else { (HUBER * (norm - 0.5 * HUBER), HUBER / norm) }
}

fn project(point: &Vector3<f64>) -> Vector2<f64> {
    let z = point.z.max(NEAREST);
    Vector2::new(point.x / z, point.y / z)
}

/// Cost of a frame, without derivatives.
pub(super) fn cost(shape: &HandShape, pose: &HandPose, sight: Option<&Sight>) -> f64 {
    let mut total = angle_cost(pose);
    if let Some(sight) = sight {
        let joints = joints(shape, pose);
        for (joint, ray) in joints.iter().zip(&sight.rays) {
            total += huber((project(joint) - ray).norm() / sight.sigma).0;
        }
        if let Some(hints) = &sight.bone_hints {
            for (k, hint) in hints.iter().enumerate().skip(1) {
                let bone = (joints[k] - joints[PARENT[k]]).normalize();
                total += huber((bone - hint).norm() / HINT_SIGMA).0;
            }
        }
    }
    total
}

/// Root mean square distance of projected and seen keypoints, normalised coordinates.
pub(super) fn reprojection(shape: &HandShape, pose: &HandPose, sight: &Sight) -> f64 {
    let joints = joints(shape, pose);
    let sum: f64 = joints.iter().zip(&sight.rays).map(|(p, ray)| (project(p) - ray).norm_squared()).sum();
    (sum / KEYPOINT_COUNT as f64).sqrt()
}

/// The frame's cost with its derivatives; those by shape only when asked for.
pub(super) fn normal(shape: &HandShape, pose: &HandPose, sight: Option<&Sight>, with_shape: bool) -> Normal {
    let mut normal = Normal::new();
    add_angles(&mut normal, pose);
    if let Some(sight) = sight {
        let posed = posed(shape, pose);
        for joint in 0..KEYPOINT_COUNT {
            add_keypoint(&mut normal, &posed, joint, sight, with_shape);
        }
        if let Some(hints) = &sight.bone_hints {
            for (joint, hint) in hints.iter().enumerate().skip(1) {
                add_hint(&mut normal, &posed, joint, hint);
            }
        }
    }
    normal
}

fn add_keypoint(normal: &mut Normal, posed: &Posed, joint: usize, sight: &Sight, with_shape: bool) {
    let p = posed.joints[joint];
    let z = p.z.max(NEAREST);
    let residual = (project(&p) - sight.rays[joint]) / sight.sigma;
    let (cost, weight) = huber(residual.norm());
    let s = 1.0 / (z * sight.sigma);
    let projection = Matrix2x3::new(s, 0.0, -s * p.x / z, 0.0, s, -s * p.y / z);
    let jacobian = projection * posed.by_pose[joint];
    normal.cost += cost;
    normal.gradient += jacobian.tr_mul(&(residual * weight));
    let weighted = jacobian * weight;
    normal.hessian += jacobian.tr_mul(&weighted);
    if with_shape {
        let by_shape = projection * posed.by_shape[joint];
        normal.shape_gradient += by_shape.tr_mul(&(residual * weight));
        normal.shape_hessian += by_shape.tr_mul(&(by_shape * weight));
        normal.cross += weighted.tr_mul(&by_shape);
    }
}

fn add_hint(normal: &mut Normal, posed: &Posed, joint: usize, hint: &Vector3<f64>) {
    let parent = PARENT[joint];
    let bone = posed.joints[joint] - posed.joints[parent];
    let length = bone.norm().max(1e-6);
    let direction = bone / length;
    let residual = (direction - hint) / HINT_SIGMA;
    let (cost, weight) = huber(residual.norm());
    let tangent = (nalgebra::Matrix3::identity() - direction * direction.transpose()) / (length * HINT_SIGMA);
    let jacobian = tangent * (posed.by_pose[joint] - posed.by_pose[parent]);
    normal.cost += cost;
    normal.gradient += jacobian.tr_mul(&(residual * weight));
    normal.hessian += jacobian.tr_mul(&(jacobian * weight));
}

/// How far an angle is beyond its limits, signed.
fn excess(angle: f64, prior: &AnglePrior) -> f64 {
    (angle - prior.high).max(0.0) + (angle - prior.low).min(0.0)
}

fn angle_cost(pose: &HandPose) -> f64 {
    let priors = angle_priors();
    let mut total = 0.0;
    for (angle, prior) in pose.angles.iter().zip(&priors) {
        let beyond = excess(*angle, prior) / LIMIT_SIGMA;
        let unusual = (angle - prior.usual) / prior.spread;
        total += 0.5 * (beyond * beyond + unusual * unusual);
    }
    for finger in 0..4 {
        let dip = dip_residual(&pose.angles, finger);
        total += 0.5 * dip * dip;
    }
    total
}

fn dip_residual(angles: &SVector<f64, ANGLES>, finger: usize) -> f64 {
    let pip = 5 + 4 * finger + 2;
    (angles[pip + 1] - DIP_SHARE * angles[pip]) / DIP_SIGMA
}

fn add_angles(normal: &mut Normal, pose: &HandPose) {
    normal.cost += angle_cost(pose);
    for (k, prior) in angle_priors().iter().enumerate() {
        let (row, angle) = (6 + k, pose.angles[k]);
        let beyond = excess(angle, prior);
        let precision = 1.0 / (prior.spread * prior.spread);
        normal.gradient[row] += (angle - prior.usual) * precision;
        normal.hessian[(row, row)] += precision;
        if beyond != 0.0 {
            normal.gradient[row] += beyond / (LIMIT_SIGMA * LIMIT_SIGMA);
            normal.hessian[(row, row)] += 1.0 / (LIMIT_SIGMA * LIMIT_SIGMA);
        }
    }
    for finger in 0..4 {
        let pip = 6 + 5 + 4 * finger + 2;
        let residual = dip_residual(&pose.angles, finger) / DIP_SIGMA;
        let precision = 1.0 / (DIP_SIGMA * DIP_SIGMA);
        normal.gradient[pip + 1] += residual;
        normal.gradient[pip] -= DIP_SHARE * residual;
        normal.hessian[(pip + 1, pip + 1)] += precision;
        normal.hessian[(pip, pip)] += DIP_SHARE * DIP_SHARE * precision;
        normal.hessian[(pip, pip + 1)] -= DIP_SHARE * precision;
        normal.hessian[(pip + 1, pip)] -= DIP_SHARE * precision;
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;

    #[test]
    fn gradients_agree_with_finite_differences() {
        let shape = HandShape::average(0.187);
        let angles = SVector::from_fn(|k, _| 0.2 + 0.09 * k as f64 % 1.1);
        let rotation = UnitQuaternion::from_euler_angles(0.4, -0.9, 1.3);
        let pose = HandPose { wrist: Vector3::new(0.05, -0.1, 0.45), rotation, angles };
        let joints = joints(&shape, &pose);
        let rays =
            std::array::from_fn(|k| project(&joints[k]) + Vector2::new(0.0031, 0.01 - 0.001 * k as f64));
        let hints = std::array::from_fn(|k| Vector3::new(0.3, 0.1 * k as f64, 0.5).normalize());
        let sight = Sight { rays, sigma: 0.002, bone_hints: Some(hints) };
        let exact = normal(&shape, &pose, Some(&sight), true);
        assert!((exact.cost - cost(&shape, &pose, Some(&sight))).abs() < 1e-9);
        let h = 1e-6;
        for k in 0..POSE_DOF {
            let at = |s: f64| {
                let step = PoseVector::from_fn(|i, _| if i == k { s } else { 0.0 });
                cost(&shape, &pose.stepped(&step), Some(&sight))
            };
            let numeric = (at(h) - at(-h)) / (2.0 * h);
            let error = (numeric - exact.gradient[k]).abs();
            assert!(error < 1e-4 * (1.0 + numeric.abs()), "{k}: {numeric} against {}", exact.gradient[k]);
        }
    }
}
