//! Captured hands in world axes, which no camera saw.

use std::{fs, path::Path};

use nalgebra::{Rotation3, Vector3};
use serde::Deserialize;

use super::{SourceError, any_camera, io};
use crate::{
    hands::{
        HandTrack,
        import::{self, ImportParams, WholeTrack},
    },
    landmarks::KEYPOINT_COUNT,
};

/// Files larger than this are looked at no further.
const LARGEST: u64 = 64 << 20;
/// Where the middle of the wrist's path comes to lie before the camera, metres.
const PLACE: [f64; 3] = [0.05, 0.03, 0.5];
/// How far the camera looks down, degrees.
const PITCH: f64 = 45.0;

/// `joints_world`: 21 joints a row, metres, world axes with z up and x away from the person.
#[derive(Deserialize)]
struct WorldMotion {
    fps: Option<f64>,
    joints_world: Vec<[[f64; 3]; KEYPOINT_COUNT]>,
}

/// Whether the file is a captured hand in world axes.
pub(super) fn is_one(path: &Path) -> bool {
    let is_json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let is_small = fs::metadata(path).is_ok_and(|data| data.is_file() && data.len() <= LARGEST);
    is_json
        && is_small
        && fs::read(path).is_ok_and(|bytes| bytes.windows(14).any(|window| window == b"\"joints_world\""))
}

/// The hand (a right one, since nothing is said of its side) as a head camera would have it, half a metre below and
/// before it: only so can a method that starts from a camera take it up.
pub(super) fn read(path: &Path) -> Result<HandTrack, SourceError> {
    let bytes = fs::read(path).map_err(io(path))?;
    let content = |what: String| SourceError::Content { path: path.to_owned(), what };
    let motion: WorldMotion = serde_json::from_slice(&bytes).map_err(|error| content(error.to_string()))?;
    let count = motion.joints_world.len().max(1) as f64;
    let middle = motion.joints_world.iter().map(|row| Vector3::from(row[0])).sum::<Vector3<f64>>() / count;
    let (sin, cos) = PITCH.to_radians().sin_cos();
    let to_camera = Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(
        0.0, -1.0, 0.0, -sin, 0.0, -cos, cos, 0.0, -sin,
    ));
    let place = |point: &[f64; 3]| to_camera * (Vector3::from(*point) - middle) + Vector3::from(PLACE);
    let rows = motion.joints_world.iter().map(|row| Some(std::array::from_fn(|k| place(&row[k]))));
    let whole = WholeTrack { left: None, right: Some(rows.collect()), fps: motion.fps };
    import::resample_whole(whole, path, &any_camera(), &ImportParams::default()).map_err(SourceError::from)
}
