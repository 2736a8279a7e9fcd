//! Where a sleeve continues a forearm whose skin ends before the picture does.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, Point, Scalar},
    imgproc,
};

use super::shape::HandShape;
use crate::{geometry::Pixel, vision::binary};

/// Sleeves lead downwards or sideways: in first-person views no arm enters from above.
const HIGHEST: f64 = -0.35;

/// A strip of the picture from where the skin ends to the picture's border.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sleeve {
    from: Pixel,
    to: Pixel,
    width: f64,
}

impl Sleeve {
    /// Draws the strip's middle, `share` of its width.
    pub fn draw(&self, mask: &mut Mat, share: f64) -> opencv::Result<()> {
        let rounded = |p: Pixel| Point::new(p.x.round() as i32, p.y.round() as i32);
        let thickness = (share * self.width).round().clamp(1.0, 250.0) as i32;
        let white = Scalar::all(255.0);
        imgproc::line(mask, rounded(self.from), rounded(self.to), white, thickness, imgproc::LINE_8, 0)
    }
}

/// The likely pixels across the forearm at one place.
struct Section {
    middle: Pixel,
    width: f64,
}

/// Walks along the forearm over `skin` (CV_8UC1) from the wrist until the skin ends, and reaches
/// on from there. `None` where the skin itself runs out of the picture, or no arm leads anywhere.
pub(super) fn beyond_skin(hand: &HandShape, skin: &Mat) -> opencv::Result<Option<Sleeve>> {
    let (width, height) = (f64::from(skin.cols()), f64::from(skin.rows()));
    let inside = |p: Pixel| p.x >= 0.0 && p.y >= 0.0 && p.x < width && p.y < height;
    let bytes = skin.data_bytes()?;
    let is_skin = |p: Pixel| inside(p) && bytes[p.y as usize * skin.cols() as usize + p.x as usize] != 0;
    let step = (0.2 * hand.palm_width).max(2.0);
    let mut direction = hand.towards_arm;
    let mut path = vec![hand.wrist()];
    let (mut widths, mut missed) = (vec![hand.palm_width], 0);
    while missed < 2 {
        let here = path[path.len() - 1];
        let ahead = Pixel::new(
            here.x + f64::from(missed + 1) * step * direction.x,
            here.y + f64::from(missed + 1) * step * direction.y,
        );
        if !inside(ahead) {
            return Ok(None);
        }
        match section(ahead, direction, hand.palm_width, &is_skin) {
            Some(section) => {
                missed = 0;
                path.push(section.middle);
                widths.push(section.width);
                let back = path[path.len().saturating_sub(6)];
                let length = section.middle.distance(back);
                if length > 1.5 * step {
                    let along = Pixel::new(
                        (section.middle.x - back.x) / length,
                        (section.middle.y - back.y) / length,
                    );
                    direction = turned(direction, along);
                }
            }
            None => missed += 1,
        }
        if path.len() > 200 {
            return Ok(None);
        }
    }
    let from = path[path.len() - 1];
    let direction = settled_direction(&path).unwrap_or(direction);
    if direction.y < HIGHEST {
        return Ok(None);
    }
    let reach = width + height;
    let to = Pixel::new(from.x + reach * direction.x, from.y + reach * direction.y);
    widths.sort_unstable_by(f64::total_cmp);
    let width = widths[widths.len() / 2].clamp(0.6 * hand.palm_width, 1.3 * hand.palm_width);
    Ok(Some(Sleeve { from, to, width }))
}

/// The way the forearm runs without its last sections: where the skin ends raggedly, a section that lies
/// askew sees one side alone, and its middle points off the arm.
fn settled_direction(path: &[Pixel]) -> Option<Pixel> {
    let end = path.len().checked_sub(3)?;
    let (near, far) = (path[end.checked_sub(6)?], path[end]);
    let length = far.distance(near);
    (length > 0.0).then(|| Pixel::new((far.x - near.x) / length, (far.y - near.y) / length))
}

