//! Grasps: where the hand sits on the object and how far the fingers close before they touch it.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::{
    hand_shape::{HandPose, HandShape},
    object::{ObjectKind, ObjectShape},
    skin::bone_radii,
};
use crate::geometry::Side;

/// How the hand takes the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GraspKind {
    /// Palm and all fingers around an upright object.
    Wrap,
    /// Thumb against the fingertips from above.
    Pinch,
}

impl GraspKind {
    /// The natural grasp of an object of `kind`; `chance` in 0..1 decides where there are two.
    pub fn of(kind: ObjectKind, chance: f64) -> Self {
        match kind {
            ObjectKind::Ball | ObjectKind::Tool => Self::Pinch,
            ObjectKind::Box | ObjectKind::Can if chance < 0.25 => Self::Pinch,
            _ => Self::Wrap,
        }
    }
}

/// Takes canonical hand coordinates of either side to a right-handed hand frame and back.
pub fn mirrored(side: Side, p: Vector3<f64>) -> Vector3<f64> {
    match side {
        Side::Left => p,
        Side::Right => Vector3::new(p.x, p.y, -p.z),
    }
}

/// The rotation of a hand whose canonical x and y axes point along `x` and `y` of the world.
pub fn hand_rotation(x: Vector3<f64>, y: Vector3<f64>) -> UnitQuaternion<f64> {
    let x = x.normalize();
    let y = (y - x * y.dot(&x)).normalize();
    let matrix = Matrix3::from_columns(&[x, y, x.cross(&y)]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

/// A hand on an object.
#[derive(Clone, Debug)]
pub struct Grasp {
    /// The hand in the object's frame.
    pub hand: Isometry3<f64>,
    /// Fingers in contact.
    pub closed: HandPose,
    /// Fingers a little opened, as before the touch.
    pub open: HandPose,
}

/// Fingers at a share `s` of closing; `s` has one value for the thumb and each finger.
fn closing(kind: GraspKind, s: &[f64; 5]) -> HandPose {
    let mut pose = HandPose::default();
    let degrees = |low: f64, high: f64, t: f64| (low + (high - low) * t).to_radians();
    let spread = [4.0, 1.0, -3.0, -7.0];
    for (index, finger) in pose.fingers.iter_mut().enumerate() {
        let t = s[index + 1];
        let curl = match kind {
            GraspKind::Wrap => [degrees(-4.0, 92.0, t), degrees(8.0, 105.0, t)],
            GraspKind::Pinch => [degrees(14.0, 74.0, t), degrees(14.0, 92.0, t)],
        };
        finger.flexion = [curl[0], curl[1], curl[1] * 0.62];
        finger.abduction = f64::to_radians(spread[index]) * (1.0 - 0.8 * t);
    }
    let t = s[0];
    pose.thumb.opposition = match kind {
        GraspKind::Wrap => 0.30 + 0.55 * t,
        GraspKind::Pinch => 0.45 + 0.40 * t,
    };
    pose.thumb.flexion = [degrees(0.0, 45.0, t), degrees(4.0, 62.0, t)];
    pose
}

/// The relaxed hand.
pub fn relaxed() -> HandPose {
    closing(GraspKind::Pinch, &[0.18, 0.22, 0.26, 0.30, 0.34])
}

/// A hand about to take something.
pub fn preshaped(kind: GraspKind) -> HandPose {
    match kind {
        GraspKind::Wrap => closing(kind, &[0.0, 0.10, 0.10, 0.12, 0.14]),
        GraspKind::Pinch => closing(kind, &[0.05, 0.12, 0.12, 0.16, 0.2]),
    }
}

/// Places the hand of `side` on the object and closes every finger until it touches.
///
/// The result is in the object's resting frame: z up, y away from the person; `rest` takes the object's own
/// frame there.
pub fn grasp(
    kind: GraspKind,
    shape: &ObjectShape,
    rest: &UnitQuaternion<f64>,
    hand: &HandShape,
    side: Side,
) -> Grasp {
    let unit = hand.scale();
    let outward = if side == Side::Right { 1.0 } else { -1.0 };
    let (rotation, anchor, at) = match kind {
        GraspKind::Wrap => {
            let height = (0.056 * unit - shape.half_height()).max(-0.2 * shape.half_height());
            let (x, y) = (Vector3::y(), Vector3::x() * outward);
            let radius = shape.radius_at(height);
            let tilted = (x - Vector3::z() * 0.16).normalize();
            let centre = Vector3::new(0.088 * unit, -(radius + 0.0215 * unit), 0.0);
            (hand_rotation(tilted, y), centre, Vector3::new(0.0, 0.0, height))
        }
        GraspKind::Pinch => {
            let pitch: f64 = 0.45;
            let x = Vector3::new(0.0, pitch.cos(), -pitch.sin());
            let y = Vector3::new(0.0, pitch.sin(), pitch.cos());
            // A lying tool is taken by its handle.
            let lying = rest.angle() > 0.1;
            // What stands tall is taken near its top.
            let top = (shape.half_height() - 0.032).max(0.0);
            let along = if lying { -0.35 * shape.half_height() } else { top };
            let radius = shape.radius_at(along);
            let centre = Vector3::new(0.116 * unit, -0.055 * unit - 0.55 * radius, 0.012 * unit);
            (hand_rotation(x, y), centre, rest * Vector3::new(0.0, 0.0, along) + Vector3::z() * 0.004)
        }
    };
    let offset = at - rotation * mirrored(side, anchor);
    let placed = Isometry3::from_parts(Translation3::from(offset), rotation);
    let shares = close(kind, shape, hand, side, &(rest.inverse() * placed));
    let opened = std::array::from_fn(|i| (shares[i] - 0.16).max(0.0));
    Grasp { hand: placed, closed: closing(kind, &shares), open: closing(kind, &opened) }
}

fn close(
    kind: GraspKind,
    shape: &ObjectShape,
    hand: &HandShape,
    side: Side,
    placed: &Isometry3<f64>,
) -> [f64; 5] {
    const STEPS: u32 = 80;
    let mut shares = [0.0; 5];
    for (finger, share) in shares.iter_mut().enumerate() {
        for step in 0..=STEPS {
            let s = f64::from(step) / f64::from(STEPS);
            let posed = hand.pose(&closing(kind, &[s; 5]));
            let touches =
                posed.bones[finger].iter().enumerate().skip(usize::from(finger == 0)).any(|(index, bone)| {
                    let [ra, rb] = bone_radii(hand, finger, index);
                    (1..=4).any(|k| {
                        let t = f64::from(k) / 4.0;
                        let tip = if index == 2 { rb / (bone.end - bone.start).norm() } else { 0.0 };
                        let p = bone.start.lerp(&bone.end, t * (1.0 - tip));
                        let p = placed * Point3::from(mirrored(side, p));
                        shape.distance(&p.coords) < ra + (rb - ra) * t - 0.0012
                    })
                });
            if touches {
                break;
            }
            *share = s;
        }
        // A finger that meets nothing stays half curled.
        if *share > 0.97 {
            *share = 0.55;
        }
    }
    shares
}
