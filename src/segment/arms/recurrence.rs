//! Background that has the arm's colours: what shows the very same texture at times between which every hand
//! has moved away cannot be an arm, whatever its colour.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual};

use super::{
    plate::DOUBTFUL,
    texture::{Likeness, Texture},
};
use crate::{
    geometry::{PerSide, Pixel, Side},
    vision::{binary, box_blurred},
};

/// In a sample: an arm's colour where an arm may be, which is no proof.
pub(super) const SUSPECT: u8 = 200;
/// Palm widths that every hand has to move for two frames to be witnesses apart.
const MOVED: f64 = 1.5;
/// Frames that have to lie between two of which one may have missed a hand.
const LATER: usize = 30;
/// Lab distance up to which two frames show the same colour.
const SAME_COLOUR: i32 = 10;
/// Lab distance up to which two places without texture look alike.
const SAME_FLAT: i32 = 5;
/// Frames that must agree with a sample.
const WITNESSES: usize = 2;
/// In an agreement of two frames: the same texture, or alike without any.
const AGREES: u8 = 255;
const ALIKE: u8 = 1;

/// A key frame as the frame sees it for which a plate is drawn.
pub(super) struct Sample {
    /// Its frame.
    pub index: usize,
    /// CV_8UC3.
    pub lab: Mat,
    /// What is not to be used of it.
    pub hidden: Mat,
    /// Where its hands are; `None` when one may have been missed.
    pub wrists: Option<PerSide<Option<Pixel>>>,
}

impl Sample {
    /// Up to which grade places of both frames are witnesses; `None` when the frames are not apart. Where hands are
    /// known, every one must have moved; where one may have been missed, time has passed and no place counts that
    /// has an arm's colour.
    fn witnesses_up_to(&self, other: &Self, palm_width: f64) -> Option<u8> {
        let (Some(mine), Some(theirs)) = (&self.wrists, &other.wrists) else {
            return (self.index.abs_diff(other.index) > LATER).then_some(DOUBTFUL);
        };
        let moved = |side: &Side| match (mine[*side], theirs[*side]) {
            (Some(a), Some(b)) => a.distance(b) > MOVED * palm_width,
            (None, None) => true,
            _ => false,
        };
        Side::BOTH.iter().all(moved).then_some(SUSPECT)
    }
}

/// For every pixel, the sample that most others confirm as background; `usize::MAX` where too few do, and no
/// entry at all where no two samples are witnesses apart.
pub(super) fn recurring(samples: &[Sample], palm_width: f64) -> opencv::Result<Vec<usize>> {
    let Some(first) = samples.first() else { return Ok(Vec::new()) };
    let area = first.lab.total();
    let mut witnesses: Vec<Vec<u8>> = vec![Vec::new(); samples.len()];
    for (a, one) in samples.iter().enumerate() {
        for (b, other) in samples.iter().enumerate().skip(a + 1) {
            let Some(grade) = one.witnesses_up_to(other, palm_width) else { continue };
            let agreed = agreement(one, other, grade)?;
            for sample in [a, b] {
                witnesses[sample].resize(area, 0);
                for (count, agreed) in witnesses[sample].iter_mut().zip(agreed.data_bytes()?) {
                    *count += u8::from(*agreed != 0);
                }
            }
        }
    }
    if witnesses.iter().all(Vec::is_empty) {
        return Ok(Vec::new());
    }
    let best = |position: usize| {
        let counts = witnesses.iter().map(|counts| usize::from(counts.get(position).copied().unwrap_or(0)));
        // The first of the most confirmed.
        let (count, sample) =
            counts.zip(0..).fold((0, usize::MAX), |best, next| if next.0 > best.0 { next } else { best });
        if count >= WITNESSES { sample } else { usize::MAX }
    };
    Ok((0..area).map(best).collect())
}

