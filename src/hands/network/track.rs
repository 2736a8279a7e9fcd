//! The driver: hands found on every frame, told apart, each side's crops regressed, all of it cleaned.

use opencv::core::Mat;

use super::{
    boxes::HandBox,
    clean::{Seen, cleaned},
    follow::{SideBoxes, by_side},
    net::HandNetwork,
};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::{PerSide, Pinhole, Side},
    hands::{HandFrame, HandTrack, HandsError},
    image::Rgb8,
    progress::Watch,
    vision::single_threaded,
};

/// Distances of a person's own hands from the camera, metres.
const USUAL: std::ops::RangeInclusive<f64> = 0.15..=1.5;
/// Trust that hands elsewhere keep.
const UNUSUAL_TRUST: f64 = 0.5;

/// Metric hands of both sides in the frame of `camera`, by a network. The detector looks at every frame first, so that a
/// hand's side is that of its whole way through the clip; the regressor then sees each side's crop once.
///
/// Memory: two frames, and small numbers for every frame.
///
/// # Errors
/// When a frame cannot be read, OpenCV or the network fails, or when cancelled.
pub fn track_hands(
    frames: &dyn FrameSource,
    network: &mut HandNetwork,
    camera: &Pinhole,
    watch: &dyn Watch,
) -> Result<HandTrack, HandsError> {
    single_threaded();
    let count = frames.frame_count();
    let found = detect_all(frames, network, watch)?;
    let boxes = by_side(found, frames.size());
    let seen = regress_all(frames, network, &boxes, camera, watch)?;
    let PerSide { left, right } = seen;
    let ((left, left_length), (right, right_length)) = (cleaned(left, camera), cleaned(right, camera));
    watch.advance(2 * count, 2 * count);
    Ok(HandTrack {
        hands: PerSide { left, right },
        hand_length: PerSide { left: left_length, right: right_length },
        backend: network.name().to_owned(),
    })
}

/// Every frame's hands; a frame that repeats the one before shares them.
fn detect_all(
    frames: &dyn FrameSource,
    network: &mut HandNetwork,
    watch: &dyn Watch,
) -> Result<Vec<Vec<HandBox>>, HandsError> {
    let count = frames.frame_count();
    let mut found: Vec<Vec<HandBox>> = Vec::with_capacity(count);
    let mut before: Option<Rgb8> = None;
    for index in FrameIndex::all(count) {
        watch.check()?;
        let picture = frames.frame(index)?;
        let repeated = if before.as_ref() == Some(&picture) { found.last().cloned() } else { None };
        let hands = match repeated {
            Some(hands) => hands,
            None => network.detect(&picture.to_mat()?)?,
        };
        found.push(hands);
        before = Some(picture);
        watch.advance(index.as_usize() + 1, 2 * count);
    }
    Ok(found)
}

/// What the regressor says of each side's box on every frame that has one.
fn regress_all(
    frames: &dyn FrameSource,
    network: &mut HandNetwork,
    boxes: &PerSide<SideBoxes>,
    camera: &Pinhole,
    watch: &dyn Watch,
) -> Result<PerSide<Vec<Seen>>, HandsError> {
    let count = frames.frame_count();
    let mut seen: PerSide<Vec<Seen>> = PerSide::from_fn(|_| vec![None; count]);
    let mut before: Option<Rgb8> = None;
    for index in FrameIndex::all(count) {
        watch.check()?;
        let at = index.as_usize();
        if Side::BOTH.iter().all(|side| boxes[*side][at].is_none()) {
            before = None;
            continue;
        }
        let picture = frames.frame(index)?;
        let repeats = before.as_ref() == Some(&picture);
        let mut mat: Option<Mat> = None;
        for side in Side::BOTH {
            let Some((bounds, trust)) = &boxes[side][at] else { continue };
            if repeats && at > 0 && boxes[side][at - 1] == boxes[side][at] {
                seen[side][at] = seen[side][at - 1].clone();
                continue;
            }
            let picture = match &mat {
                Some(picture) => picture,
                None => mat.insert(picture.to_mat()?),
            };
            let crop = network.crop(bounds, side);
            let placed = network.regress(picture, &crop)?.placed(&crop, camera);
            seen[side][at] = placed.map(|hand| {
                let usual = USUAL.contains(&hand.joints[0].xyz.z);
                (hand, if usual { *trust } else { UNUSUAL_TRUST * trust })
            });
        }
        before = Some(picture);
        watch.advance(count + at + 1, 2 * count);
    }
    Ok(seen)
}

/// What to say where most hands are not where a person's own hands can be: mostly the camera's focal length is wrong.
pub fn distance_warning(track: &HandTrack, camera: &Pinhole) -> Option<String> {
    let hands = track.hands.iter().flat_map(|(_, side)| side.iter().filter(|hand| hand.is_valid()));
    let distances: Vec<f64> = hands.map(HandFrame::wrist).map(|wrist| wrist.xyz.z).collect();
    let unusual = distances.iter().filter(|distance| !USUAL.contains(*distance)).count();
    (2 * unusual > distances.len()).then(|| {
        format!(
            "{} puts the hands {:.2} m away, {} to {} m expected: is the camera's focal length {:.0} px?",
            track.backend,
            crate::smoothing::median(&distances),
            USUAL.start(),
            USUAL.end(),
            camera.fx
        )
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::{
        geometry::{Position, Size},
        hands::HandState,
    };

    #[test]
    fn hands_that_nobodys_arms_reach_are_warned_of() {
        let camera = Pinhole { fx: 500.0, fy: 500.0, cx: 320.0, cy: 240.0, size: Size::new(640, 480) };
        let track = |z: f64| {
            let at = Position::new(Vector3::new(0.0, 0.0, z));
            let hand = HandFrame { state: HandState::Observed, joints: [at; 21], ..HandFrame::invalid() };
            let left = vec![hand, HandFrame::invalid()];
            HandTrack {
                hands: PerSide { left, right: vec![HandFrame::invalid(); 2] },
                hand_length: PerSide::default(),
                backend: "Net".to_owned(),
            }
        };
        assert_eq!(distance_warning(&track(0.5), &camera), None);
        let line = distance_warning(&track(3.0), &camera).unwrap();
        assert!(line.contains("Net puts the hands 3.00 m away") && line.contains("500 px"), "{line}");
    }
}
