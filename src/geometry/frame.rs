//! Frames of reference as types, so that a camera point never meets a torso point by accident.

use std::marker::PhantomData;

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// A frame of reference.
pub trait Frame: Copy + std::fmt::Debug + PartialEq + Send + Sync + 'static {}

/// The source camera: OpenCV axes, x right, y down, z forward, metres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Camera;

/// The robot's `torso_link`: x forward, y left, z up, metres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Torso;

impl Frame for Camera {}
impl Frame for Torso {}

/// A point in frame `F`, in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent, bound = "")]
pub struct Position<F: Frame> {
    /// Coordinates in metres.
    pub xyz: Vector3<f64>,
    #[serde(skip)]
    frame: PhantomData<F>,
}

impl<F: Frame> Position<F> {
    /// The point at `xyz` metres.
    pub fn new(xyz: Vector3<f64>) -> Self {
        Self { xyz, frame: PhantomData }
    }

    /// Distance to `other` in metres.
    pub fn distance(&self, other: &Self) -> f64 {
        (self.xyz - other.xyz).norm()
    }

    /// Whether every coordinate is finite.
    pub fn is_finite(&self) -> bool {
        self.xyz.iter().all(|value| value.is_finite())
    }
}

impl<F: Frame> Default for Position<F> {
    fn default() -> Self {
        Self::new(Vector3::zeros())
    }
}

/// A rigid pose in frame `F`: metres and a unit quaternion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent, bound = "")]
pub struct Pose<F: Frame> {
    /// The transform that takes body coordinates to frame `F`.
    pub isometry: Isometry3<f64>,
    #[serde(skip)]
    frame: PhantomData<F>,
}

impl<F: Frame> Pose<F> {
    /// The pose `isometry`.
    pub fn new(isometry: Isometry3<f64>) -> Self {
        Self { isometry, frame: PhantomData }
    }

    /// The pose at `position` with `rotation`.
    pub fn from_parts(position: Position<F>, rotation: UnitQuaternion<f64>) -> Self {
        Self::new(Isometry3::from_parts(position.xyz.into(), rotation))
    }

    /// Origin of the body in metres.
    pub fn position(&self) -> Position<F> {
        Position::new(self.isometry.translation.vector)
    }

    /// Rotation from body to frame.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        self.isometry.rotation
    }

    /// Takes a point given in body coordinates (metres) to frame `F`.
    pub fn transform(&self, body_point: Vector3<f64>) -> Position<F> {
        Position::new((self.isometry * Point3::from(body_point)).coords)
    }

    /// `[x, y, z, qw, qx, qy, qz]` in metres, the order of the record.
    pub fn to_xyz_wxyz(&self) -> [f64; 7] {
        let t = self.isometry.translation.vector;
        let q = self.isometry.rotation;
        [t.x, t.y, t.z, q.w, q.i, q.j, q.k]
    }
}

impl<F: Frame> Default for Pose<F> {
    fn default() -> Self {
        Self::new(Isometry3::identity())
    }
}
