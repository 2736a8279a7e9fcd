//! Things that were pushed or carried away between two frames, known by their colours.
//!
//! A board that is pushed under the hand leaves samples of itself where the hand hides the ground now. Around
//! the hole one sees what became of pixels of each colour: colours that mostly turned into something
//! else belong to what moved, or to skin that no mask covered, and are no background.

use opencv::{
    core::{CV_32F, Mat, MatTrait, MatTraitConst, MatTraitConstManual, Scalar, Vec3b},
    imgproc,
};

use crate::vision::{View, box_blurred};

/// Levels of a channel that count as one colour, as a power of two.
const SHIFT: usize = 5;
const SIDE: usize = 256 >> SHIFT;
/// How far around the hole colours are compared, as a share of the width.
const NEAR: f64 = 0.12;
/// Pixels of a colour that say something about it.
const ENOUGH: u32 = 30;
/// Share of a colour's pixels that changed, from which on it is not trusted.
const MOSTLY: f32 = 0.35;

/// Which colours of a source frame are still where they were in the target.
#[derive(Clone, Debug)]
pub(super) struct MovedColours {
    moved: Vec<bool>,
}

impl MovedColours {
    /// Compares `source` (CV_8UC3, registered with `target`, its colours already alike) where `valid` (CV_8UC1,
    /// 255) shows background in both, in the surroundings of what `target` does not show; differences of more
    /// than `limit` levels that no shadow explains are change.
    pub fn between(target: &View, source: &Mat, valid: &Mat, limit: f32) -> opencv::Result<Self> {
        let near = (NEAR * f64::from(source.cols())) as f32;
        let mut distance = Mat::default();
        if opencv::core::count_non_zero(&target.valid)? as usize == target.valid.total() {
            return Ok(Self { moved: vec![false; SIDE * SIDE * SIDE] });
        }
        imgproc::distance_transform(
            &target.valid,
            &mut distance,
            imgproc::DIST_L2,
            imgproc::DIST_MASK_3,
            CV_32F,
        )?;
        let distance = distance.data_typed::<f32>()?;
        // Registration misses edges by a pixel: only what is still different after smoothing changed.
        let (a, b) = (box_blurred(&target.colour, 5)?, box_blurred(source, 5)?);
        let (a, b) = (a.data_typed::<Vec3b>()?, b.data_typed::<Vec3b>()?);
        let own = source.data_typed::<Vec3b>()?;
        let mut counts = vec![(0_u32, 0_u32); SIDE * SIDE * SIDE];
        for (i, _) in valid
            .data_typed::<u8>()?
            .iter()
            .enumerate()
            .filter(|(i, valid)| **valid != 0 && distance[*i] < near)
        {
            let (all, changed) = &mut counts[bin(own[i].0)];
            *all += 1;
            *changed += u32::from(differs(a[i].0, b[i].0, limit));
        }
        let moved =
            counts.iter().map(|(all, changed)| *all >= ENOUGH && *changed as f32 > MOSTLY * *all as f32);
        Ok(Self { moved: moved.collect() })
    }

    /// Whether `colour` mostly belongs to what moved.
    pub fn contains(&self, colour: [u8; 3]) -> bool {
        self.moved[bin(colour)]
    }

    /// Clears `known` (CV_8UC1) where `picture` (CV_8UC3) mostly has such colours around.
    pub fn take_out(&self, picture: &Mat, known: &mut Mat) -> opencv::Result<()> {
        if !self.moved.contains(&true) {
            return Ok(());
        }
        let colours = picture.data_typed::<Vec3b>()?.iter();
        let inside: Vec<u8> = colours.map(|colour| if self.contains(colour.0) { 255 } else { 0 }).collect();
        let inside = Mat::new_rows_cols_with_data(picture.rows(), picture.cols(), &inside)?;
        let share = box_blurred(&inside, (picture.cols() / 40) | 1)?;
        let mut mostly = Mat::default();
        opencv::core::compare(&share, &Scalar::all(127.0), &mut mostly, opencv::core::CMP_GT)?;
        known.set_to(&Scalar::all(0.0), &mostly)?;
        Ok(())
    }
}

/// How much neighbours within one segment may differ, levels of a channel.
const SMOOTH: u8 = 5;
/// How much any pixel of a segment may differ from where it began.
const ALIKE: u8 = 24;
/// Pixels that must contradict before a segment is taken for moved.
const CONTRADICTING: u32 = 12;

