//! First guesses of a hand's pose on a frame: both ways a flat palm can be turned, with the fingers
//! straight and bent, refined and ranked.

use nalgebra::{Matrix3, Rotation3, SVector, UnitQuaternion, Vector2, Vector3};
use opencv::{
    calib3d::{SolvePnPMethod, rodrigues, solve_pnp_generic},
    core::{Mat, MatExprTraitConst, MatTraitConst, Point2d, Point3d, Vector},
};

use super::{
    kinematics::{ANGLES, HandPose},
    priors::usual_angles,
    shape::HandShape,
    single::refine,
    terms::Sight,
};
use crate::landmarks::keypoint::{BASES, WRIST};

/// A refined guess.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    pub pose: HandPose,
    pub cost: f64,
}

const ITERATIONS: usize = 25;
/// Hypotheses kept a frame.
const KEPT: usize = 3;

/// Local optima of a frame, best first, at least one.
pub(super) fn hypotheses(shape: &HandShape, sight: &Sight) -> opencv::Result<Vec<Hypothesis>> {
    let mut starts: Vec<HandPose> = Vec::new();
    for (rotation, wrist) in palm_poses(shape, sight)? {
        for angles in [usual_angles(), bent_angles()] {
            starts.push(HandPose { wrist, rotation, angles });
        }
    }
    if let Some(pose) = hinted_pose(shape, sight) {
        starts.push(pose);
    }
    if starts.is_empty() {
        starts.push(facing_pose(shape, sight));
    }
    let mut refined: Vec<Hypothesis> = starts
        .into_iter()
        .map(|start| {
            let (pose, cost) = refine(shape, start, sight, ITERATIONS);
            Hypothesis { pose, cost }
        })
        .collect();
    refined.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut kept: Vec<Hypothesis> = Vec::new();
    for hypothesis in refined {
        let new = kept.iter().all(|k| k.pose.difference(&hypothesis.pose).norm() > 0.3);
        if new && kept.len() < KEPT {
            kept.push(hypothesis);
        }
    }
    Ok(kept)
}

fn bent_angles() -> SVector<f64, ANGLES> {
    let mut angles = usual_angles();
    for finger in 0..4 {
        for (k, value) in [(1, 1.1), (2, 1.2), (3, 0.8)] {
            angles[5 + 4 * finger + k] = value;
        }
    }
    angles
}

/// The two poses of the flattened palm (IPPE), those in front of the camera.
fn palm_poses(shape: &HandShape, sight: &Sight) -> opencv::Result<Vec<(UnitQuaternion<f64>, Vector3<f64>)>> {
    // The palm's plane is x–z of the hand frame; IPPE wants it at z = 0: x stays, z becomes y.
    let mut model = vec![Point3d::new(0.0, 0.0, 0.0)];
    let mut seen = vec![Point2d::new(sight.rays[WRIST].x, sight.rays[WRIST].y)];
    for (base, keypoint) in shape.bases.iter().zip(BASES).skip(1) {
        model.push(Point3d::new(base.x, base.z, 0.0));
        let ray = sight.rays[keypoint];
        seen.push(Point2d::new(ray.x, ray.y));
    }
    let (mut rotations, mut translations) = (Vector::<Mat>::new(), Vector::<Mat>::new());
    let camera = Mat::eye(3, 3, opencv::core::CV_64F)?.to_mat()?;
    let found = solve_pnp_generic(
        &Vector::<Point3d>::from_iter(model),
        &Vector::<Point2d>::from_iter(seen),
        &camera,
        &Mat::default(),
        &mut rotations,
        &mut translations,
        false,
        SolvePnPMethod::SOLVEPNP_IPPE,
        &Mat::default(),
        &Mat::default(),
        &mut Mat::default(),
    );
    // Degenerate keypoints (all on a line) have no palm pose; other starts remain.
    if found.is_err() {
        return Ok(Vec::new());
    }
    // Hand axes in the flattened model's: x = x, y = −z, z = y (both right-handed).
    let from_hand = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0);
    let mut poses = Vec::new();
    for (rotation, translation) in rotations.iter().zip(&translations) {
        let mut matrix = Mat::default();
        rodrigues(&rotation, &mut matrix, &mut Mat::default())?;
        let mut r = Matrix3::zeros();
        let mut t = Vector3::zeros();
        for i in 0..3 {
            t[i] = *translation.at::<f64>(i as i32)?;
            for j in 0..3 {
                r[(i, j)] = *matrix.at_2d::<f64>(i as i32, j as i32)?;
            }
        }
        if t.iter().chain(r.iter()).all(|v| v.is_finite()) && t.z > 0.05 && t.z < 5.0 {
            let rotation = Rotation3::from_matrix_eps(&(r * from_hand), 1e-9, 50, Rotation3::identity());
            poses.push((UnitQuaternion::from_rotation_matrix(&rotation), t));
        }
    }
    Ok(poses)
}

/// The palm turned as the estimator's own hand is, placed by the size of what was seen.
fn hinted_pose(shape: &HandShape, sight: &Sight) -> Option<HandPose> {
    let hints = sight.bone_hints.as_ref()?;
    let x = hints[BASES[2]];
    let z = hints[BASES[1]] - hints[BASES[4]];
    let z = (z - x * z.dot(&x)).try_normalize(1e-6)?;
    let matrix = Matrix3::from_columns(&[x, z.cross(&x), z]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
    let wrist = placed(shape, sight, &rotation);
    Some(HandPose { wrist, rotation, angles: usual_angles() })
}

/// A hand flat in front of the camera, fingers the way they are seen.
fn facing_pose(shape: &HandShape, sight: &Sight) -> HandPose {
    let along = sight.rays[BASES[2]] - sight.rays[WRIST];
    let angle = along.y.atan2(along.x);
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)
        * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    HandPose { wrist: placed(shape, sight, &rotation), rotation, angles: usual_angles() }
}

/// The wrist at the depth at which the turned palm is as large as it was seen.
fn placed(shape: &HandShape, sight: &Sight, rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let spread = |points: &[Vector2<f64>]| -> f64 {
        let mean = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
        points.iter().map(|p| (p - mean).norm_squared()).sum::<f64>().sqrt()
    };
    let seen: Vec<Vector2<f64>> = BASES.iter().chain(&[WRIST]).map(|k| sight.rays[*k]).collect();
    let mut turned: Vec<Vector2<f64>> = shape.bases.iter().map(|b| (rotation * b).xy()).collect();
    turned.push(Vector2::zeros());
    let depth = (spread(&turned) / spread(&seen).max(1e-6)).clamp(0.1, 3.0);
    let ray = sight.rays[WRIST];
    Vector3::new(ray.x * depth, ray.y * depth, depth)
}
