//! From hands to the robot's motion.

use std::sync::Arc;

use super::{
    context::Context,
    edits::{hand_edits, move_keypoints},
    given_hands::GivenHands,
};
use crate::{
    clip::{FrameSource as _, StandardClip},
    geometry::{PerSide, Pinhole, Side},
    hands::{self, Estimation, FitParams, HandFrame, HandTrack, Surroundings},
    landmarks::{HandLandmarks, KEYPOINT_COUNT},
    pipeline::{ClipFailure, ExitCode, Installation, Key, Stage},
    retarget::{self, Method, RetargetParams, RobotMotion},
    robot::RobotModel,
    segment::{RleMask, arms::ArmTrack},
    session::{Document, HandEdit},
    template::TemplateTrack,
};

/// What tells where a hidden hand has gone.
pub(super) fn surroundings(arms: &ArmTrack, template: Option<&TemplateTrack>) -> Surroundings {
    let arm_area = PerSide::from_fn(|side| arms.sides[side].iter().map(RleMask::area).collect());
    let placements = template.map_or(&[][..], |template| &template.placements);
    let object = placements.iter().map(|placement| Some(placement.as_ref()?.transform)).collect();
    Surroundings { arm_area, object }
}

/// Metric hands: fitted to the landmarks, or the given ones with a person's corrections.
pub(super) fn hands(
    context: &Context<'_>,
    clip: &StandardClip,
    given: Option<GivenHands>,
    seen: &Estimation,
    around: &Surroundings,
    keys: [&Key; 3],
) -> Result<(Arc<HandTrack>, Key), ClipFailure> {
    match given {
        Some(GivenHands::Imported(mut track)) => {
            correct(&mut track, &context.document, &clip.info.intrinsics).map_err(|error| {
                ClipFailure::from_error(&error, ExitCode::Internal).in_stage(Stage::Hands)
            })?;
            let key = Key::new(Stage::Hands, &keys[..1], &"imported and corrected")?;
            return Ok((Arc::new(track), key));
        }
        Some(GivenHands::Network(track)) => {
            let (document, camera) = (&context.document, &clip.info.intrinsics);
            let inputs = ("by a network", document.retarget.hand_length, camera);
            return context.cached_stage(Stage::Hands, &keys, &inputs, ExitCode::Internal, |_| {
                let mut track = HandTrack::clone(&track);
                if let Some(length) = document.retarget.hand_length {
                    track.set_length(length);
                }
                correct(&mut track, document, camera)?;
                hands::fill_hidden(&seen.landmarks, around).complete(&mut track, camera)?;
                strike_out(&mut track, document);
                Ok::<_, hands::HandsError>(track)
            });
        }
        None => {}
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

/// A given track as a person corrected it: sides exchanged, joints moved, hands struck out.
fn correct(track: &mut HandTrack, document: &Document, camera: &Pinhole) -> Result<(), hands::HandsError> {
    for range in &document.sides_swapped {
        let (first, last) = (range.first.as_usize(), range.last.as_usize());
        let PerSide { left, right } = &mut track.hands;
        for (left, right) in left.iter_mut().zip(right).take(last.saturating_add(1)).skip(first) {
            std::mem::swap(left, right);
        }
    }
    for (frame, side, edit) in hand_edits(document) {
        let length = hands::length_of(Some(track), side);
        if let Some(hand) = track.hands[side].get_mut(frame.as_usize()) {
            move_joints(hand, edit, (side, length, camera))?;
        }
    }
    strike_out(track, document);
    Ok(())
}

/// Fits a given hand to the joints a person moved, as far away as it was.
fn move_joints(
    hand: &mut HandFrame,
    edit: &HandEdit,
    (side, length, camera): (Side, f64, &Pinhole),
) -> Result<(), hands::HandsError> {
    let known = hand.is_valid() || edit.keypoints.len() == KEYPOINT_COUNT;
    if edit.invalid || edit.keypoints.is_empty() || !known {
        return Ok(());
    }
    let mut seen = HandLandmarks { keypoints: hand.keypoints, world: None, confidence: 1.0 };
    move_keypoints(&mut seen, edit);
    let mut fitted = hands::fit_frame(&seen, side, camera, length, Some(hand))?;
    if !fitted.is_valid() {
        return Ok(());
    }
    if hand.is_valid() {
        // Nearer or farther by one factor, every joint is seen where it was.
        let factor = hand.wrist().xyz.z / fitted.wrist().xyz.z;
        for joint in &mut fitted.joints {
            joint.xyz *= factor;
        }
    }
    *hand = fitted;
    Ok(())
}

/// Hands a person struck out of a given track.
fn strike_out(track: &mut HandTrack, document: &Document) {
    for (frame, side, _) in hand_edits(document).filter(|(_, _, edit)| edit.invalid) {
        if let Some(hand) = track.hands[side].get_mut(frame.as_usize()) {
            *hand = HandFrame::invalid();
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
    context.listener.note(&match motion.method {
        Method::Ours => format!("retargeted with β = {beta:.3}, α = {:.2}", motion.alpha),
        method => format!("retargeted as {} does, with β = {beta:.3}", method.title()),
    });
    Ok((robot, motion))
}

fn params_of(document: &Document) -> RetargetParams {
    let settings = &document.retarget;
    let mut params = RetargetParams::default();
    if let Some(method) = settings.method {
        params.method = method;
    }
    if let Some(shared) = settings.shared_map {
        params.shared_map = shared;
    }
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::{
        clip::FrameIndex,
        geometry::{Pixel, Position, Size},
        hands::HandState,
        landmarks::keypoint::{BASES, PARENT},
        session::SidesSwapped,
    };

    fn camera() -> Pinhole {
        Pinhole { fx: 500.0, fy: 500.0, cx: 320.0, cy: 240.0, size: Size::new(640, 480) }
    }

    /// A flat hand half a metre away.
    fn flat(x: f64) -> HandFrame {
        let mut joints = [Position::new(nalgebra::Vector3::new(x, 0.05, 0.5)); KEYPOINT_COUNT];
        for (finger, base) in BASES.into_iter().enumerate() {
            for joint in base..base + 4 {
                let (along, aside) =
                    if joint == base { (0.085, 0.022 * (finger as f64 - 2.0)) } else { (0.03, 0.0) };
                let from = joints[PARENT[joint]].xyz;
                joints[joint] = Position::new(from + nalgebra::Vector3::new(aside, -along, 0.0));
            }
        }
        let keypoints = joints.map(|joint| camera().project(&joint).unwrap());
        HandFrame { state: HandState::Observed, confidence: 0.7, keypoints, joints, mano: None }
    }

    #[test]
    fn an_imported_hand_follows_the_joint_a_person_moved_and_stays_as_far_away() {
        let frames = || vec![flat(0.0), flat(0.02)];
        let mut track = HandTrack {
            hands: PerSide { left: frames(), right: vec![HandFrame::invalid(); 2] },
            hand_length: PerSide { left: Some(0.18), right: None },
            backend: "imported".to_owned(),
        };
        let mut document = Document::default();
        let wanted = Pixel::new(flat(0.02).keypoints[8].x + 25.0, flat(0.02).keypoints[8].y + 10.0);
        let edit = HandEdit { keypoints: BTreeMap::from([(8, wanted)]), invalid: false };
        document.hand_edits.left.insert(FrameIndex(1), edit);
        correct(&mut track, &document, &camera()).unwrap();
        assert_eq!(track.hands.left[0], flat(0.0));
        let moved = &track.hands.left[1];
        assert_eq!((moved.keypoints[8], moved.confidence > 0.0), (wanted, true));
        assert!((moved.wrist().xyz.z - 0.5).abs() < 1e-9);
        let tip = camera().project(&moved.joints[8]).unwrap();
        assert!(tip.distance(wanted) < flat(0.02).keypoints[8].distance(wanted), "{tip:?}");

        document.hand_edits.left.clear();
        document.sides_swapped = vec![SidesSwapped { first: FrameIndex(0), last: FrameIndex(0) }];
        correct(&mut track, &document, &camera()).unwrap();
        assert!(!track.hands.left[0].is_valid() && track.hands.left[1].is_valid());
        assert_eq!(track.hands.right[0], flat(0.0));
    }

    #[test]
    fn a_hidden_hand_is_put_into_a_network_s_track_as_far_away_as_before_and_after() {
        let near = |t: usize| {
            let mut hand = flat(0.002 * t as f64);
            // Nearer and nearer, the same in the picture.
            hand.joints.iter_mut().for_each(|joint| joint.xyz *= 1.0 - 0.01 * t as f64);
            hand
        };
        let whole: Vec<HandFrame> = (0..8).map(near).collect();
        let mut seen = whole.clone();
        seen[3..6].fill(HandFrame::invalid());
        let mut track = HandTrack {
            hands: PerSide { left: seen, right: vec![HandFrame::invalid(); 8] },
            hand_length: PerSide { left: Some(0.19), right: None },
            backend: "network".to_owned(),
        };
        let landmarks = whole.iter().map(|hand| {
            let seen = HandLandmarks { keypoints: hand.keypoints, world: None, confidence: 0.3 };
            PerSide { left: Some(seen), right: None }
        });
        let mut filled = hands::FilledLandmarks {
            landmarks: landmarks.collect(),
            filled: PerSide::from_fn(|_| vec![false; 8]),
        };
        filled.filled.left[3..6].fill(true);
        filled.complete(&mut track, &camera()).unwrap();
        for (frame, whole) in track.hands.left.iter().zip(&whole).take(6).skip(3) {
            assert_eq!(frame.state, HandState::Bridged);
            assert!((frame.wrist().xyz.z - whole.wrist().xyz.z).abs() < 1e-9);
        }
        assert!(track.hands.right.iter().all(|hand| !hand.is_valid()));
        track.set_length(0.38);
        assert!((track.hands.left[0].wrist().xyz.z - 2.0 * whole[0].wrist().xyz.z).abs() < 1e-9);
    }
}
