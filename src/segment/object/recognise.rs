//! The object told from an arm by its own picture.
//!
//! Colour histograms cannot tell a wooden block from the hand that holds it. A placed keyframe can: it says what
//! colour the object has at every single place.

use nalgebra::Matrix3;
use opencv::{core::MatTraitConstManual, imgproc};

use super::{
    evidence::Evidence,
    keyframe::Keyframe,
    shape::byte_mat,
    view::{Roi, View, arm},
};
use crate::vision::{COLOUR_BIN_VOLUME, ColourModel, Plane, binary};

/// Placed pixels without any arm near them that are enough to know light and noise.
const ENOUGH: usize = 40;
/// Standard deviation of Lab differences between keyframe and view, levels: at least and at most.
const NOISE: (f32, f32) = (3.0, 8.0);
/// How much a lightness difference counts against a difference in a or b: light changes as a thing turns.
const LIGHTNESS: f32 = 0.6;
/// Width over which differences are averaged, pixels: one place may look alike by chance.
const WINDOW: f64 = 1.5;
/// How far beside its place a part may be seen, pixels: a solid thing that turns is not quite flat.
const PLAY: i64 = 2;
/// Differences beyond so many standard deviations count no more.
const FARTHEST: f32 = 5.0;
/// What a difference to something unknown counts, standard deviations.
const UNKNOWN: f32 = 3.0;
/// Log-odds against an arm from which a pixel is claimed for the object, and the most that a claim counts.
const CLAIM: (f32, f32) = (0.5, 4.0);
/// Radius of a disc that fits into claimed parts, work pixels: along the outline of a finger, everything is alike.
const LEAST: i32 = 3;
/// Likelihood of a colour that arms were never seen to have.
const STRANGE: f32 = 1.2e-5;

/// The keyframe as it is placed on a rectangle of a view.
pub(super) struct Known<'a> {
    pub key: &'a Keyframe,
    /// The view that `key` was cut from.
    pub witness: &'a View,
    pub transform: &'a Matrix3<f64>,
    /// The keyframe's shape there, 0 to 1.
    pub placed: &'a Plane,
}

/// Lowers the odds of an arm where the view shows just what the placed keyframe has there.
pub(super) fn recognise(
    known: &Known<'_>,
    view: &View,
    roi: &Roi,
    arm_colours: Option<&ColourModel>,
    evidence: &mut Evidence,
) -> opencv::Result<()> {
    let seen = roi.crop(&view.lab, view.width);
    let classes = roi.crop(&view.arms, view.width);
    let may_be_arm = |at: usize| known.placed.data[at] > 0.5 && classes[at] != arm::NONE;
    if !(0..roi.area()).any(may_be_arm) {
        return Ok(());
    }
    let (squares, noise) = differences(known, &seen, &classes, roi)?;
    // A normal distribution over three Lab values.
    let peak = -1.5 * (2.0 * std::f32::consts::PI).ln() - 3.0 * noise.ln();
    let claims: Vec<f32> = (0..roi.area())
        .map(|at| {
            if !may_be_arm(at) {
                return 0.0;
            }
            let alike = peak - 0.5 * squares.data[at] / (noise * noise);
            let skin = arm_colours.map_or(STRANGE, |model| model.likelihood(seen[at]).max(STRANGE));
            (alike - (skin / COLOUR_BIN_VOLUME).ln()).clamp(0.0, CLAIM.1)
        })
        .collect();
    let claimed: Vec<u8> = claims.iter().map(|claim| u8::from(*claim > CLAIM.0)).collect();
    let solid = binary::opened(&byte_mat(&claimed, roi.width, roi.height)?, LEAST)?;
    for ((arm, claim), solid) in evidence.arm.iter_mut().zip(claims).zip(solid.data_bytes()?) {
        if *solid != 0 {
            *arm -= claim;
        }
    }
    Ok(())
}

/// Mean squared Lab differences between what is known and what is seen around every pixel, at the best place near by,
/// and the standard deviation of one Lab value.
fn differences(
    known: &Known<'_>,
    seen: &[[u8; 3]],
    classes: &[u8],
    roi: &Roi,
) -> opencv::Result<(Plane, f32)> {
    let Known { key, witness, transform, placed } = known;
    let carried = key.carry(&key.roi.crop_mat(&witness.rgb)?, transform, roi)?;
    let mut lab = opencv::core::Mat::default();
    imgproc::cvt_color(&carried, &mut lab, imgproc::COLOR_RGB2Lab, 0)?;
    let lab = lab.data_bytes()?.as_chunks::<3>().0;
    let inside: Vec<usize> = (0..roi.area()).filter(|at| placed.data[*at] > 0.9).collect();
    let free: Vec<usize> = inside.iter().copied().filter(|at| classes[*at] == arm::NONE).collect();
    let light = light(lab, seen, &free);
    let noise = noise(free.iter().map(|at| difference(lab[*at], seen[*at], light)).collect());
    let (farthest, unknown) = ((FARTHEST * noise).powi(2), (UNKNOWN * noise).powi(2));
    let mut best = Plane::from_fn(roi.width, roi.height, |_, _| f32::MAX);
    for shift in (0..9).map(|at| (PLAY * (at % 3 - 1), PLAY * (at / 3 - 1))) {
        let mut squares = Plane::from_fn(roi.width, roi.height, |_, _| unknown);
        for at in &inside {
            let (x, y) = ((at % roi.width) as i64 + shift.0, (at / roi.width) as i64 + shift.1);
            if !(0..roi.width as i64).contains(&x) || !(0..roi.height as i64).contains(&y) {
                continue;
            }
            let from = y as usize * roi.width + x as usize;
            if placed.data[from] > 0.9 {
                squares.data[*at] = difference(lab[from], seen[*at], light).min(farthest);
            }
        }
        for (best, here) in best.data.iter_mut().zip(&squares.blurred(WINDOW)?.data) {
            *best = best.min(*here);
        }
    }
    Ok((best, noise))
}

