//! The motion of an episode without its pictures: what hands do, exactly, in microseconds a frame.

use super::{
    generate::{draw, hand_truth},
    spec::{EpisodeSpec, SynthError},
    truth::HandTruth,
};
use crate::{
    clip::STANDARD_FPS,
    geometry::{PerSide, Pinhole, Side},
};

/// Hands of an episode: what [`super::EpisodeTruth`] says of them.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionTruth {
    /// The episode's seed.
    pub seed: u64,
    /// Intrinsics.
    pub pinhole: Pinhole,
    /// Wrist to middle fingertip along the bones, straight, metres; both hands.
    pub hand_length: f64,
    /// The hand that moves the object.
    pub moving_side: Side,
    /// The hands that exist, one a frame at 30 frames a second.
    pub frames: Vec<PerSide<Option<HandTruth>>>,
}

/// The motion that [`generate`](fn@super::generate) films for the same `spec`.
///
/// # Errors
/// With fewer than 2 frames.
pub fn motion_truth(spec: &EpisodeSpec) -> Result<MotionTruth, SynthError> {
    if spec.frames < 2 {
        return Err(SynthError::Spec { size: spec.size, frames: spec.frames });
    }
    let plan = draw(spec).plan;
    let frames = (0..spec.frames).map(|index| {
        let seconds = f64::from(index) / STANDARD_FPS;
        let t = f64::from(index) / f64::from(spec.frames - 1);
        let camera_to_world = plan.camera.at(seconds);
        let states = plan.hands(seconds, t);
        PerSide::from_fn(|side| {
            let state = states[side].as_ref()?;
            let posed = plan.hand.pose(&state.pose);
            let contact = side == plan.script.side && plan.script.holds(t);
            Some(hand_truth(&plan, side, state, &posed.joints, &camera_to_world, contact))
        })
    });
    Ok(MotionTruth {
        seed: spec.seed,
        pinhole: plan.pinhole,
        hand_length: plan.hand.hand_length,
        moving_side: plan.script.side,
        frames: frames.collect(),
    })
}