/// Where two samples of at most `grade` show the same place, CV_8UC1: by texture, or without any amid what agrees.
fn agreement(one: &Sample, other: &Sample, grade: u8) -> opencv::Result<Mat> {
    let cols = one.lab.cols() as usize;
    let alike = Likeness::of(&one.lab, &other.lab)?;
    let (first, second) =
        (one.lab.data_bytes()?.as_chunks::<3>().0, other.lab.data_bytes()?.as_chunks::<3>().0);
    let hidden = binary::map2(&one.hidden, &other.hidden, u8::max)?;
    let hidden = hidden.data_bytes()?;
    let judge = |position: usize| {
        if hidden[position] > SUSPECT {
            return 0;
        }
        let (a, b) = (first[position], second[position]);
        let squared: i32 = (0..3).map(|c| (i32::from(a[c]) - i32::from(b[c])).pow(2)).sum();
        match alike.at(position % cols, position / cols) {
            Texture::Same if squared <= SAME_COLOUR * SAME_COLOUR && hidden[position] <= grade => AGREES,
            Texture::Same if squared <= SAME_COLOUR * SAME_COLOUR => ALIKE,
            Texture::Flat if squared <= SAME_FLAT * SAME_FLAT => ALIKE,
            _ => 0,
        }
    };
    let raw: Vec<u8> = (0..first.len()).map(judge).collect();
    let raw = Mat::new_rows_cols_with_data(one.lab.rows(), one.lab.cols(), &raw)?.try_clone()?;
    // The inside of a forearm is as flat as a table: plain places need textured ones around.
    let textured = binary::map2(&raw, &raw, |value, _| if value == AGREES { 255 } else { 0 })?;
    let textured = box_blurred(&textured, 17)?;
    binary::map2(&raw, &textured, |value, around| match value {
        AGREES => 255,
        ALIKE if around > 76 => 255,
        _ => 0,
    })
}

#[cfg(test)]
mod tests {
    use opencv::core::{CV_8UC3, MatTraitManual, Scalar};

    use super::*;

    const SIDE: usize = 64;

    /// Stripes, a plain square of the stripes' brightness on them at `square`, one hand at `wrist`.
    fn sample(index: usize, wrist: Option<f64>, square: Option<usize>, grade: u8) -> Sample {
        let side = SIDE as i32;
        let mut lab = Mat::new_rows_cols_with_default(side, side, CV_8UC3, Scalar::all(128.0)).unwrap();
        for (at, pixel) in lab.data_bytes_mut().unwrap().as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let (x, y) = (at % SIDE, at / SIDE);
            let inside = square.is_some_and(|left| (left..left + 20).contains(&x) && (20..40).contains(&y));
            pixel[0] = if inside { 120 } else { 100 + 40 * u8::from((x / 4) % 2 == 0) };
        }
        let empty = binary::empty(side, side).unwrap();
        let hidden = binary::map2(&empty, &empty, |_, _| grade).unwrap();
        let wrist = wrist.map(|x| Pixel::new(x, 30.0));
        Sample { index, lab, hidden, wrists: wrist.map(|wrist| PerSide { left: None, right: Some(wrist) }) }
    }

    fn known(samples: &[Sample]) -> usize {
        recurring(samples, 10.0).unwrap().iter().filter(|sample| **sample != usize::MAX).count()
    }

    #[test]
    fn texture_that_stays_while_the_hand_moves_is_background_whatever_its_colour() {
        let samples: Vec<Sample> =
            (0..4).map(|i| sample(30 * i, Some(20.0 * i as f64), Some(11 * i), SUSPECT)).collect();
        let found = recurring(&samples, 10.0).unwrap();
        assert_ne!(found[5 * SIDE + 30], usize::MAX, "stripes");
        let under_the_first_square = found[30 * SIDE + 2];
        assert!((1..4).contains(&under_the_first_square), "{under_the_first_square}");
    }

    #[test]
    fn a_hand_that_rests_proves_nothing() {
        let samples: Vec<Sample> = (0..4).map(|i| sample(30 * i, Some(20.0), Some(20), SUSPECT)).collect();
        assert_eq!(known(&samples), 0);
    }

    #[test]
    fn where_a_hand_was_missed_arm_colours_prove_nothing_and_others_do() {
        let samples = |grade| -> Vec<Sample> { (0..4).map(|i| sample(40 * i, None, None, grade)).collect() };
        assert_eq!(known(&samples(SUSPECT)), 0);
        assert!(known(&samples(DOUBTFUL)) > SIDE * SIDE / 2);
    }
}
