//! Where the virtual camera sits when the robot's own head camera does not fit the clip.
//!
//! Most first-person clips suit the default: the robot's head camera. Where hands come into the picture from
//! above (a camera opposite the person) or work far away, the same picture is had from a virtual camera
//! elsewhere, since the overlay only depends on camera and robot moving together.

use nalgebra::Vector3;

use crate::{geometry::PerSide, robot::RobotModel, smoothing::median};

use super::{
    CameraMap, RetargetError,
    beta::{Reach, natural_beta, reach},
    params::{CameraAngles, CameraRotation, RetargetParams},
    track::HumanTrack,
};

/// Where hands work comfortably: the middle between both, and how far a single one sits to its side, metres.
const WORKSPACE: [f64; 3] = [0.28, 0.0, 0.12];
const ASIDE: f64 = 0.13;
/// The default stays where the wrists turn no farther than this from what they should, on average, radians.
const GOOD_TURN: f64 = 0.5;

/// The map (β = 1) that `params` ask for; where R_cam and T_offset are the untouched defaults and leave the
/// hands out of reach at every β, the one of a few other views that suits the hands best.
pub(super) fn choose_view(
    tracks: &PerSide<HumanTrack>,
    robot: &RobotModel,
    params: &RetargetParams,
) -> Result<CameraMap, RetargetError> {
    let given = params.map(1.0)?;
    let default = RetargetParams::default();
    if params.camera != default.camera || params.offset != default.offset {
        return Ok(given);
    }
    let Some(middle) = middle_of_wrists(tracks) else { return Ok(given) };
    let beta = natural_beta(tracks, robot);
    let judged = |map: CameraMap| reach(tracks, robot, params, map);
    let nearest = [0.6, 0.8, 1.0].map(|beta| judged(CameraMap { beta, ..given }));
    if nearest.iter().any(|reach| reach.share >= 0.8 && reach.turn < GOOD_TURN) {
        return Ok(given);
    }
    // The default is left only for something clearly better.
    let mut best = (nearest.iter().map(badness).fold(f64::INFINITY, f64::min) - 0.2, given);
    for yaw_deg in [0.0, 180.0] {
        for pitch_deg in [47.6, 20.0, 75.0] {
            let rotation =
                CameraRotation::Angles(CameraAngles { pitch_deg, yaw_deg, roll_deg: 0.0 }).matrix()?;
            let offset = workspace(tracks) - beta * (rotation * middle);
            let bad = badness(&judged(CameraMap { beta, rotation, offset }));
            if bad < best.0 {
                best = (bad, CameraMap { beta: 1.0, rotation, offset });
            }
        }
    }
    Ok(best.1)
}

fn badness(reach: &Reach) -> f64 {
    2.0 * (1.0 - reach.value) + reach.turn
}

/// The middle between the median wrists of the sides, camera axes, metres.
pub(super) fn middle_of_wrists(tracks: &PerSide<HumanTrack>) -> Option<Vector3<f64>> {
    let medians: Vec<Vector3<f64>> = tracks
        .iter()
        .filter(|(_, track)| track.size.is_some())
        .map(|(_, track)| {
            let axis = |axis: usize| {
                let values: Vec<f64> = track.poses.iter().flatten().map(|pose| pose.wrist[axis]).collect();
                median(&values)
            };
            Vector3::new(axis(0), axis(1), axis(2))
        })
        .collect();
    (!medians.is_empty()).then(|| medians.iter().sum::<Vector3<f64>>() / medians.len() as f64)
}

fn workspace(tracks: &PerSide<HumanTrack>) -> Vector3<f64> {
    let aside = match (tracks.left.size.is_some(), tracks.right.size.is_some()) {
        (true, false) => ASIDE,
        (false, true) => -ASIDE,
        _ => 0.0,
    };
    Vector3::from(WORKSPACE) + Vector3::y() * aside
}
