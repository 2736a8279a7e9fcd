//! A person's edits, applied to what the machine found.

use std::collections::BTreeMap;

use crate::{
    clip::FrameIndex,
    geometry::{Side, Size},
    landmarks::{HandLandmarks, LandmarkTrack},
    pipeline::ClipFailure,
    segment::RleMask,
    session::{Document, MaskEdit, MaskLayer, MaskStore},
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

/// Landmarks with sides exchanged, keypoints moved and hands struck out as the session says.
pub(super) fn edited_landmarks(mut track: LandmarkTrack, document: &Document) -> LandmarkTrack {
    for range in &document.sides_swapped {
        let (first, last) = (range.first.as_usize(), range.last.as_usize());
        for hands in track.iter_mut().take(last.saturating_add(1)).skip(first) {
            std::mem::swap(&mut hands.left, &mut hands.right);
        }
    }
    for side in Side::BOTH {
        for (frame, edit) in &document.hand_edits[side] {
            let Some(hands) = track.get_mut(frame.as_usize()) else { continue };
            if edit.invalid {
                hands[side] = None;
            } else if let Some(hand) = &mut hands[side] {
                move_keypoints(hand, edit);
            }
        }
    }
    track
}

fn move_keypoints(hand: &mut HandLandmarks, edit: &crate::session::HandEdit) {
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
