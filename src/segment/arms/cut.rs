//! The mask of one frame from skeletons, colour and change.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual};

use super::{params::ArmParams, plate::UNKNOWN, shape::HandShape, sleeve, work_frame::WorkFrame};
use crate::vision::{binary, grab_cut};

/// What speaks for arm on a frame.
#[derive(Debug)]
pub(super) struct Evidence<'a> {
    /// Hands with how far their forearm may reach, pixels.
    pub hands: &'a [(HandShape, f64)],
    /// P(arm | colour), 0 to 255.
    pub posterior: &'a Mat,
    /// Lab distance from the background plate, where there is one.
    pub change: Option<&'a Mat>,
    /// A neighbour's mask carried here along the flow.
    pub prior: Option<&'a Mat>,
    /// Typical palm width, pixels, for scales where no hand is seen.
    pub palm_width: f64,
}

/// Regions that follow from the evidence before any cut.
struct Regions {
    core: Mat,
    cone: Mat,
    allowed: Mat,
}

fn regions(frame: &WorkFrame, evidence: &Evidence<'_>) -> opencv::Result<Regions> {
    let (rows, cols) = (frame.grey.rows(), frame.grey.cols());
    let mut core = binary::empty(rows, cols)?;
    let mut hulls = binary::empty(rows, cols)?;
    let mut cone = binary::empty(rows, cols)?;
    for (hand, reach) in evidence.hands {
        hand.draw_core(&mut core, 0.2)?;
        hand.draw_hull(&mut hulls, 0.4)?;
        hand.draw_cone(&mut cone, 80.0, *reach)?;
    }
    let mut allowed = binary::map2(&hulls, &cone, |a, b| a | b)?;
    if let Some(prior) = evidence.prior {
        let radius = (0.12 * evidence.palm_width).round().clamp(2.0, 9.0) as i32;
        let certain = binary::eroded(prior, radius)?;
        // What no longer looks like arm was uncovered, not carried along.
        let certain = binary::map2(&certain, evidence.posterior, |c, p| if p > 64 { c } else { 0 })?;
        core = binary::map2(&core, &certain, |a, b| a | b)?;
        let near = binary::dilated(prior, radius + 1)?;
        allowed = binary::map2(&allowed, &near, |a, b| a | b)?;
    }
    Ok(Regions { core, cone, allowed })
}

fn candidates(evidence: &Evidence<'_>, regions: &Regions, params: &ArmParams) -> opencv::Result<Mat> {
    let mut likely = binary::empty(regions.core.rows(), regions.core.cols())?;
    let colour = (255.0 * params.colour_threshold).round() as u8;
    let change_limit = params.change_threshold.clamp(0.0, 255.0) as u8;
    let still_limit = params.still_threshold.clamp(0.0, 255.0) as u8;
    let posterior = evidence.posterior.data_bytes()?;
    let allowed = regions.allowed.data_bytes()?;
    let change = evidence.change.map(MatTraitConstManual::data_bytes).transpose()?;
    for (index, value) in likely.data_bytes_mut()?.iter_mut().enumerate() {
        let change = change.map_or(UNKNOWN, |change| change[index]);
        let changed = change > change_limit && change != UNKNOWN;
        let coloured = posterior[index] > colour && !(change < still_limit && posterior[index] < 250);
        let likely = coloured || (changed && posterior[index] > 38);
        *value = if allowed[index] != 0 && likely { 255 } else { 0 };
    }
    likely = binary::map2(&likely, &regions.core, |a, b| a | b)?;
    // A watch or a cuff may part the forearm from the hand: bridge it, but only behind the wrist,
    // where no held object can be.
    let bridge = (0.25 * evidence.palm_width).round().clamp(1.0, 12.0) as i32;
    let bridged = binary::closed(&likely, bridge)?;
    let bridged = binary::map2(&bridged, &regions.cone, |a, b| a & b)?;
    likely = binary::map2(&likely, &bridged, |a, b| a | b)?;
    let kept = binary::touching(&binary::opened(&likely, 1)?, &regions.core)?;
    let kept = binary::map2(&kept, &regions.core, |a, b| a | b)?;
    let sleeves = sleeve_pixels(evidence, &kept, 1.0, params)?;
    binary::map2(&kept, &sleeves, |a, b| a | b)
}

/// Where a sleeve must continue the skin, less what is background.
fn sleeve_pixels(evidence: &Evidence<'_>, skin: &Mat, share: f64, params: &ArmParams) -> opencv::Result<Mat> {
    let strip = sleeve::drawn(evidence.hands, skin, share)?;
    let strip = match evidence.change {
        Some(change) => {
            let still = params.still_threshold.clamp(0.0, 255.0) as u8;
            binary::map2(&strip, change, |strip, change| if change < still { 0 } else { strip })?
        }
        None => strip,
    };
    // Only what the background's colours do not explain.
    binary::map2(&strip, evidence.posterior, |strip, p| if p > 20 { strip } else { 0 })
}

/// The middle of the sleeves beside `mask`, to learn their colours from.
pub(super) fn sleeve_to_learn(
    evidence: &Evidence<'_>,
    mask: &Mat,
    params: &ArmParams,
) -> opencv::Result<Mat> {
    let strip = sleeve::drawn(evidence.hands, mask, 0.6)?;
    match evidence.change {
        Some(change) => {
            let still = params.still_threshold.clamp(0.0, 255.0) as u8;
            binary::map2(&strip, change, |strip, change| if change < still { 0 } else { strip })
        }
        None => Ok(strip),
    }
}

/// Candidate components around the skeletons, decided by GrabCut. CV_8UC1 at work size.
pub(super) fn cut_frame(
    frame: &WorkFrame,
    evidence: &Evidence<'_>,
    params: &ArmParams,
) -> opencv::Result<Mat> {
    let regions = regions(frame, evidence)?;
    if binary::area(&regions.core)? == 0 {
        return binary::empty(regions.core.rows(), regions.core.cols());
    }
    let likely = candidates(evidence, &regions, params)?;
    let band = binary::dilated(&likely, (0.2 * evidence.palm_width).round().clamp(3.0, 10.0) as i32)?;
    let mut seeds = binary::map2(&band, &likely, |band, likely| match (band != 0, likely != 0) {
        (_, true) => grab_cut::SEED_PROBABLY_FOREGROUND,
        (true, false) => grab_cut::SEED_PROBABLY_BACKGROUND,
        _ => grab_cut::SEED_BACKGROUND,
    })?;
    for (seed, core) in seeds.data_bytes_mut()?.iter_mut().zip(regions.core.data_bytes()?) {
        if *core != 0 {
            *seed = grab_cut::SEED_FOREGROUND;
        }
    }
    if let Some(change) = evidence.change {
        // What looks exactly like the background behind it is background, whatever its colour.
        let still = (0.5 * params.still_threshold).clamp(0.0, 255.0) as u8;
        for (seed, change) in seeds.data_bytes_mut()?.iter_mut().zip(change.data_bytes()?) {
            if *seed == grab_cut::SEED_PROBABLY_BACKGROUND && *change < still {
                *seed = grab_cut::SEED_BACKGROUND;
            }
        }
    }
    let cut = grab_cut::grab_cut(&frame.lab, &seeds, params.cut_iterations, 6)?;
    let cut = binary::touching(&cut, &regions.core)?;
    let cut = binary::closed(&cut, 2)?;
    let largest_hole = (0.06 * evidence.palm_width * evidence.palm_width) as i32;
    binary::small_holes_filled(&cut, largest_hole.max(4))
}
