//! Holes of a plate, closed one after the other.

use opencv::{
    core::{
        CV_32S, Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Point, Rect, Scalar, Size as CvSize,
        Vec3b,
    },
    imgproc::{
        CC_STAT_AREA, CC_STAT_HEIGHT, CC_STAT_LEFT, CC_STAT_TOP, CC_STAT_WIDTH, MORPH_RECT,
        connected_components_with_stats, dilate, get_structuring_element, morphology_default_border_value,
    },
};

use super::net::ImageNetwork;
use crate::inpaint::{
    InpaintError,
    plate::{SYNTHESISED, UNKNOWN},
};

/// Holes nearer to each other than this, pixels, are closed together.
const TOGETHER: i32 = 8;
/// Holes smaller than this are closed as well without a network, pixels.
const SMALL: i32 = 64;
/// Holes of one plate that a network is asked for, the largest first.
const MOST: usize = 6;
/// How much of a picture beside the hole the network is shown, as a share of the hole's longer side.
const SURROUNDINGS: f64 = 0.5;

/// Makes up what is unknown inside `needed` of a plate: colours of `picture` (CV_8UC3) and what `origin` (CV_8UC1) says of
/// them change there alone. Small holes stay unknown.
///
/// # Errors
/// When OpenCV or the network fails.
pub(in crate::inpaint) fn fill_by_network(
    picture: &mut Mat,
    origin: &mut Mat,
    needed: &Mat,
    network: &mut ImageNetwork,
) -> Result<(), InpaintError> {
    let (mut unknown, mut wanted) = (Mat::default(), Mat::default());
    let nothing = Scalar::all(f64::from(UNKNOWN));
    opencv::core::compare(origin, &nothing, &mut unknown, opencv::core::CMP_EQ)?;
    opencv::core::bitwise_and_def(&unknown, needed, &mut wanted)?;
    for hole in holes(&wanted)? {
        let part = surroundings(hole, network.side() as i32, picture.cols(), picture.rows());
        let shown = Mat::roi(picture, part)?.try_clone()?;
        let hidden = Mat::roi(&unknown, part)?.try_clone()?;
        let restored = network.restored(&shown, &hidden)?;
        let columns = picture.cols() as usize;
        let made = restored.data_typed::<Vec3b>()?;
        let wanted = wanted.data_typed::<u8>()?;
        let (to, kinds) = (picture.data_typed_mut::<Vec3b>()?, origin.data_typed_mut::<u8>()?);
        for y in hole.y..hole.y + hole.height {
            for x in hole.x..hole.x + hole.width {
                let at = y as usize * columns + x as usize;
                if wanted[at] != 0 && kinds[at] == UNKNOWN {
                    to[at] = made[((y - part.y) * part.width + x - part.x) as usize];
                    kinds[at] = SYNTHESISED;
                }
            }
        }
    }
    Ok(())
}

/// Boxes around the holes of a mask, the largest first.
fn holes(mask: &Mat) -> opencv::Result<Vec<Rect>> {
    let reach = 2 * (TOGETHER / 2) + 1;
    let kernel = get_structuring_element(MORPH_RECT, CvSize::new(reach, reach), Point::new(-1, -1))?;
    let (mut wide, mut labels, mut stats, mut centres) =
        (Mat::default(), Mat::default(), Mat::default(), Mat::default());
    let beyond = morphology_default_border_value()?;
    dilate(mask, &mut wide, &kernel, Point::new(-1, -1), 1, opencv::core::BORDER_CONSTANT, beyond)?;
    let count = connected_components_with_stats(&wide, &mut labels, &mut stats, &mut centres, 8, CV_32S)?;
    let mut found = Vec::new();
    for label in 1..count {
        let of = |what: i32| stats.at_2d::<i32>(label, what).copied();
        let around = Rect::new(of(CC_STAT_LEFT)?, of(CC_STAT_TOP)?, of(CC_STAT_WIDTH)?, of(CC_STAT_HEIGHT)?);
        let area = opencv::core::count_non_zero(&Mat::roi(mask, around)?)?;
        if area >= SMALL {
            found.push((of(CC_STAT_AREA)?, around));
        }
    }
    found.sort_by_key(|(area, around)| (std::cmp::Reverse(*area), around.y, around.x));
    Ok(found.into_iter().take(MOST).map(|(_, around)| around).collect())
}

/// A square around a hole, as large as the network's picture or the hole with its surroundings, inside the picture.
fn surroundings(hole: Rect, side: i32, columns: i32, rows: i32) -> Rect {
    let longer = f64::from(hole.width.max(hole.height));
    let side = side.max((longer * (1.0 + 2.0 * SURROUNDINGS)).ceil() as i32);
    let (width, height) = (side.min(columns), side.min(rows));
    let place =
        |from: i32, length: i32, size: i32, most: i32| (from + (length - size) / 2).clamp(0, most - size);
    Rect::new(
        place(hole.x, hole.width, width, columns),
        place(hole.y, hole.height, height, rows),
        width,
        height,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hole_is_shown_with_its_surroundings_and_inside_the_picture() {
        let hole = Rect::new(600, 10, 40, 20);
        assert_eq!(surroundings(hole, 512, 800, 600), Rect::new(288, 0, 512, 512));
        assert_eq!(surroundings(hole, 64, 800, 600), Rect::new(580, 0, 80, 80));
        assert_eq!(surroundings(hole, 512, 700, 300), Rect::new(188, 0, 512, 300));
    }
}