/// Half way from `direction` to `along`, both unit vectors.
fn turned(direction: Pixel, along: Pixel) -> Pixel {
    let (x, y) = (direction.x + along.x, direction.y + along.y);
    let length = x.hypot(y);
    if length < 0.5 { direction } else { Pixel::new(x / length, y / length) }
}

fn section(
    at: Pixel,
    direction: Pixel,
    palm_width: f64,
    is_skin: &impl Fn(Pixel) -> bool,
) -> Option<Section> {
    let across = |offset: f64| Pixel::new(at.x - offset * direction.y, at.y + offset * direction.x);
    let half = (1.2 * palm_width).round() as i32;
    let search = (0.6 * palm_width).round() as i32;
    let start = (0..=search).flat_map(|o| [o, -o]).find(|o| is_skin(across(f64::from(*o))))?;
    let run = |sign: i32| {
        (1..=half).take_while(|o| is_skin(across(f64::from(start + sign * o)))).last().unwrap_or(0)
    };
    let (more, less) = (run(1), run(-1));
    let width = f64::from(more + less + 1);
    (width >= 0.25 * palm_width)
        .then(|| Section { middle: across(f64::from(start) + 0.5 * f64::from(more - less)), width })
}

/// The strips of all hands, `share` of their widths. CV_8UC1.
pub(super) fn drawn(hands: &[(HandShape, f64)], skin: &Mat, share: f64) -> opencv::Result<Mat> {
    let mut mask = binary::empty(skin.rows(), skin.cols())?;
    let diagonal = f64::from(skin.cols()).hypot(f64::from(skin.rows()));
    for (hand, reach) in hands {
        // Where forearms end in the picture, there is an elbow and a person behind it, no border.
        if *reach < 0.99 * diagonal {
            continue;
        }
        if let Some(sleeve) = beyond_skin(hand, skin)? {
            sleeve.draw(&mut mask, share)?;
        }
    }
    Ok(mask)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::Size,
        landmarks::{HandLandmarks, KEYPOINT_COUNT},
        vision::WorkScale,
    };

    /// A hand of 20 pixels' palm width at (80, 40) that points up, its wrist at the bottom.
    fn hand() -> HandShape {
        let mut keypoints = [Pixel::new(80.0, 30.0); KEYPOINT_COUNT];
        keypoints[0] = Pixel::new(80.0, 60.0);
        for (finger, x) in [(5, 70.0), (9, 77.0), (13, 84.0), (17, 90.0)] {
            for joint in 0..4 {
                keypoints[finger + joint] = Pixel::new(x, 40.0 - 7.0 * joint as f64);
            }
        }
        let landmarks = HandLandmarks { keypoints, world: None, confidence: 1.0 };
        HandShape::new(&landmarks, &WorkScale::fit(Size::new(160, 160), 160)).unwrap()
    }

    fn skin_down_to(row: i32) -> Mat {
        let mut skin = binary::empty(160, 160).unwrap();
        let forearm = opencv::core::Rect::new(72, 30, 16, row - 30);
        imgproc::rectangle(&mut skin, forearm, Scalar::all(255.0), -1, imgproc::LINE_8, 0).unwrap();
        skin
    }

    #[test]
    fn a_sleeve_continues_the_skin_to_the_border() {
        let strip = drawn(&[(hand(), 230.0)], &skin_down_to(100), 1.0).unwrap();
        let at = |x: i32, y: i32| *strip.at_2d::<u8>(y, x).unwrap();
        assert_eq!((at(80, 120), at(80, 155)), (255, 255));
        assert_eq!((at(30, 120), at(80, 50)), (0, 0));
    }

    #[test]
    fn bare_arms_and_arms_that_end_in_the_picture_have_no_sleeve() {
        let bare = drawn(&[(hand(), 230.0)], &skin_down_to(160), 1.0).unwrap();
        assert_eq!(binary::area(&bare).unwrap(), 0);
        let from_outside = drawn(&[(hand(), 60.0)], &skin_down_to(100), 1.0).unwrap();
        assert_eq!(binary::area(&from_outside).unwrap(), 0);
    }
}
