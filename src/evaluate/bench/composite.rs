//! The composite against the one that perfect stages would have made.

use super::{BenchError, mean, same_length};
use crate::{
    clip::{FrameIndex, FrameSource},
    composite::order::{self, LayerDecision, OrderParams},
    evaluate::psnr_inside,
    geometry::{PerSide, Side},
    image::{Rgb8, Rgba8},
    render::RobotLayers,
    synth::Episode,
};

/// A frame's PSNR counts up to this many decibels.
const CEILING_DB: f64 = 60.0;

/// The order of hand and object on every frame as true masks, keypoints and contact tell it.
///
/// # Errors
/// When the truth cannot be read or OpenCV fails.
pub fn true_order(episode: &Episode) -> Result<Vec<LayerDecision>, BenchError> {
    let mut seen = Vec::with_capacity(episode.frame_count());
    for index in FrameIndex::all(episode.frame_count()) {
        let (visible, full) = (episode.object_visible(index)?, episode.object_full(index)?);
        let hands = &episode.truth.frames[index.as_usize()].hands;
        let mut sides = PerSide::default();
        for side in Side::BOTH {
            let hand = hands[side].as_ref();
            let keypoints = hand.map(|hand| &hand.keypoints);
            let contact = hand.map(|hand| hand.contact);
            sides[side] = order::evidence(&episode.hand(index, side)?, &visible, &full, keypoints, contact)?;
        }
        seen.push(sides);
    }
    Ok(order::decide(&seen, &[], &OrderParams::default()))
}

/// Background, robot, object, what of the robot lies before it: plain `over` with exact layers.
pub fn ideal_composite(
    background: &Rgb8,
    robot: Option<&RobotLayers>,
    object: &Rgba8,
    order: &LayerDecision,
) -> Rgb8 {
    let mut picture = background.clone();
    let over = |below: &mut [u8; 3], above: &[u8], alpha: f32| {
        for (below, above) in below.iter_mut().zip(above) {
            let mixed = f32::from(*below) * (1.0 - alpha) + f32::from(*above) * alpha;
            *below = mixed.round().clamp(0.0, 255.0) as u8;
        }
    };
    let pixels = picture.data_mut().as_chunks_mut::<3>().0;
    for (i, (below, object)) in pixels.iter_mut().zip(object.pixels()).enumerate() {
        let robot = robot.map(|robot| (robot, &robot.full.data()[i * 4..i * 4 + 4]));
        if let Some((_, above)) = robot {
            over(below, &above[..3], f32::from(above[3]) / 255.0);
        }
        over(below, &object[..3], f32::from(object[3]) / 255.0);
        if let Some((robot, above)) = robot {
            let front: f32 = Side::BOTH
                .into_iter()
                .map(|side| {
                    let whole = order.in_front[side];
                    let near = (1.0 - whole) * order.near[side];
                    whole * f32::from(robot.sides[side].data[i]) + near * f32::from(robot.near[side].data[i])
                })
                .sum();
            over(below, &above[..3], front.min(f32::from(above[3])) / 255.0);
        }
    }
    picture
}

/// Mean PSNR (dB) over frames, inside hands ∪ object's full shape, of the finished frames against
/// [`ideal_composite`] with true background, true object, [`true_order`] and the robot as `robot` renders it: the
/// very layers the finished frames were made of.
///
/// # Errors
/// When lengths or sizes differ or a picture cannot be read.
pub fn composite_psnr_db<E>(
    episode: &Episode,
    finished: &dyn FrameSource,
    robot: &mut dyn FnMut(FrameIndex) -> Result<Option<RobotLayers>, E>,
) -> Result<Option<f64>, E>
where
    E: From<BenchError>,
{
    same_length("composite", episode.frame_count(), finished.frame_count())?;
    let orders = true_order(episode)?;
    let mut scores = Vec::new();
    for index in FrameIndex::all(episode.frame_count()) {
        let layers = robot(index)?;
        let order = &orders[index.as_usize()];
        scores.extend(frame_psnr(episode, index, finished, layers.as_ref(), order)?);
    }
    Ok(mean(&scores))
}

fn frame_psnr(
    episode: &Episode,
    index: FrameIndex,
    finished: &dyn FrameSource,
    robot: Option<&RobotLayers>,
    order: &LayerDecision,
) -> Result<Option<f64>, BenchError> {
    let region = episode.hands(index)?.union(&episode.object_full(index)?);
    let ideal = ideal_composite(&episode.background(index)?, robot, &episode.object(index)?, order);
    let score = psnr_inside(&finished.frame(index)?, &ideal, &region)?;
    Ok(score.map(|score| score.min(CEILING_DB)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Size;

    #[test]
    fn the_object_hides_the_robot_except_for_its_front_parts() {
        let size = Size::new(3, 1);
        let background = Rgb8::from_data(size, vec![10; 9]).unwrap();
        let mut robot = RobotLayers::empty(size);
        let mut object = Rgba8::new(size);
        for x in 0..3 {
            robot.full.set_pixel(x, 0, [200, 200, 200, 255]);
            robot.sides.left.data[x as usize] = 255;
        }
        robot.near.left.data[2] = 255;
        object.set_pixel(1, 0, [0, 0, 100, 255]);
        object.set_pixel(2, 0, [0, 0, 100, 255]);
        let mut order = LayerDecision::default();
        order.near.left = 1.0;
        let picture = ideal_composite(&background, Some(&robot), &object, &order);
        assert_eq!(picture.data(), [200, 200, 200, 0, 0, 100, 200, 200, 200]);
        order.in_front.left = 1.0;
        let picture = ideal_composite(&background, Some(&robot), &object, &order);
        assert_eq!(picture.pixel(1, 0), [200; 3]);
        assert_eq!(ideal_composite(&background, None, &object, &order).pixel(0, 0), [10; 3]);
    }
}
