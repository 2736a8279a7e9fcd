//! Drawing masks and points over a frame, for the debug videos.

use crate::{
    geometry::Pixel,
    image::{Mask, Rgb8},
};

/// The object, in every debug picture.
pub const OBJECT_COLOUR: [u8; 3] = [40, 220, 90];
/// The left hand and arm.
pub const LEFT_COLOUR: [u8; 3] = [70, 120, 255];
/// The right hand and arm.
pub const RIGHT_COLOUR: [u8; 3] = [255, 70, 60];

/// Fills `mask` with `colour` at `opacity` (0 to 1) and draws its outline opaque, `width` pixels wide.
///
/// A mask of another size than the frame draws nothing.
pub fn draw_mask(frame: &mut Rgb8, mask: &Mask, colour: [u8; 3], opacity: f64, width: u32) {
    let size = frame.size();
    if mask.size() != size {
        return;
    }
    let share = (opacity.clamp(0.0, 1.0) * 256.0) as u32;
    for y in 0..size.height {
        for x in 0..size.width {
            if !mask.get(x, y) {
                continue;
            }
            let share = if is_edge(mask, x, y, width) { 256 } else { share };
            let old = frame.pixel(x, y);
            let blend = |channel: usize| {
                ((u32::from(old[channel]) * (256 - share) + u32::from(colour[channel]) * share) >> 8) as u8
            };
            frame.set_pixel(x, y, [blend(0), blend(1), blend(2)]);
        }
    }
}

/// Whether one of the four neighbours `width` pixels away lies outside; the picture's border is no edge.
fn is_edge(mask: &Mask, x: u32, y: u32, width: u32) -> bool {
    let (right, bottom) = (mask.size().width - 1, mask.size().height - 1);
    !mask.get(x.saturating_sub(width), y)
        || !mask.get(x, y.saturating_sub(width))
        || !mask.get((x + width).min(right), y)
        || !mask.get(x, (y + width).min(bottom))
}

/// Draws a filled disc of `radius` pixels around `centre`; parts beyond the border are left out.
pub fn draw_disc(frame: &mut Rgb8, centre: Pixel, radius: f64, colour: [u8; 3]) {
    let size = frame.size();
    if !(centre.x.is_finite() && centre.y.is_finite() && radius >= 0.0) {
        return;
    }
    // `as` saturates, so far-away centres give empty ranges.
    let range = |middle: f64, end: u32| {
        let start = (middle - radius).ceil().max(0.0) as u32;
        start..((middle + radius).floor() + 1.0).clamp(0.0, f64::from(end)) as u32
    };
    for y in range(centre.y, size.height) {
        for x in range(centre.x, size.width) {
            if Pixel::new(f64::from(x), f64::from(y)).distance(centre) <= radius {
                frame.set_pixel(x, y, colour);
            }
        }
    }
}

/// The mask debug picture: the object green, the left arm blue, the right one red.
///
/// Where one mask holds both arms, pass it as `right` and leave `left` out.
pub fn masks_picture(frame: &Rgb8, object: Option<&Mask>, left: Option<&Mask>, right: Option<&Mask>) -> Rgb8 {
    let mut picture = frame.clone();
    let width = (frame.size().width.max(frame.size().height) / 640).max(1);
    for (mask, colour) in [(left, LEFT_COLOUR), (right, RIGHT_COLOUR), (object, OBJECT_COLOUR)] {
        if let Some(mask) = mask {
            draw_mask(&mut picture, mask, colour, 0.4, width);
        }
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Size;

    #[test]
    fn outline_is_opaque_and_inside_is_tinted() {
        let size = Size::new(9, 9);
        let mask = Mask::from_fn(size, |x, y| (2..7).contains(&x) && (2..7).contains(&y));
        let mut frame = Rgb8::new(size);
        draw_mask(&mut frame, &mask, [200, 100, 0], 0.5, 1);
        assert_eq!(frame.pixel(2, 4), [200, 100, 0]);
        assert_eq!(frame.pixel(4, 4), [100, 50, 0]);
        assert_eq!(frame.pixel(1, 4), [0, 0, 0]);
    }

    #[test]
    fn discs_beyond_the_border_draw_what_is_inside() {
        let mut frame = Rgb8::new(Size::new(5, 5));
        draw_disc(&mut frame, Pixel::new(-1.0, 2.0), 1.5, [9, 9, 9]);
        draw_disc(&mut frame, Pixel::new(1e300, f64::NAN), 1.5, [9, 9, 9]);
        draw_disc(&mut frame, Pixel::new(1e300, -1e300), 1.5, [9, 9, 9]);
        assert_eq!(frame.pixel(0, 2), [9, 9, 9]);
        assert_eq!(frame.pixels().filter(|pixel| **pixel != [0, 0, 0]).count(), 3);
    }
}