/// CV_8UC1: 255 on pieces of `source` (CV_8UC3, registered with `target`, its colours already alike) that are not
/// there in `target`: connected pieces of one colour whose pixels, where `valid` (CV_8UC1, 255) shows background in
/// both, mostly differ by more than `limit` levels. What one sees of a thing tells of the rest of it, which is
/// hidden.
pub(super) fn moved_pieces(target: &View, source: &Mat, valid: &Mat, limit: f32) -> opencv::Result<Mat> {
    let (a, b) = (box_blurred(&target.colour, 3)?, box_blurred(source, 3)?);
    let (a, b) = (a.data_typed::<Vec3b>()?, b.data_typed::<Vec3b>()?);
    let valid = valid.data_typed::<u8>()?;
    let mut moved = vec![0_u8; a.len()];
    let mut visited = vec![false; a.len()];
    let mut piece = Vec::new();
    for seed in 0..a.len() {
        if visited[seed] {
            continue;
        }
        grow_piece(seed, b, source.cols() as usize, &mut visited, &mut piece);
        let seen = piece.iter().filter(|at| valid[**at] != 0);
        let (all, contradicting) = seen.fold((0_u32, 0_u32), |(all, contradicting), at| {
            (all + 1, contradicting + u32::from(differs(a[*at].0, b[*at].0, limit)))
        });
        if contradicting >= CONTRADICTING && 2 * contradicting > all {
            for at in &piece {
                moved[*at] = 255;
            }
        }
    }
    let moved = Mat::new_rows_cols_with_data(source.rows(), source.cols(), &moved)?.try_clone()?;
    super::hole::grown(&moved, 1)
}

/// The connected pixels of `colours` (rows of `columns`) that are of one colour with `seed` and not `visited`.
fn grow_piece(seed: usize, colours: &[Vec3b], columns: usize, visited: &mut [bool], piece: &mut Vec<usize>) {
    let alike = |a: usize, b: usize, tolerance: u8| {
        colours[a].0.iter().zip(colours[b].0).all(|(p, q)| p.abs_diff(q) <= tolerance)
    };
    piece.clear();
    piece.push(seed);
    visited[seed] = true;
    let mut next = 0;
    while let Some(at) = piece.get(next).copied() {
        next += 1;
        let x = at % columns;
        let around = [
            (x > 0).then(|| at - 1),
            (x + 1 < columns).then_some(at + 1),
            at.checked_sub(columns),
            Some(at + columns).filter(|below| *below < colours.len()),
        ];
        for other in around.into_iter().flatten() {
            if !visited[other] && alike(other, at, SMOOTH) && alike(other, seed, ALIKE) {
                visited[other] = true;
                piece.push(other);
            }
        }
    }
}

fn bin(colour: [u8; 3]) -> usize {
    colour.iter().fold(0, |at, value| at * SIDE + usize::from(*value >> SHIFT))
}

/// Whether two colours differ by more than light.
pub(super) fn differs(a: [u8; 3], b: [u8; 3], limit: f32) -> bool {
    let (a, b) = (a.map(f32::from), b.map(f32::from));
    let scale = (a.iter().sum::<f32>() / b.iter().sum::<f32>().max(1.0)).clamp(0.4, 2.5);
    a.iter().zip(b).any(|(a, b)| (a - scale * b).abs() > limit * scale.max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::Size,
        image::{Mask, Rgb8},
        vision::WorkScale,
    };

    const SIZE: Size = Size::new(160, 120);

    /// A yellow board with its left edge at `left` on dark ground.
    fn board(left: u32) -> Mat {
        let mut picture = Rgb8::from_data(SIZE, [40, 42, 45].repeat(SIZE.area())).unwrap();
        for (x, y) in (20..100).flat_map(|y| (left..left + 50).map(move |x| (x, y))) {
            picture.set_pixel(x, y, [230, 210, 150]);
        }
        picture.to_mat().unwrap()
    }

    fn moved(from: u32, to: u32) -> MovedColours {
        let hand = Mask::from_fn(SIZE, |x, y| (70..90).contains(&x) && y > 60).to_mat().unwrap();
        let target = View::new(WorkScale { full: SIZE, work: SIZE }, &board(to), &hand).unwrap();
        MovedColours::between(&target, &board(from), &target.valid, 24.0).unwrap()
    }

    #[test]
    fn the_colour_of_a_board_that_was_pushed_away_is_no_background_and_the_ground_is() {
        let pushed = moved(55, 95);
        assert!(pushed.contains([230, 210, 150]) && !pushed.contains([40, 42, 45]));
        assert!(!moved(55, 55).contains([230, 210, 150]));
    }

    #[test]
    fn what_moved_is_taken_out_of_what_is_known() {
        let mut known = Mask::from_fn(SIZE, |_, _| true).to_mat().unwrap();
        moved(55, 95).take_out(&board(55), &mut known).unwrap();
        assert_eq!(*known.at_2d::<u8>(50, 80).unwrap(), 0);
        assert_eq!(*known.at_2d::<u8>(50, 20).unwrap(), 255);
    }

    #[test]
    fn the_hidden_part_of_a_thing_is_gone_with_what_one_sees_of_it() {
        let hand = Mask::from_fn(SIZE, |x, y| (70..110).contains(&x) && y > 60).to_mat().unwrap();
        let target = View::new(WorkScale { full: SIZE, work: SIZE }, &board(110), &hand).unwrap();
        let pieces = moved_pieces(&target, &board(40), &target.valid, 24.0).unwrap();
        assert_eq!(*pieces.at_2d::<u8>(80, 80).unwrap(), 255, "the board's hidden part");
        assert_eq!(*pieces.at_2d::<u8>(80, 100).unwrap(), 0, "the ground's");
    }
}
