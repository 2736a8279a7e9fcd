//! Masks through landmark drop-outs, carried along the flow.

use opencv::core::{Mat, MatTraitConstManual};

use super::{
    cut::{Evidence, cut_frame},
    params::ArmParams,
    plate::NEUTRAL,
    work_frame::WorkFrame,
};
use crate::vision::{FlowQuality, binary, dense_flow};

/// The previous frame (in the direction of travel) and its mask.
pub(super) struct Carried {
    pub frame: WorkFrame,
    pub mask: Mat,
}

/// Carries `from.mask` to the neighbouring frame `to` and cuts it anew there. `None` where too
/// little is left to be believed: the arm has left the picture or was lost.
pub(super) fn carry(
    from: &Carried,
    to: &WorkFrame,
    posterior: &Mat,
    change: Option<&Mat>,
    palm_width: f64,
    params: &ArmParams,
) -> opencv::Result<Option<Mat>> {
    let flow = dense_flow(&to.grey, &from.frame.grey, FlowQuality::Fast)?;
    let soft = flow.pull(&from.mask)?;
    let prior = binary::map2(&soft, &soft, |value, _| if value > 127 { 255 } else { 0 })?;
    let prior_area = binary::area(&prior)?;
    let smallest = (0.1 * palm_width * palm_width).max(12.0) as usize;
    if prior_area < smallest || mean_inside(posterior, &prior)? < 70.0 {
        return Ok(None);
    }
    // Without landmarks, standing still is no proof of being background.
    let change = change.map(|c| binary::map2(c, c, |c, _| c.max(NEUTRAL))).transpose()?;
    let change = change.as_ref();
    let evidence = Evidence { hands: &[], posterior, change, prior: Some(&prior), palm_width };
    let cut = cut_frame(to, &evidence, params)?;
    let believed = if binary::iou(&cut, &prior)? > 0.5 { cut } else { prior };
    Ok((binary::area(&believed)? >= smallest).then_some(believed))
}

/// The mean of `values` inside `mask`.
pub(super) fn mean_inside(values: &Mat, mask: &Mat) -> opencv::Result<f64> {
    let (mut sum, mut count) = (0.0, 0_usize);
    for (value, mask) in values.data_bytes()?.iter().zip(mask.data_bytes()?) {
        if *mask != 0 {
            sum += f64::from(*value);
            count += 1;
        }
    }
    Ok(if count == 0 { 0.0 } else { sum / count as f64 })
}
