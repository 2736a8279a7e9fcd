//! Parts of an arm that vanish for a few frames and come back.

use opencv::core::{Mat, MatTraitConst};
use rayon::prelude::*;

use super::{decode, encode};
use crate::{
    segment::{RleMask, SegmentError},
    vision::binary,
};

/// Frames on either side within which a part must be seen for its absence to be a mistake.
const REACH: usize = 4;
/// Radius, work pixels, below which a vanished part is taken for a moving outline.
const LEAST_RADIUS: i32 = 4;
/// Share of the frame's mask that a vanished part must have.
const LEAST_SHARE: f64 = 0.08;

/// Work masks with parts put back that are there shortly before and shortly after.
///
/// A finger or an edge that moves is left alone: only what is thick and large counts.
pub(super) fn closed(masks: &[RleMask]) -> Result<Vec<RleMask>, SegmentError> {
    (0..masks.len()).into_par_iter().map(|index| closed_at(masks, index)).collect()
}

fn closed_at(masks: &[RleMask], index: usize) -> Result<RleMask, SegmentError> {
    let own = decode(&masks[index])?;
    let before = any(&own, &masks[index.saturating_sub(REACH)..index])?;
    let after = any(&own, &masks[index + 1..(index + 1 + REACH).min(masks.len())])?;
    let both = binary::map2(&before, &after, |a, b| a & b)?;
    let gone = binary::map2(&both, &own, |both, own| both & !own)?;
    let thick = binary::opened(&gone, LEAST_RADIUS)?;
    let least = (LEAST_SHARE * binary::area(&both)? as f64) as i32;
    let (found, labels) = binary::components(&thick)?;
    let large: Vec<bool> =
        std::iter::once(false).chain(found.iter().map(|component| component.area >= least.max(1))).collect();
    if !large.contains(&true) {
        return Ok(masks[index].clone());
    }
    // The opening rounded the part's outline off: give it back.
    let kept = binary::dilated(&binary::by_label(&thick, &labels, &large)?, LEAST_RADIUS)?;
    let back = binary::map2(&kept, &gone, |kept, gone| kept & gone)?;
    Ok(encode(&binary::map2(&own, &back, |own, back| own | back)?)?)
}

fn any(like: &Mat, masks: &[RleMask]) -> Result<Mat, SegmentError> {
    let mut all = binary::empty(like.rows(), like.cols())?;
    for mask in masks {
        all = binary::map2(&all, &decode(mask)?, |a, b| a | b)?;
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::Size, image::Mask};

    fn arm(long: bool) -> RleMask {
        let inside = |x: u32, y: u32| (40..70).contains(&x) && y > if long { 40 } else { 90 };
        RleMask::encode(&Mask::from_fn(Size::new(120, 120), inside))
    }

    #[test]
    fn a_forearm_that_is_lost_for_three_frames_is_put_back() {
        let masks = [true, true, false, false, false, true, true].map(arm);
        let closed = closed(&masks).unwrap();
        for mask in &closed {
            assert!(mask.decode().iou(&arm(true).decode()) > 0.97);
        }
    }

    #[test]
    fn an_arm_that_leaves_for_good_is_not_held_back() {
        let masks = [true, true, true, false, false, false, false].map(arm);
        assert_eq!(closed(&masks).unwrap(), masks);
    }
}
