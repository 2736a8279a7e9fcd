//! A person's edits, applied to what the machine found.

use std::collections::BTreeMap;

use crate::{
    clip::FrameIndex,
    geometry::{Pixel, Side, Size},
    landmarks::{HandLandmarks, KEYPOINT_COUNT, LandmarkTrack},
    pipeline::ClipFailure,
    segment::RleMask,
    session::{Document, HandEdit, MaskEdit, MaskLayer, MaskStore},
};

/// The human masks of `layer`; "absent" is the empty mask.
pub(super) fn human_masks(
    document: &Document,
    store: &MaskStore,
    layer: MaskLayer,
    size: Size,
    frame_count: usize,
) -> Result<BTreeMap<FrameIndex, RleMask>, ClipFailure> {
    let mut masks = BTreeMap::new();
    for (frame, edit) in document.masks(layer) {
        if frame.as_usize() >= frame_count {
            return Err(ClipFailure::bad_input(format_args!(
                "the session has a mask on {frame}, but the clip has {frame_count} frames"
            )));
        }
        let mask = match edit {
            MaskEdit::Absent => RleMask::empty(size),
            MaskEdit::Mask(id) => store.get(id)?,
        };
        if mask.size() != size {
            return Err(ClipFailure::bad_input(format_args!(
                "the session's mask on {frame} is {}, the clip is {size}",
                mask.size()
            )));
        }
        masks.insert(*frame, mask);
    }
    Ok(masks)
}

/// Landmarks with sides exchanged and hands struck out as the session says: what masks are made from. Dragged
/// keypoints leave the masks alone, so that correcting a finger costs a fit, not a segmentation.
pub(super) fn landmarks_with_sides(mut track: LandmarkTrack, document: &Document) -> LandmarkTrack {
    for range in &document.sides_swapped {
        let (first, last) = (range.first.as_usize(), range.last.as_usize());
        for hands in track.iter_mut().take(last.saturating_add(1)).skip(first) {
            std::mem::swap(&mut hands.left, &mut hands.right);
        }
    }
    for (frame, side, edit) in hand_edits(document) {
        if edit.invalid
            && let Some(hands) = track.get_mut(frame.as_usize())
        {
            hands[side] = None;
        }
    }
    track
}

/// Landmarks with keypoints moved as the session says: what hands are fitted to. A hand that the estimator missed is
/// there once a person placed all of it.
pub(super) fn landmarks_with_keypoints(mut track: LandmarkTrack, document: &Document) -> LandmarkTrack {
    for (frame, side, edit) in hand_edits(document).filter(|(_, _, edit)| !edit.invalid) {
        let Some(hands) = track.get_mut(frame.as_usize()) else { continue };
        match &mut hands[side] {
            Some(hand) => move_keypoints(hand, edit),
            None => hands[side] = placed_hand(edit),
        }
    }
    track
}

/// What a person said of hands, frame by frame.
pub(super) fn hand_edits(document: &Document) -> impl Iterator<Item = (&FrameIndex, Side, &HandEdit)> {
    Side::BOTH
        .into_iter()
        .flat_map(|side| document.hand_edits[side].iter().map(move |(frame, edit)| (frame, side, edit)))
}

/// A hand of which a person placed every keypoint.
fn placed_hand(edit: &HandEdit) -> Option<HandLandmarks> {
    let mut keypoints = [Pixel::default(); KEYPOINT_COUNT];
    for (index, keypoint) in keypoints.iter_mut().enumerate() {
        *keypoint = *edit.keypoints.get(&(index as u8))?;
    }
    Some(HandLandmarks { keypoints, world: None, confidence: 1.0 })
}

/// Moves the keypoints that a person dragged.
pub(super) fn move_keypoints(hand: &mut HandLandmarks, edit: &HandEdit) {
    for (index, pixel) in &edit.keypoints {
        if let Some(keypoint) = hand.keypoints.get_mut(usize::from(*index)) {
            *keypoint = *pixel;
        }
    }
    if !edit.keypoints.is_empty() {
        // A person looked at it; the estimator's own shape prior no longer describes it.
        hand.confidence = 1.0;
        hand.world = None;
    }
}
