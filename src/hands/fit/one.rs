//! One hand on one frame alone: what a person sees while they drag a keypoint.

use super::{
    FitParams,
    kinematics::{HandPose, joints},
    shape::HandShape,
    side::{FittedSide, sight},
    start::hypotheses,
    track::to_frames,
};
use crate::{
    geometry::{PerSide, Pinhole, Side},
    hands::{HandFrame, HandTrack, HandsError},
    landmarks::HandLandmarks,
};

/// Fits a hand `length` metres long, wrist to middle tip, to `seen` on a frame by itself. Where two poses fit as well,
/// the one nearer to `before` is taken; the hand is invalid where none does. The fit of the whole clip may differ: it
/// knows the frames around and the hand's own shape.
///
/// # Errors
/// When OpenCV fails.
pub fn fit_frame(
    seen: &HandLandmarks,
    side: Side,
    pinhole: &Pinhole,
    length: f64,
    before: Option<&HandFrame>,
) -> Result<HandFrame, HandsError> {
    let shape = HandShape::average(length);
    let Some(sight) = sight(seen, side, pinhole) else { return Ok(HandFrame::invalid()) };
    let found = hypotheses(&shape, &sight)?;
    let mirror = if side == Side::Right { -1.0 } else { 1.0 };
    let least = found.iter().map(|found| found.cost).fold(f64::INFINITY, f64::min);
    // Which way the palm is turned is what a single frame tells worst.
    let away = |pose: &HandPose| {
        let Some(before) = before.filter(|before| before.is_valid()) else { return 0.0 };
        let posed = joints(&shape, pose);
        let at = |joint: usize| {
            let mut turned = posed[joint] - posed[0];
            turned.x *= mirror;
            turned - (before.joints[joint].xyz - before.joints[0].xyz)
        };
        (1..posed.len()).map(|joint| at(joint).norm_squared()).sum::<f64>()
    };
    let likely = found.into_iter().filter(|found| found.cost <= AS_GOOD * least + 1.0);
    let pose = likely.min_by(|a, b| away(&a.pose).total_cmp(&away(&b.pose))).map(|found| found.pose);
    let landmarks = PerSide::from_fn(|of| (of == side).then(|| seen.clone()));
    let fitted = FittedSide { shape, poses: vec![pose], sigma: sight.sigma };
    let (mut frames, _) = to_frames(&vec![landmarks], side, pinhole, fitted);
    Ok(frames.pop().unwrap_or_else(HandFrame::invalid))
}

/// How long a hand is, in metres from wrist to middle tip: as `track` knows it, else as hands usually are.
pub fn length_of(track: Option<&HandTrack>, side: Side) -> f64 {
    let known = track.and_then(|track| track.hand_length[side]);
    known.unwrap_or_else(|| 1e-3 * FitParams::default().hand_length_mm)
}

/// A cost of this many times the least may be the right one's.
const AS_GOOD: f64 = 1.5;

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::{
        geometry::{Pixel, Position, Size},
        hands::fit::priors::usual_angles,
        landmarks::KEYPOINT_COUNT,
    };

    fn camera() -> Pinhole {
        Pinhole { fx: 500.0, fy: 500.0, cx: 320.0, cy: 240.0, size: Size::new(640, 480) }
    }

    fn seen(bend: f64) -> [Pixel; KEYPOINT_COUNT] {
        let mut angles = usual_angles();
        angles[6] += bend;
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 1.9);
        let pose = HandPose { wrist: Vector3::new(0.0, 0.05, 0.5), rotation, angles };
        let joints = joints(&HandShape::average(0.187), &pose);
        joints.map(|joint| camera().project(&Position::new(joint)).unwrap())
    }

    #[test]
    fn the_fit_of_a_frame_follows_a_finger_and_stays_where_the_hand_is() {
        let fit = |keypoints, before: Option<&HandFrame>| {
            let hand = HandLandmarks { keypoints, world: None, confidence: 1.0 };
            fit_frame(&hand, Side::Left, &camera(), 0.187, before).unwrap()
        };
        let straight = fit(seen(0.0), None);
        assert!(straight.is_valid() && (straight.wrist().xyz.z - 0.5).abs() < 0.03, "{:?}", straight.wrist());
        let bent = fit(seen(0.8), Some(&straight));
        let moved = |joint: usize| (bent.joints[joint].xyz - straight.joints[joint].xyz).norm();
        assert!(moved(8) > 0.02 && moved(20) < 0.01, "index {} little {}", moved(8), moved(20));
        let nothing = fit([Pixel::default(); KEYPOINT_COUNT], None);
        assert!(!nothing.is_valid());
    }
}