/// How much lighter the object is seen than it is known; 1 where too little of it is surely seen.
fn light(known: &[[u8; 3]], seen: &[[u8; 3]], free: &[usize]) -> f32 {
    // Of black there is no ratio.
    let ratio = |at: &usize| (f32::from(seen[*at][0]) + 4.0) / (f32::from(known[*at][0]) + 4.0);
    if free.len() < ENOUGH { 1.0 } else { median(free.iter().map(ratio).collect()) }
}

fn difference(known: [u8; 3], seen: [u8; 3], light: f32) -> f32 {
    let lightness = LIGHTNESS * (f32::from(seen[0]) - light * f32::from(known[0]));
    let chroma = |k: usize| f32::from(seen[k]) - f32::from(known[k]);
    lightness.powi(2) + chroma(1).powi(2) + chroma(2).powi(2)
}

/// The standard deviation of one Lab value, from squared differences of three.
fn noise(squares: Vec<f32>) -> f32 {
    // The median of a sum of three unit squares is 2.4.
    if squares.len() < ENOUGH { NOISE.1 } else { (median(squares) / 2.4).sqrt().clamp(NOISE.0, NOISE.1) }
}

/// The median of at least one value.
fn median(mut values: Vec<f32>) -> f32 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use opencv::core::{Mat, MatTraitManual};

    use super::*;
    use crate::vision::ColourModel;

    const SIDE: usize = 64;

    /// Boards of one skin-like colour in two lights, the light ones 16 pixels wide; grey beside 16..48.
    fn wood(x: usize, y: usize) -> [u8; 3] {
        if !(16..48).contains(&x) || !(16..48).contains(&y) {
            [90, 90, 90]
        } else if (y / 8).is_multiple_of(2) {
            [205, 150, 120]
        } else {
            [150, 100, 75]
        }
    }

    fn view(colour: impl Fn(usize, usize) -> [u8; 3], class: impl Fn(usize, usize) -> u8) -> View {
        let at = |index: usize| (index % SIDE, index / SIDE);
        let mut rgb = Mat::default();
        let zero = byte_mat(&vec![0; SIDE * SIDE], SIDE, SIDE).unwrap();
        imgproc::cvt_color(&zero, &mut rgb, imgproc::COLOR_GRAY2RGB, 0).unwrap();
        for (index, bytes) in rgb.data_bytes_mut().unwrap().chunks_exact_mut(3).enumerate() {
            bytes.copy_from_slice(&colour(at(index).0, at(index).1));
        }
        let (mut gray, mut lab) = (Mat::default(), Mat::default());
        imgproc::cvt_color(&rgb, &mut gray, imgproc::COLOR_RGB2GRAY, 0).unwrap();
        imgproc::cvt_color(&rgb, &mut lab, imgproc::COLOR_RGB2Lab, 0).unwrap();
        View {
            width: SIDE,
            height: SIDE,
            gray_plane: Plane::from_mat(&gray).unwrap(),
            lab: lab.data_bytes().unwrap().as_chunks::<3>().0.to_vec(),
            rgb,
            gray,
            arms: (0..SIDE * SIDE).map(|index| class(at(index).0, at(index).1)).collect(),
        }
    }

    #[test]
    fn an_arm_mask_over_the_object_itself_is_refuted_and_a_hand_of_its_colours_is_not() {
        let shape: Vec<u8> = (0..SIDE * SIDE)
            .map(|at| u8::from((16..48).contains(&(at % SIDE)) && (16..48).contains(&(at / SIDE))))
            .collect();
        let witness = view(wood, |_, _| arm::NONE);
        let key = Keyframe::new(&witness, &shape).unwrap().unwrap();
        // The mask claims the lower half of the boards, but only from column 32 on is there a hand.
        let is_hand = |x: usize, y: usize| x >= 32 && y >= 32;
        let now = view(
            |x, y| if is_hand(x, y) { [178, 126, 98] } else { wood(x, y) },
            |_, y| if y >= 32 { arm::MASK } else { arm::NONE },
        );
        let skin = (0..SIDE * SIDE).filter(|at| is_hand(at % SIDE, at / SIDE)).map(|at| (now.lab[at], 1.0));
        let boards = shape.iter().zip(&witness.lab).filter(|(s, _)| **s != 0).map(|(_, lab)| (*lab, 1.0));
        let colours = ColourModel::learn(skin.chain(boards)).unwrap();
        let roi = Roi { x: 0, y: 0, width: SIDE, height: SIDE };
        let placed = key.place(&Matrix3::identity(), &roi).unwrap();
        let mut evidence = Evidence { object: vec![0.0; SIDE * SIDE], arm: vec![1.5; SIDE * SIDE] };
        let known = Known { key: &key, witness: &witness, transform: &Matrix3::identity(), placed: &placed };
        recognise(&known, &now, &roi, Some(&colours), &mut evidence).unwrap();
        let at = |x: usize, y: usize| evidence.arm[y * SIDE + x];
        assert!(at(22, 40) < 0.0, "a board under the mask: {}", at(22, 40));
        assert!(at(42, 40) > 1.0, "the hand: {}", at(42, 40));
        assert!(at(5, 40) > 1.0, "beside the object: {}", at(5, 40));
    }
}
