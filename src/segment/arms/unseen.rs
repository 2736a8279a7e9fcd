//! Arms without landmarks whose sleeve nobody has named yet: skin, and what leads from it out of the picture.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual};

use super::{
    Clip,
    cut::{Evidence, has_changed},
    scratch::Towards,
};
use crate::{
    geometry::Pixel,
    segment::SegmentError,
    vision::{BackgroundMotion, binary},
};

/// P(arm) by skeletons and in all from which a pixel is skin that no landmark speaks for.
const SURE: u8 = 190;
/// Least area of such skin, squared palm widths.
const LEAST_SKIN: f64 = 0.35;
/// Share of it, at most, that landmarks explain all the same.
const EXPLAINED: f64 = 0.2;
/// Border pixels, in palm widths, across which an arm enters.
const ENTRY: f64 = 0.35;
/// Pixels, in palm widths, along which a sleeve meets the skin that it covers.
const SEAM: f64 = 0.35;
/// Work pixels a frame by which a place must move against the background to move by itself.
const MOVES: f64 = 0.5;
/// Share of a sleeve that must move.
const MOVING: f64 = 0.5;

/// What nobody's landmarks explain and yet is arm, beside `own`, what they do explain: skin that enters over the
/// picture's border itself or by a sleeve, and those sleeves: what surely differs from the background, moves against
/// it (`moving`), has not the object's colours, and leads from such skin over the border. Empty without a background to compare to.
/// CV_8UC1.
pub(super) fn arms(evidence: &Evidence<'_>, own: &Mat, moving: &Mat) -> opencv::Result<Mat> {
    let Some(change) = evidence.change else { return binary::empty(own.rows(), own.cols()) };
    let palm = evidence.palm_width;
    let least = LEAST_SKIN * palm * palm;
    let skin =
        binary::map2(evidence.skin, evidence.likely, |skin, p| if skin.min(p) > SURE { 255 } else { 0 })?;
    let skin = binary::map2(&skin, change, |skin, change| if has_changed(change) { skin } else { 0 })?;
    let skin = binary::opened(&outside_object(skin, evidence)?, 1)?;
    let unexplained = |part: &Part| part.area >= least && part.marked <= EXPLAINED * part.area;
    let skin = kept(&skin, own, unexplained)?;
    if binary::area(&skin)? == 0 {
        return Ok(skin);
    }
    let known = binary::map2(&skin, own, |a, b| a | b)?;
    let changed = binary::map2(
        change,
        &known,
        |change, known| {
            if has_changed(change) && known == 0 { 255 } else { 0 }
        },
    )?;
    let changed = binary::opened(&outside_object(changed, evidence)?, 1)?;
    let leads = |part: &Part| part.entry >= ENTRY * palm && part.marked >= 2.0 * SEAM * palm;
    let sleeves = kept(&changed, &binary::dilated(&skin, 2)?, leads)?;
    let sleeves = kept(&sleeves, moving, |part| part.marked >= MOVING * part.area)?;
    // The seam itself may be neither.
    let all = binary::closed(&binary::map2(&skin, &sleeves, |a, b| a | b)?, 2)?;
    kept(&all, own, |part| part.area >= least && part.entry >= ENTRY * palm)
}

fn outside_object(mask: Mat, evidence: &Evidence<'_>) -> opencv::Result<Mat> {
    let Some(object) = evidence.object else { return Ok(mask) };
    binary::map2(&mask, &binary::closed(object, 2)?, |mask, object| mask & !object)
}

/// Pixels of a component: all, on the picture's border, and inside a second mask.
struct Part {
    area: f64,
    entry: f64,
    marked: f64,
}

