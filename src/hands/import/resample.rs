//! From rows at their own rate to the frames of a clip.

use super::{Joints, RawTrack};
use crate::{
    geometry::{PerSide, Pinhole, Pixel, Position, Side},
    hands::{HandFrame, HandState, HandTrack},
    landmarks::KEYPOINT_COUNT,
};

/// A row this near in time, as a share of the row interval, is the frame's own.
const OWN: f64 = 0.75;

pub(super) fn to_track(
    raw: &RawTrack,
    fps: f64,
    times: &[f64],
    pinhole: &Pinhole,
    longest_bridge_s: f64,
) -> HandTrack {
    let mut hands = PerSide::from_fn(|_| Vec::with_capacity(times.len()));
    let mut hand_length = PerSide::default();
    let start = times.first().copied().unwrap_or(0.0);
    for side in Side::BOTH {
        let rows = raw.hands[side].as_deref().unwrap_or(&[]);
        hand_length[side] = length(rows);
        let known: Vec<(f64, &Joints)> = rows
            .iter()
            .enumerate()
            .filter_map(|(row, joints)| joints.as_ref().map(|j| (start + row as f64 / fps, j)))
            .collect();
        for time in times {
            hands[side].push(at(&known, *time, fps, pinhole, longest_bridge_s));
        }
    }
    HandTrack { hands, hand_length, backend: "import".to_owned() }
}

fn at(known: &[(f64, &Joints)], time: f64, fps: f64, pinhole: &Pinhole, longest_bridge_s: f64) -> HandFrame {
    let after = known.partition_point(|(t, _)| *t <= time);
    let (before, next) = (after.checked_sub(1).map(|i| known[i]), known.get(after).copied());
    let near = |t: f64| (t - time).abs() * fps <= OWN;
    let (joints, bridged) = match (before, next) {
        (Some((t0, a)), Some((t1, b))) if (t1 - t0) * fps <= 1.5 || t1 - t0 <= longest_bridge_s => {
            let share = (time - t0) / (t1 - t0);
            let joints: Joints = std::array::from_fn(|k| a[k].lerp(&b[k], share));
            (joints, !near(t0) && !near(t1))
        }
        (Some((t0, a)), _) if near(t0) => (*a, false),
        (_, Some((t1, b))) if near(t1) => (*b, false),
        _ => return HandFrame::invalid(),
    };
    let joints = joints.map(Position::new);
    let projected: Option<Vec<Pixel>> = joints.iter().map(|j| pinhole.project(j)).collect();
    let keypoints: Option<[Pixel; KEYPOINT_COUNT]> = projected.and_then(|p| p.try_into().ok());
    let Some(keypoints) = keypoints else { return HandFrame::invalid() };
    let (state, confidence) = if bridged { (HandState::Bridged, 0.5) } else { (HandState::Observed, 1.0) };
    HandFrame { state, confidence, keypoints, joints, mano: None }
}

/// Median length from wrist to middle tip along the bones, metres.
fn length(rows: &[Option<Joints>]) -> Option<f64> {
    let path = [0, 9, 10, 11, 12];
    let along = |j: &Joints| path.windows(2).map(|w| (j[w[1]] - j[w[0]]).norm()).sum::<f64>();
    let mut lengths: Vec<f64> = rows.iter().flatten().map(along).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.get(lengths.len() / 2).copied()
}
