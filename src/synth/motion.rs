//! The script of an episode: where hands, object and camera are at every moment.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::Rng as _;
use rand_pcg::Pcg64Mcg;

use super::{
    grasp::{self, Grasp, GraspKind},
    hand_shape::{HandPose, HandShape},
    object::{ObjectKind, ObjectShape},
};
use crate::geometry::Side;

/// Where a wrist is and how the fingers stand.
#[derive(Clone, Copy, Debug)]
pub struct HandState {
    /// The hand's right-handed frame in the world, metres.
    pub wrist: Isometry3<f64>,
    /// Joint angles.
    pub pose: HandPose,
    /// Where the elbow is, world.
    pub elbow: Vector3<f64>,
}

/// The camera over time: a mean pose and smooth sway. World axes: x right, y away from the person, z up.
#[derive(Clone, Debug)]
pub struct CameraPath {
    height: f64,
    pitch: f64,
    /// Amplitude (metres for 0..3, radians for 3..6), frequency (hertz) and phase of two waves each.
    waves: [[[f64; 3]; 2]; 6],
}

impl CameraPath {
    /// A random head: `steady` ones hardly move.
    pub fn random(rng: &mut Pcg64Mcg) -> Self {
        let steady = rng.random_bool(0.3);
        let scale = if steady { 0.06 } else { rng.random_range(0.4..1.0) };
        let limit = [0.012, 0.012, 0.008, 0.022, 0.030, 0.014];
        let waves = limit.map(|most: f64| {
            [0.18, 0.55].map(|base: f64| {
                let slow = 0.25 / base;
                [
                    scale * most * slow.min(1.0) * rng.random_range(0.5..1.0),
                    base * rng.random_range(0.7..1.3),
                    rng.random_range(0.0..std::f64::consts::TAU),
                ]
            })
        });
        Self {
            height: rng.random_range(0.38..0.47),
            pitch: rng.random_range(48.0_f64..59.0).to_radians(),
            waves,
        }
    }

    /// Where the optical axis meets the table, metres away from the person.
    pub fn focus(&self) -> f64 {
        self.height / self.pitch.tan()
    }

    /// Camera (OpenCV axes) to world at `seconds`.
    pub fn at(&self, seconds: f64) -> Isometry3<f64> {
        let offset: [f64; 6] = self.waves.map(|waves| {
            waves.iter().map(|[a, f, phase]| a * (std::f64::consts::TAU * f * seconds + phase).sin()).sum()
        });
        let (s, c) = self.pitch.sin_cos();
        let mean =
            Matrix3::from_columns(&[Vector3::x(), Vector3::new(0.0, -s, -c), Vector3::new(0.0, c, -s)]);
        let mean = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(mean));
        let sway = UnitQuaternion::from_euler_angles(offset[3], offset[4], offset[5]);
        let position = Vector3::new(offset[0], offset[1], self.height + offset[2]);
        Isometry3::from_parts(Translation3::from(position), mean * sway)
    }
}

#[derive(Clone, Copy, Debug)]
struct Key {
    /// Share of the episode.
    time: f64,
    wrist: Isometry3<f64>,
    pose: HandPose,
}

/// A whole episode's movement.
#[derive(Clone, Debug)]
pub struct Script {
    /// The hand that moves the object.
    pub side: Side,
    /// How it takes it.
    pub kind: GraspKind,
    keys: Vec<Key>,
    grasp: Grasp,
    rest: UnitQuaternion<f64>,
    start: Isometry3<f64>,
    end: Isometry3<f64>,
    elbow: Vector3<f64>,
    idle: Option<HandState>,
}

/// How far the second hand draws back before and after it rests on the table, metres: out of the picture.
const IDLE_AWAY: f64 = 0.32;
const CLOSED: f64 = 0.33;
const OPENING: f64 = 0.73;

