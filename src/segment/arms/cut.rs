//! The mask of one frame from skeletons, colour and change.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual},
    imgproc,
};

use super::{params::ArmParams, plate::UNKNOWN, shape::HandShape, sleeve, work_frame::WorkFrame};
use crate::vision::{binary, grab_cut};

/// P(arm | colour) as skeletons taught it, below which a colour in a grip belongs to what is held.
const STRANGE: u8 = 30;

/// P(arm | colour) by skeletons and far background up to which a colour is the background's beyond doubt.
pub(super) const SURELY_BACKGROUND: u8 = 3;
/// Palm width, pixels, below which every pixel is cut: small hands cost little and have none to spare.
const SMALL_PALM: f64 = 20.0;
/// P(arm) from which a pixel right behind a wrist is a candidate.
const EXPECTED: u8 = 95;
/// Mean P(arm) in a larger hole from which it is filled.
const HOLE_LIKELY: f64 = 60.0;

/// What speaks for arm on a frame.
#[derive(Debug)]
pub(super) struct Evidence<'a> {
    /// Hands with how far their forearm may reach, pixels.
    pub hands: &'a [(HandShape, f64)],
    /// P(arm | colour), 0 to 255.
    pub colour: &'a Mat,
    /// P(arm | colour, change), 0 to 255.
    pub likely: &'a Mat,
    /// Lab distance from the background plate, where there is one.
    pub change: Option<&'a Mat>,
    /// Where neighbouring frames say that arms are.
    pub prior: Option<&'a Mat>,
    /// Pixels of the colours of the object that is handled: skeletons are drawn across it.
    pub object: Option<&'a Mat>,
    /// P(arm | colour), 0 to 255, as the skeletons alone taught it: what lies in front of the wrist and has
    /// another colour is held, not grown.
    pub skin: &'a Mat,
    /// Whether forearms leave the picture: then they are expected to go on.
    pub leaves_picture: bool,
    /// Typical palm width, pixels, for scales where no hand is seen.
    pub palm_width: f64,
}

/// Regions that follow from the evidence before any cut.
struct Regions {
    core: Mat,
    cone: Mat,
    allowed: Mat,
    /// Around the fingers, in front of the wrist.
    grip: Mat,
}

/// Around the fingers, in front of the wrist: what is new here is held.
pub(super) fn grip(hands: &[(HandShape, f64)], like: &Mat) -> opencv::Result<Mat> {
    let (mut hulls, mut cone) =
        (binary::empty(like.rows(), like.cols())?, binary::empty(like.rows(), like.cols())?);
    for (hand, reach) in hands {
        hand.draw_hull(&mut hulls, 0.8)?;
        hand.draw_cone(&mut cone, 80.0, *reach)?;
    }
    binary::map2(&hulls, &cone, |hull, cone| if cone == 0 { hull } else { 0 })
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
    if let Some(object) = evidence.object {
        core = binary::map2(&core, object, |core, object| core & !object)?;
    }
    let mut allowed = binary::map2(&hulls, &cone, |a, b| a | b)?;
    if let Some(prior) = evidence.prior {
        let radius = (0.12 * evidence.palm_width).round().clamp(2.0, 9.0) as i32;
        let certain = binary::eroded(prior, radius)?;
        // What no longer looks like arm was uncovered, not carried along.
        let certain = binary::map2(&certain, evidence.likely, |c, p| if p > 64 { c } else { 0 })?;
        core = binary::map2(&core, &certain, |a, b| a | b)?;
        let near = binary::dilated(prior, radius + 1)?;
        allowed = binary::map2(&allowed, &near, |a, b| a | b)?;
    }
    let grip = grip(evidence.hands, &core)?;
    Ok(Regions { core, cone, allowed, grip })
}

