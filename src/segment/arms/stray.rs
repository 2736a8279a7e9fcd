//! Arms that no estimator saw: what has the learned colours and enters over the picture's border.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual};

use crate::vision::binary;

/// P(arm) from which a pixel belongs to an unseen arm.
const SURE: u8 = 190;
/// Mean P(arm) that an unseen arm must have.
const SURE_MEAN: u64 = 225;
/// Border pixels, in palm widths, across which an arm enters.
const ENTRY: f64 = 0.35;
/// Its least area in squared palm widths.
const LEAST_AREA: f64 = 0.35;

/// Components of sure pixels (`likely`: P(arm), CV_8UC1) that touch the border widely enough to be arms.
pub(super) fn at_border(likely: &Mat, palm_width: f64) -> opencv::Result<Mat> {
    let sure = binary::map2(likely, likely, |p, _| if p > SURE { 255 } else { 0 })?;
    let sure = binary::opened(&sure, 1)?;
    let (found, labels) = binary::components(&sure)?;
    let (rows, cols) = (likely.rows() as usize, likely.cols() as usize);
    let mut sums = vec![0_u64; found.len() + 1];
    let mut entry = vec![0_u32; found.len() + 1];
    for (position, (label, p)) in labels.iter().zip(likely.data_bytes()?).enumerate() {
        let (x, y) = (position % cols, position / cols);
        sums[*label as usize] += u64::from(*p);
        entry[*label as usize] += u32::from(x == 0 || y == 0 || x + 1 == cols || y + 1 == rows);
    }
    let is_arm = |component: &binary::Component| {
        let label = component.label as usize;
        f64::from(component.area) >= LEAST_AREA * palm_width * palm_width
            && f64::from(entry[label]) >= ENTRY * palm_width
            && sums[label] >= SURE_MEAN * component.area as u64
    };
    let keep: Vec<bool> = std::iter::once(false).chain(found.iter().map(is_arm)).collect();
    binary::by_label(&sure, &labels, &keep)
}

#[cfg(test)]
mod tests {
    use opencv::{
        core::{Rect, Scalar},
        imgproc,
    };

    use super::*;

    fn with_rectangle(x: i32, y: i32, width: i32, height: i32) -> Mat {
        let mut likely = binary::empty(120, 160).unwrap();
        let area = Rect::new(x, y, width, height);
        imgproc::rectangle(&mut likely, area, Scalar::all(240.0), -1, imgproc::LINE_8, 0).unwrap();
        likely
    }

    #[test]
    fn an_arm_that_enters_over_the_border_is_found_without_landmarks() {
        let found = at_border(&with_rectangle(60, 80, 25, 40), 25.0).unwrap();
        assert!(binary::area(&found).unwrap() > 900);
    }

    #[test]
    fn arm_coloured_things_inside_the_picture_or_thin_at_its_border_are_left_alone() {
        let inside = at_border(&with_rectangle(60, 40, 25, 40), 25.0).unwrap();
        let thin = at_border(&with_rectangle(60, 80, 5, 40), 25.0).unwrap();
        assert_eq!((binary::area(&inside).unwrap(), binary::area(&thin).unwrap()), (0, 0));
    }
}