/// Minimum-jerk share of a movement.
fn minimum_jerk(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

fn elbow_of(side: Side) -> Vector3<f64> {
    Vector3::new(if side == Side::Right { 0.31 } else { -0.31 }, -0.12, -0.03)
}

fn turn_towards(side: Side, x: f64, y: f64) -> f64 {
    let elbow = elbow_of(side);
    // The wrist takes a part of the turn.
    1.1 * (elbow.x - x).abs().atan2(y - elbow.y) * elbow.x.signum()
}

impl Script {
    /// A random reach, grasp, lift, move, place and retreat.
    pub fn random(
        kind: ObjectKind,
        grasp_kind: GraspKind,
        shape: &ObjectShape,
        hand: &HandShape,
        both: bool,
        focus: f64,
        rng: &mut Pcg64Mcg,
    ) -> Self {
        let side = if rng.random_bool(0.65) { Side::Right } else { Side::Left };
        let out = if side == Side::Right { 1.0 } else { -1.0 };
        let tool = kind == ObjectKind::Tool;
        let rest = if tool {
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), out * std::f64::consts::FRAC_PI_2)
        } else {
            UnitQuaternion::identity()
        };
        let height = if tool {
            shape.radius_at(-0.98 * shape.half_height()).max(shape.radius_at(-0.05 * shape.half_height()))
        } else {
            shape.half_height()
        };
        let (from, to) = places(out, focus, rng);
        let place = |[x, y]: [f64; 2], jitter: f64| {
            let yaw = turn_towards(side, x, y) + jitter;
            Isometry3::from_parts(
                Translation3::new(x, y, height),
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw),
            )
        };
        let start = place(from, rng.random_range(-0.15..0.15));
        let end = place(to, rng.random_range(-0.25..0.25));
        let grasp = grasp::grasp(grasp_kind, shape, &rest, hand, side);
        let keys = keys(side, grasp_kind, &grasp, &start, &end, focus, rng);
        let idle = both.then(|| idle_hand(side.other(), focus, rng));
        Self { side, kind: grasp_kind, keys, grasp, rest, start, end, elbow: elbow_of(side), idle }
    }

    /// The moving hand at a share `t` of the episode.
    pub fn hand(&self, t: f64) -> HandState {
        let next = self.keys.iter().position(|key| key.time > t).unwrap_or(self.keys.len() - 1).max(1);
        let (a, b) = (&self.keys[next - 1], &self.keys[next]);
        let share = minimum_jerk((t - a.time) / (b.time - a.time));
        let mut translation = a.wrist.translation.vector.lerp(&b.wrist.translation.vector, share);
        // Hands move in shallow arcs, not along rulers.
        let distance = (b.wrist.translation.vector - a.wrist.translation.vector).norm();
        translation.z += 0.10 * distance * (std::f64::consts::PI * share).sin().powi(2);
        let rotation = a.wrist.rotation.slerp(&b.wrist.rotation, share);
        HandState {
            wrist: Isometry3::from_parts(translation.into(), rotation),
            pose: a.pose.lerp(&b.pose, share),
            elbow: self.elbow,
        }
    }

    /// The second hand at `seconds`, a share `t` of the episode, where there is one: it comes, rests and goes again.
    pub fn idle(&self, seconds: f64, t: f64) -> Option<HandState> {
        let mut state = self.idle?;
        let away = 1.0 - minimum_jerk((t - 0.04) / 0.14) + minimum_jerk((t - 0.72) / 0.16);
        state.wrist.translation.vector +=
            away * IDLE_AWAY * (state.elbow - state.wrist.translation.vector).normalize();
        let wave = |frequency: f64, phase: f64| (std::f64::consts::TAU * frequency * seconds + phase).sin();
        state.wrist.translation.vector += Vector3::new(0.006 * wave(0.3, 0.0), 0.008 * wave(0.23, 1.0), 0.0);
        for (index, finger) in state.pose.fingers.iter_mut().enumerate() {
            let bend = 0.05 * wave(0.35, index as f64 * 0.7);
            finger.flexion = finger.flexion.map(|angle| angle + bend);
        }
        Some(state)
    }

    /// Whether the moving hand holds the object.
    pub fn holds(&self, t: f64) -> bool {
        (CLOSED..OPENING).contains(&t)
    }

    /// The object's frame in the world.
    pub fn object(&self, t: f64) -> Isometry3<f64> {
        let rest = Isometry3::from_parts(Translation3::identity(), self.rest);
        if t < CLOSED {
            self.start * rest
        } else if t < OPENING {
            self.hand(t).wrist * self.grasp.hand.inverse() * rest
        } else {
            self.end * rest
        }
    }
}