/// What is held, by its colour: in front of the wrist, and of no colour that skeletons have.
fn held(evidence: &Evidence<'_>, regions: &Regions) -> opencv::Result<Mat> {
    let strange =
        binary::map2(evidence.skin, &regions.core, |p, core| if p < STRANGE && core == 0 { 255 } else { 0 })?;
    let strange = match evidence.object {
        Some(object) => binary::map2(&strange, object, |a, b| a | b)?,
        None => strange,
    };
    let strange = binary::map2(&strange, &regions.grip, |a, b| a & b)?;
    // Nails, rings and creases are no objects.
    let least = (0.08 * evidence.palm_width).round().clamp(1.0, 4.0) as i32;
    binary::opened(&strange, least)
}

fn candidates(
    evidence: &Evidence<'_>,
    regions: &Regions,
    held: &Mat,
    params: &ArmParams,
) -> opencv::Result<Mat> {
    let threshold = (255.0 * params.threshold).round() as u8;
    let mut likely =
        binary::map2(
            &regions.allowed,
            evidence.likely,
            |allowed, p| if p > threshold { allowed } else { 0 },
        )?;
    // Right behind the wrist a forearm is to be expected.
    let mut expected = binary::empty(likely.rows(), likely.cols())?;
    for (hand, reach) in evidence.hands.iter().filter(|_| evidence.leaves_picture) {
        hand.draw_cone(&mut expected, 35.0, *reach)?;
    }
    let expected =
        binary::map2(&expected, evidence.likely, |expected, p| if p > EXPECTED { expected } else { 0 })?;
    likely = binary::map2(&likely, &expected, |a, b| a | b)?;
    likely = binary::map2(&likely, &regions.core, |a, b| a | b)?;
    likely = binary::map2(&likely, held, |a, b| a & !b)?;
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

/// Whether a place has surely changed against the background behind it.
pub(super) fn has_changed(change: u8) -> bool {
    change > 40 && change != UNKNOWN
}

/// Where a sleeve must continue the skin, less what is background: what has not changed, and what background
/// colours explain without a change.
fn sleeve_pixels(evidence: &Evidence<'_>, skin: &Mat, share: f64, params: &ArmParams) -> opencv::Result<Mat> {
    let mut strip = sleeve::drawn(evidence.hands, skin, share)?;
    let changes = evidence.change.map(MatTraitConstManual::data_bytes).transpose()?;
    let colours = evidence.colour.data_bytes()?.iter().zip(evidence.skin.data_bytes()?);
    for (position, (pixel, (colour, skin))) in strip.data_bytes_mut()?.iter_mut().zip(colours).enumerate() {
        let change = changes.map_or(UNKNOWN, |changes| changes[position]);
        let is_strange = *colour > 20 && *skin > SURELY_BACKGROUND;
        if f64::from(change) < params.still_threshold || !(is_strange || has_changed(change)) {
            *pixel = 0;
        }
    }
    Ok(strip)
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

/// Candidate components around the skeletons, their edges decided by GrabCut. CV_8UC1 at work size.
pub(super) fn cut_frame(
    frame: &WorkFrame,
    evidence: &Evidence<'_>,
    params: &ArmParams,
) -> opencv::Result<Mat> {
    let regions = regions(frame, evidence)?;
    if binary::area(&regions.core)? == 0 {
        return binary::empty(regions.core.rows(), regions.core.cols());
    }
    let held = held(evidence, &regions)?;
    let likely = candidates(evidence, &regions, &held, params)?;
    let seeds = seeds(evidence, &regions, &held, &likely, params)?;
    let cut = if evidence.palm_width < SMALL_PALM {
        grab_cut::grab_cut(&frame.lab, &seeds, params.cut_iterations, 6)?
    } else {
        coarse_cut(frame, &seeds, params.cut_iterations)?
    };
    let cut = binary::touching(&cut, &regions.core)?;
    let cut = binary::closed(&cut, 2)?;
    holes_filled(&cut, evidence)
}

/// GrabCut on every other pixel, its edge then drawn along the finer picture's.
fn coarse_cut(frame: &WorkFrame, seeds: &Mat, iterations: i32) -> opencv::Result<Mat> {
    let half = opencv::core::Size::new((seeds.cols() + 1) / 2, (seeds.rows() + 1) / 2);
    let (mut lab, mut coarse) = (Mat::default(), Mat::default());
    imgproc::resize(&frame.lab, &mut lab, half, 0.0, 0.0, imgproc::INTER_AREA)?;
    imgproc::resize(seeds, &mut coarse, half, 0.0, 0.0, imgproc::INTER_NEAREST)?;
    let cut = grab_cut::grab_cut(&lab, &coarse, iterations, 3)?;
    let mut large = Mat::default();
    imgproc::resize(&cut, &mut large, seeds.size()?, 0.0, 0.0, imgproc::INTER_LINEAR)?;
    let soft = filtered(&frame.grey, &large, 3, 4e-4)?;
    binary::map2(&soft, seeds, |value, seed| match seed {
        grab_cut::SEED_FOREGROUND => 255,
        grab_cut::SEED_BACKGROUND => 0,
        _ if value > 120 => 255,
        _ => 0,
    })
}

/// Small holes filled, and larger ones that may well be arm: a forearm is solid.
fn holes_filled(cut: &Mat, evidence: &Evidence<'_>) -> opencv::Result<Mat> {
    let square = evidence.palm_width * evidence.palm_width;
    let inverse = binary::map2(cut, cut, |value, _| if value == 0 { 255 } else { 0 })?;
    let (found, labels) = binary::components(&inverse)?;
    let mut sums = vec![0_u64; found.len() + 1];
    for (label, p) in labels.iter().zip(evidence.likely.data_bytes()?) {
        sums[*label as usize] += u64::from(*p);
    }
    let fills = |hole: &binary::Component| {
        let area = f64::from(hole.area);
        let likely = sums[hole.label as usize] as f64 / area;
        area < (0.06 * square).max(4.0) || (area < square && likely > HOLE_LIKELY)
    };
    let fill: Vec<bool> = std::iter::once(false).chain(found.iter().map(fills)).collect();
    let holes = binary::by_label(&inverse, &labels, &fill)?;
    binary::map2(cut, &holes, |a, b| a | b)
}

fn filtered(guide: &Mat, values: &Mat, radius: i32, epsilon: f64) -> opencv::Result<Mat> {
    use opencv::core::{CV_8U, CV_32F};
    let (mut guide_float, mut float, mut out, mut bytes) =
        (Mat::default(), Mat::default(), Mat::default(), Mat::default());
    guide.convert_to(&mut guide_float, CV_32F, 1.0 / 255.0, 0.0)?;
    values.convert_to(&mut float, CV_32F, 1.0 / 255.0, 0.0)?;
    opencv::ximgproc::guided_filter(&guide_float, &float, &mut out, radius, epsilon, -1)?;
    out.convert_to(&mut bytes, CV_8U, 255.0, 0.0)?;
    Ok(bytes)
}

/// GrabCut's seeds.
fn seeds(
    evidence: &Evidence<'_>,
    regions: &Regions,
    held: &Mat,
    likely: &Mat,
    params: &ArmParams,
) -> opencv::Result<Mat> {
    let band = binary::dilated(likely, (0.2 * evidence.palm_width).round().clamp(3.0, 10.0) as i32)?;
    let mut seeds = binary::map2(&band, likely, |band, likely| match (band != 0, likely != 0) {
        (_, true) => grab_cut::SEED_PROBABLY_FOREGROUND,
        (true, false) => grab_cut::SEED_PROBABLY_BACKGROUND,
        _ => grab_cut::SEED_BACKGROUND,
    })?;
    let certain = regions.core.data_bytes()?.iter().zip(held.data_bytes()?);
    for (seed, (core, held)) in seeds.data_bytes_mut()?.iter_mut().zip(certain) {
        if *core != 0 {
            *seed = grab_cut::SEED_FOREGROUND;
        } else if *held != 0 {
            *seed = grab_cut::SEED_BACKGROUND;
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
    Ok(seeds)
}
