//! Fills landmark drop-outs: each side's mask is carried into its gaps from both ends.

use opencv::core::{Mat, MatTraitConst};
use rayon::prelude::*;

use super::{
    Clip, WorkMasks,
    carry::{Carried, carry},
    decode, encode,
    work_frame::WorkFrame,
};
use crate::{
    clip::FrameIndex,
    geometry::{PerSide, Side},
    segment::{RleMask, SegmentError},
    vision::binary,
};

/// A chain of frames without landmarks of one side, walked away from an anchor.
struct Chain {
    side: Side,
    anchor: usize,
    steps: Vec<usize>,
}

/// Frames to either side among which a mask must not be much the smallest.
const NEIGHBOURHOOD: usize = 8;

/// Which masks are no less than their neighbours: a sudden loss of a forearm is a drop-out too.
fn whole_masks(own: &[Option<RleMask>]) -> Vec<bool> {
    let areas: Vec<u64> = own.iter().map(|mask| mask.as_ref().map_or(0, RleMask::area)).collect();
    let is_whole = |index: usize| {
        let near = index.saturating_sub(NEIGHBOURHOOD)..(index + NEIGHBOURHOOD + 1).min(areas.len());
        let mut around: Vec<u64> = areas[near].iter().copied().filter(|area| *area > 0).collect();
        around.sort_unstable();
        let median = around.get(around.len() / 2).copied().unwrap_or(0);
        own[index].is_some() && 100 * areas[index] >= 85 * median
    };
    (0..own.len()).map(is_whole).collect()
}

fn chains(clip: &Clip<'_>, own: &[Option<RleMask>]) -> Vec<Chain> {
    let (count, longest) = (clip.count(), clip.params.longest_dropout);
    let whole = whole_masks(own);
    let mut found = Vec::new();
    for side in Side::BOTH {
        let is_known = |index: usize| whole[index] && clip.sides[index][side].is_some();
        for anchor in (0..count).filter(|index| is_known(*index)) {
            let forward: Vec<usize> =
                (anchor + 1..count).take(longest).take_while(|i| !is_known(*i)).collect();
            let backward: Vec<usize> =
                (0..anchor).rev().take(longest).take_while(|i| !is_known(*i)).collect();
            for steps in [forward, backward].into_iter().filter(|steps| !steps.is_empty()) {
                found.push(Chain { side, anchor, steps });
            }
        }
    }
    found
}

/// The part of `mask` that lies nearer to this side's hand than to the other's.
pub(super) fn side_part(
    mask: &Mat,
    hands: &PerSide<Option<super::shape::HandShape>>,
    side: Side,
) -> opencv::Result<Mat> {
    let (Some(mine), Some(other)) = (&hands[side], &hands[side.other()]) else {
        return if hands[side].is_some() {
            mask.try_clone()
        } else {
            binary::empty(mask.rows(), mask.cols())
        };
    };
    super::shape::nearer(mask, &mine.distances(mask)?, &other.distances(mask)?)
}

fn walk(
    clip: &Clip<'_>,
    table: &[u8],
    own: &[Option<RleMask>],
    chain: &Chain,
) -> Result<Vec<(usize, usize, RleMask)>, SegmentError> {
    let Some(anchor) = &own[chain.anchor] else { return Ok(Vec::new()) };
    let mask = side_part(&decode(anchor)?, &clip.sides[chain.anchor], chain.side)?;
    let (frame, _) = WorkFrame::read(clip.frames, FrameIndex(chain.anchor as u32), &clip.scale)?;
    let mut from = Carried { frame, mask };
    let mut carried = Vec::new();
    for (distance, index) in chain.steps.iter().enumerate() {
        clip.watch.check()?;
        let (to, _) = WorkFrame::read(clip.frames, FrameIndex(*index as u32), &clip.scale)?;
        let change = clip.change(*index, &to)?;
        let posterior = to.posterior(table)?;
        let mask = carry(&from, &to, &posterior, change.as_ref(), clip.palm_width, clip.params)?;
        let Some(mask) = mask else { break };
        carried.push((*index, distance + 1, encode(&mask)?));
        from = Carried { frame: to, mask };
    }
    Ok(carried)
}

/// The masks of all frames, each side's gaps filled from the nearer end.
pub(super) fn bridged(
    clip: &Clip<'_>,
    table: &[u8],
    own: Vec<Option<RleMask>>,
) -> Result<Vec<WorkMasks>, SegmentError> {
    let chains = chains(clip, &own);
    let walked = chains
        .par_iter()
        .map(|chain| Ok((chain.side, walk(clip, table, &own, chain)?)))
        .collect::<Result<Vec<_>, SegmentError>>()?;
    let mut masks: Vec<WorkMasks> =
        own.into_iter().map(|own| WorkMasks { own, ..WorkMasks::default() }).collect();
    let mut nearest: PerSide<Vec<usize>> = PerSide::from_fn(|_| vec![usize::MAX; masks.len()]);
    for (side, steps) in walked {
        for (index, distance, mask) in steps {
            if distance < nearest[side][index] {
                nearest[side][index] = distance;
                masks[index].carried[side] = Some(mask);
                masks[index].distance = masks[index].distance.max(distance);
            }
        }
    }
    Ok(masks)
}