/// The components of `mask` that satisfy `holds`; pixels in `marks` are counted too.
fn kept(mask: &Mat, marks: &Mat, holds: impl Fn(&Part) -> bool) -> opencv::Result<Mat> {
    let (found, labels) = binary::components(mask)?;
    let (rows, cols) = (mask.rows() as usize, mask.cols() as usize);
    let mut counts = vec![(0_u32, 0_u32); found.len() + 1];
    for (position, (label, mark)) in labels.iter().zip(marks.data_bytes()?).enumerate() {
        let (x, y) = (position % cols, position / cols);
        let (entry, marked) = &mut counts[*label as usize];
        *entry += u32::from(x == 0 || y == 0 || x + 1 == cols || y + 1 == rows);
        *marked += u32::from(*mark != 0);
    }
    let keep = |component: &binary::Component| {
        let (entry, marked) = counts[component.label as usize];
        holds(&Part { area: f64::from(component.area), entry: f64::from(entry), marked: f64::from(marked) })
    };
    let keep: Vec<bool> = std::iter::once(false).chain(found.iter().map(keep)).collect();
    binary::by_label(mask, &labels, &keep)
}

/// Where frame `index` moves against the background from or to a neighbour. CV_8UC1, 255.
pub(super) fn moving(clip: &Clip<'_>, index: usize) -> Result<Mat, SegmentError> {
    let mut moves = binary::empty(clip.scale.work.height as i32, clip.scale.work.width as i32)?;
    let Some(plate) = &clip.plate else { return Ok(moves) };
    let neighbours = [(Towards::Before, index.checked_sub(1)), (Towards::After, Some(index + 1))];
    for (towards, other) in neighbours {
        let Some(motion) = other.and_then(|other| plate.between(index, other)) else { continue };
        let motion = BackgroundMotion::known(motion);
        let (flow, cols) = clip.scratch.flow(index, towards)?;
        let stride = crate::segment::arms::scratch::FLOW_STRIDE as usize;
        let width = moves.cols() as usize;
        let far: Vec<bool> = flow
            .iter()
            .enumerate()
            .map(|(cell, vector)| {
                let here = Pixel::new(
                    ((cell % cols) * stride + stride / 2) as f64,
                    ((cell / cols) * stride + stride / 2) as f64,
                );
                let there = motion.apply(here);
                (f64::from(vector[0]) + here.x - there.x).hypot(f64::from(vector[1]) + here.y - there.y)
                    > MOVES
            })
            .collect();
        for (position, moves) in moves.data_bytes_mut()?.iter_mut().enumerate() {
            if far[position / width / stride * cols + position % width / stride] {
                *moves = 255;
            }
        }
    }
    Ok(moves)
}

#[cfg(test)]
mod tests {
    use opencv::{
        core::{Rect, Scalar},
        imgproc,
    };

    use super::*;

    fn with_rectangle(area: Rect, value: f64) -> Mat {
        let mut mask = binary::empty(120, 160).unwrap();
        imgproc::rectangle(&mut mask, area, Scalar::all(value), -1, imgproc::LINE_8, 0).unwrap();
        mask
    }

    /// Pixels found where a forearm without landmarks ends in a sleeve that leaves the picture.
    fn found(sleeve_moves: bool, own: &Mat) -> usize {
        let (arm, sleeve) = (Rect::new(60, 30, 30, 40), Rect::new(58, 70, 34, 50));
        let skin = with_rectangle(arm, 240.0);
        let change = with_rectangle(Rect::new(58, 30, 34, 90), 90.0);
        let evidence = Evidence {
            hands: &[],
            colour: &skin,
            likely: &skin,
            change: Some(&change),
            prior: None,
            object: None,
            skin: &skin,
            leaves_picture: true,
            palm_width: 25.0,
        };
        let moving = with_rectangle(if sleeve_moves { sleeve } else { arm }, 255.0);
        binary::area(&arms(&evidence, own, &moving).unwrap()).unwrap()
    }

    #[test]
    fn skin_without_landmarks_brings_its_sleeve_along_if_that_moves() {
        let nothing = binary::empty(120, 160).unwrap();
        assert!(found(true, &nothing) > 2600);
        assert_eq!(found(false, &nothing), 0);
    }

    #[test]
    fn what_landmarks_explain_is_left_to_them() {
        assert_eq!(found(true, &with_rectangle(Rect::new(60, 30, 30, 40), 255.0)), 0);
    }
}