fn places(out: f64, focus: f64, rng: &mut Pcg64Mcg) -> ([f64; 2], [f64; 2]) {
    loop {
        let mut place = || [out * rng.random_range(-0.13..0.12), focus + rng.random_range(-0.035..0.075)];
        let (from, to) = (place(), place());
        if (from[0] - to[0]).hypot(from[1] - to[1]) > 0.11 {
            return (from, to);
        }
    }
}

fn keys(
    side: Side,
    kind: GraspKind,
    grasp: &Grasp,
    start: &Isometry3<f64>,
    end: &Isometry3<f64>,
    focus: f64,
    rng: &mut Pcg64Mcg,
) -> Vec<Key> {
    let out = if side == Side::Right { 1.0 } else { -1.0 };
    let away = |hand: &Isometry3<f64>| {
        let back = match kind {
            GraspKind::Wrap => hand.rotation * Vector3::new(-0.055, 0.045, 0.0),
            GraspKind::Pinch => Vector3::new(0.01 * out, -0.03, 0.07),
        };
        Translation3::from(back) * hand
    };
    let (take, leave) = (start * grasp.hand, end * grasp.hand);
    let lifted = |share: f64, rng: &mut Pcg64Mcg| {
        let mut object = start.lerp_slerp(end, share);
        object.translation.vector.z += rng.random_range(0.05..0.11);
        object.translation.vector.y -= rng.random_range(0.0..0.04);
        let tilt = UnitQuaternion::from_euler_angles(
            rng.random_range(-0.25..0.3),
            rng.random_range(-0.3..0.3),
            rng.random_range(-0.2..0.2),
        );
        object.rotation = tilt * object.rotation;
        object * grasp.hand
    };
    let lift = lifted(rng.random_range(0.1..0.4), rng);
    let carry = lifted(rng.random_range(0.7..0.95), rng);
    let home = |rng: &mut Pcg64Mcg| {
        let x = Vector3::new(-0.75 * out, 1.0, -0.1);
        let y = Vector3::new(0.35 * out, 0.1, 1.0);
        let at = Vector3::new(
            out * rng.random_range(0.19..0.26),
            focus - rng.random_range(0.13..0.19),
            rng.random_range(0.05..0.10),
        );
        Isometry3::from_parts(at.into(), grasp::hand_rotation(x, y))
    };
    let (first, last) = (home(rng), home(rng));
    let pre = grasp::preshaped(kind);
    [
        (0.0, first, grasp::relaxed()),
        (0.05, first, grasp::relaxed()),
        (0.20, away(&take), pre),
        (0.27, take, grasp.open),
        (CLOSED, take, grasp.closed),
        (0.46, lift, grasp.closed),
        (0.60, carry, grasp.closed),
        (0.70, leave, grasp.closed),
        (OPENING, leave, grasp.closed),
        (0.78, leave, grasp.open),
        (0.85, away(&leave), pre),
        (0.97, last, grasp::relaxed()),
        (1.01, last, grasp::relaxed()),
    ]
    .into_iter()
    .map(|(time, wrist, pose)| Key { time, wrist, pose })
    .collect()
}

fn idle_hand(side: Side, focus: f64, rng: &mut Pcg64Mcg) -> HandState {
    let out = if side == Side::Right { 1.0 } else { -1.0 };
    let x = Vector3::new(-out * rng.random_range(0.4..1.1), 1.0, -0.05);
    let y = Vector3::new(out * rng.random_range(0.05..0.4), 0.0, 1.0);
    let at = Vector3::new(out * rng.random_range(0.19..0.23), focus - rng.random_range(0.10..0.16), 0.045);
    HandState {
        wrist: Isometry3::from_parts(at.into(), grasp::hand_rotation(x, y)),
        pose: grasp::relaxed(),
        elbow: elbow_of(side),
    }
}
