//! From hands to the robot's motion.

use std::sync::Arc;

use super::context::Context;
use crate::{
    clip::{FrameSource as _, StandardClip},
    geometry::PerSide,
    hands::{
        self, Estimation, FitParams, HandTrack, Surroundings,
        import::{self, ImportParams},
    },
    pipeline::{ClipFailure, ExitCode, Installation, Key, Stage},
    retarget::{self, RetargetParams, RobotMotion},
    robot::RobotModel,
    segment::{RleMask, arms::ArmTrack},
    session::Document,
    template::TemplateTrack,
};

/// The session's imported hand track, where it names one.
pub(super) fn imported_track(
    context: &Context<'_>,
    clip: &StandardClip,
) -> Result<Option<HandTrack>, ClipFailure> {
    let Some(path) = &context.document.hand_track else { return Ok(None) };
    let times: Vec<f64> = clip.info.frame_table.iter().map(|row| row.source_pts).collect();
    let track = import::read(path.as_ref(), &times, &clip.info.intrinsics, &ImportParams::default())
        .map_err(|error| ClipFailure::from_error(&error, ExitCode::BadInput).in_stage(Stage::Landmarks))?;
    Ok(Some(track))
}

/// What tells where a hidden hand has gone.
pub(super) fn surroundings(arms: &ArmTrack, template: Option<&TemplateTrack>) -> Surroundings {
    let arm_area = PerSide::from_fn(|side| arms.sides[side].iter().map(RleMask::area).collect());
    let placements = template.map_or(&[][..], |template| &template.placements);
    let object = placements.iter().map(|placement| Some(placement.as_ref()?.transform)).collect();
    Surroundings { arm_area, object }
}

/// Metric hands: fitted to the landmarks, or the imported ones as they are.
pub(super) fn hands(
    context: &Context<'_>,
    clip: &StandardClip,
    imported: Option<HandTrack>,
    seen: &Estimation,
    around: &Surroundings,
    keys: [&Key; 3],
) -> Result<(Arc<HandTrack>, Key), ClipFailure> {
    if let Some(mut track) = imported {
        strike_out(&mut track, &context.document);
        let key = Key::new(Stage::Hands, &keys[..1], &"imported")?;
        return Ok((Arc::new(track), key));
    }
    let mut params = FitParams::default();
    if let Some(length) = context.document.retarget.hand_length {
        params.hand_length_mm = length * 1000.0;
    }
    let camera = clip.info.intrinsics;
    debug_assert_eq!(camera.size, clip.size());
    let inputs = (&params, camera, &seen.backend);
    context.cached_stage(Stage::Hands, &keys, &inputs, ExitCode::Internal, |watch| {
        let filled = hands::fill_hidden(&seen.landmarks, around);
        let mut track = hands::fit(&filled.landmarks, &seen.backend, &camera, &params, watch)?;
        filled.mark(&mut track);
        Ok::<_, hands::HandsError>(track)
    })
}

/// Hands a person struck out of an imported track.
fn strike_out(track: &mut HandTrack, document: &Document) {
    for side in crate::geometry::Side::BOTH {
        for (frame, _) in document.hand_edits[side].iter().filter(|(_, edit)| edit.invalid) {
            if let Some(hand) = track.hands[side].get_mut(frame.as_usize()) {
                *hand = hands::HandFrame::invalid();
            }
        }
    }
}

/// The robot in use and its motion.
pub(super) fn retarget(
    context: &Context<'_>,
    hands: &HandTrack,
    hands_key: &Key,
) -> Result<(RobotModel, Arc<RobotMotion>), ClipFailure> {
    let load = || load_robot(context.installation).map_err(|failure| failure.in_stage(Stage::Retarget));
    let robot = match context.memory {
        Some(memory) => memory.robot(load)?,
        None => load()?,
    };
    let params = params_of(&context.document);
    let inputs = (&params, identity_of(&robot));
    let (motion, _) =
        context.cached_stage(Stage::Retarget, &[hands_key], &inputs, ExitCode::Internal, |watch| {
            retarget::retarget(hands, &robot, &params, watch)
        })?;
    let beta = motion.map.beta;
    context.listener.note(&format!("retargeted with β = {beta:.3}, α = {:.2}", motion.alpha));
    Ok((robot, motion))
}

fn params_of(document: &Document) -> RetargetParams {
    let settings = &document.retarget;
    let mut params = RetargetParams::default();
    if let Some(beta) = settings.beta {
        params.beta = beta;
    }
    if let Some(alpha) = settings.alpha {
        params.alpha = alpha;
    }
    if let Some(smoothing) = settings.smoothing {
        params.smoothing = smoothing;
    }
    params.wrist = settings.wrist;
    if let Some(rotation) = settings.camera_rotation {
        params.camera = rotation;
    }
    if let Some(offset) = settings.offset {
        params.offset = offset.into();
    }
    params
}

/// The robot that was imported as the default, else the embedded one.
pub(super) fn load_robot(installation: &Installation) -> Result<RobotModel, ClipFailure> {
    let imported = crate::robot::default_robot(&installation.data)
        .map_err(|error| ClipFailure::from_error(&error, ExitCode::BadInput))?;
    if let Some(robot) = imported {
        return Ok(robot);
    }
    RobotModel::embedded().map_err(|error| ClipFailure::from_error(&error, ExitCode::Internal))
}

/// What tells one robot from another.
pub(super) fn robot_identity(installation: &Installation) -> Result<String, ClipFailure> {
    Ok(identity_of(&load_robot(installation)?))
}

fn identity_of(robot: &RobotModel) -> String {
    blake3::hash(robot.mjcf().as_bytes()).to_hex().to_string()
}
