//! Which arms are drawn on a frame, and what lies in front of what.

use rayon::prelude::*;

use super::Understood;
use crate::{
    clip::{FrameIndex, FrameSource as _},
    composite::{
        order::{LayerDecision, OrderParams, SideEvidence, decide, evidence},
        placed_shape,
    },
    geometry::PerSide,
    image::Mask,
    pipeline::{ClipFailure, ExitCode},
    retarget::RobotMotion,
    session::Document,
};

/// One decision a frame.
#[derive(Clone, Debug)]
pub(crate) struct LayerPlan {
    pub(crate) shown: Vec<PerSide<bool>>,
    pub(crate) order: Vec<LayerDecision>,
}

/// Frames around a driven one on which an arm stays in the picture while it comes from or goes to rest.
const REST_FRAMES: usize = 24;
/// Contact from which a hand counts as touching.
const TOUCHING: f64 = 0.5;

/// What every source frame shows of hands before and behind the object; independent of the robot's motion.
pub(crate) type Evidence = Vec<PerSide<SideEvidence>>;

/// Looks at every frame.
pub(crate) fn layer_evidence(found: &Understood) -> Result<Evidence, ClipFailure> {
    let frames: Vec<FrameIndex> = FrameIndex::all(found.clip.frame_count()).collect();
    frames.par_iter().map(|index| frame_evidence(found, *index)).collect()
}

/// Plans every frame's layers.
pub(crate) fn plan_layers(document: &Document, found: &Understood, evidence: &Evidence) -> LayerPlan {
    let seen: Evidence = evidence
        .iter()
        .enumerate()
        .map(|(at, sides)| {
            PerSide::from_fn(|side| {
                let contact = found.hands.hands[side][at]
                    .is_valid()
                    .then_some(found.motion.sides[side][at].contact >= TOUCHING);
                SideEvidence { contact, ..sides[side] }
            })
        })
        .collect();
    let order = decide(&seen, &document.layer_orders, &OrderParams::default());
    LayerPlan { shown: shown_arms(&found.motion), order }
}

fn frame_evidence(found: &Understood, index: FrameIndex) -> Result<PerSide<SideEvidence>, ClipFailure> {
    let at = index.as_usize();
    let failed =
        |error: &(dyn std::error::Error + 'static)| ClipFailure::from_error(error, ExitCode::Internal);
    let size = found.clip.size();
    let visible = found.object.frame(index).mask.decode();
    let placement = found.template.as_ref().and_then(|track| Some((track, track.placements[at].as_ref()?)));
    let shape = match placement {
        Some((track, placement)) => placed_shape(track, placement, size).map_err(|error| failed(&error))?,
        None => Mask::new(size),
    };
    let mut result = PerSide::<SideEvidence>::default();
    for side in crate::geometry::Side::BOTH {
        let hand = &found.hands.hands[side][at];
        let arm = found.arms.sides[side][at].decode();
        let keypoints = hand.is_valid().then_some(&hand.keypoints);
        result[side] = evidence(&arm, &visible, &shape, keypoints, None).map_err(|error| failed(&error))?;
    }
    Ok(result)
}

/// An arm is drawn while a hand drives it and shortly before and after, on its way from and to rest.
pub fn shown_arms(motion: &RobotMotion) -> Vec<PerSide<bool>> {
    let count = motion.angles.len();
    let near_driven = |side: crate::geometry::Side, at: usize| {
        let window = at.saturating_sub(REST_FRAMES)..(at + REST_FRAMES + 1).min(count);
        motion.sides[side][window].iter().any(|report| report.driven)
    };
    (0..count).map(|at| PerSide::from_fn(|side| near_driven(side, at))).collect()
}
