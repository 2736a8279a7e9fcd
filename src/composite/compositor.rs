//! Back to front: background, robot, object, what of the robot lies before the object.

use super::{
    CompositeError, CompositeParams,
    object::{ObjectEvidence, ObjectLayer, object_layer},
    order::LayerDecision,
};
use crate::{
    geometry::{Side, Size},
    image::{Rgb8, Rgba8},
    render::RobotLayers,
};

/// Everything that makes one frame. All pictures have the background's size.
#[derive(Clone, Copy, Debug)]
pub struct FrameLayers<'a> {
    /// The frame without arms; the visible object may still be in it.
    pub background: &'a Rgb8,
    /// The robot's passes; `None` where no hand is valid.
    pub robot: Option<&'a RobotLayers>,
    /// The object; `None` where it is absent.
    pub object: Option<ObjectEvidence<'a>>,
    /// What lies in front, per side.
    pub order: LayerDecision,
}

/// One finished frame.
#[derive(Clone, Debug)]
pub struct Composite {
    /// The picture.
    pub picture: Rgb8,
    /// The object layer that was drawn, for the layer debug video.
    pub object: Option<ObjectLayer>,
}

/// Puts layers together. Holds parameters only: frames can be composed in any order and in parallel.
#[derive(Clone, Debug, Default)]
pub struct Compositor {
    /// What can be tuned.
    pub params: CompositeParams,
}

impl Compositor {
    /// Composes one frame:
    /// `C₁ = full over background`, `C₂ = object over C₁`, `C = front over C₂`, where `front` are the
    /// robot's colours with the coverage of the sides or near parts that [`LayerDecision`] puts before
    /// the object. Straight alpha, 8-bit sRGB values mixed linearly.
    ///
    /// # Errors
    /// When sizes differ, a placement is singular or OpenCV fails.
    pub fn compose(&self, layers: &FrameLayers<'_>) -> Result<Composite, CompositeError> {
        let size = layers.background.size();
        let object = match &layers.object {
            Some(evidence) => object_layer(evidence, size, &self.params)?,
            None => None,
        };
        let mut picture = layers.background.clone();
        if let Some(robot) = layers.robot {
            check("the robot pass", size, robot.full.size())?;
            draw_robot(&mut picture, robot);
        }
        if let Some(object) = &object {
            object.draw_over(&mut picture);
        }
        if let (Some(robot), Some(_)) = (layers.robot, &object) {
            draw_front(&mut picture, robot, &layers.order);
        }
        Ok(Composite { picture, object })
    }
}

pub(super) fn check(layer: &'static str, expected: Size, found: Size) -> Result<(), CompositeError> {
    if expected == found { Ok(()) } else { Err(CompositeError::Size { layer, expected, found }) }
}

/// `over` with 8-bit straight alpha, rounded to nearest.
fn over(below: u8, above: u8, alpha: u8) -> u8 {
    let (below, above, alpha) = (u32::from(below), u32::from(above), u32::from(alpha));
    ((above * alpha + below * (255 - alpha) + 127) / 255) as u8
}

fn draw_robot(picture: &mut Rgb8, robot: &RobotLayers) {
    for (below, above) in picture.data_mut().as_chunks_mut::<3>().0.iter_mut().zip(robot.full.pixels()) {
        if above[3] != 0 {
            for (below, above_channel) in below.iter_mut().zip(&above[..3]) {
                *below = over(*below, *above_channel, above[3]);
            }
        }
    }
}

fn draw_front(picture: &mut Rgb8, robot: &RobotLayers, order: &LayerDecision) {
    for_front(robot, order, |at, above, alpha| {
        let below = &mut picture.data_mut()[at * 3..at * 3 + 3];
        for (below, above_channel) in below.iter_mut().zip(&above[..3]) {
            *below = over(*below, *above_channel, alpha);
        }
    });
}

/// What of the robot lies over the object: its colours with straight alpha, as [`Compositor::compose`] draws them.
pub fn front_layer(robot: &RobotLayers, order: &LayerDecision) -> Rgba8 {
    let mut layer = Rgba8::new(robot.full.size());
    for_front(robot, order, |at, [r, g, b, _], alpha| {
        layer.data_mut()[at * 4..at * 4 + 4].copy_from_slice(&[r, g, b, alpha]);
    });
    layer
}

/// Calls `draw` with index, colour and alpha of every pixel of the robot that lies over the object.
fn for_front(robot: &RobotLayers, order: &LayerDecision, mut draw: impl FnMut(usize, [u8; 4], u8)) {
    let weights = Side::BOTH.map(|side| {
        let whole = order.in_front[side].clamp(0.0, 1.0);
        (side, whole, (1.0 - whole) * order.near[side].clamp(0.0, 1.0))
    });
    if weights.iter().all(|(_, whole, near)| *whole <= 0.0 && *near <= 0.0) {
        return;
    }
    for (at, above) in robot.full.pixels().enumerate() {
        if above[3] == 0 {
            continue;
        }
        let mut coverage = 0.0_f32;
        for (side, whole, near) in weights {
            let sides = f32::from(robot.sides[side].data[at]);
            // The near parts belong to the side: where the whole side is in front they add nothing.
            coverage += whole * sides + near * f32::from(robot.near[side].data[at]);
        }
        draw(at, *above, coverage.round().clamp(0.0, f32::from(above[3])) as u8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::PerSide,
        image::{Mask, Rgba8},
        render::RobotLayers,
        template::{Placement, TemplateTrack},
    };

    const SIZE: Size = Size::new(24, 12);

    fn flat(colour: [u8; 3]) -> Rgb8 {
        Rgb8::from_data(SIZE, colour.repeat(SIZE.area())).unwrap()
    }

    /// A white robot hand of the right side on columns 6–17, its thumb on columns 6–8, half covered at column 18.
    fn robot() -> RobotLayers {
        let mut robot = RobotLayers::empty(SIZE);
        for y in 0..SIZE.height {
            for x in 6..19 {
                let coverage = if x == 18 { 128 } else { 255 };
                let at = (y * SIZE.width + x) as usize;
                robot.full.set_pixel(x, y, [250, 250, 250, coverage]);
                robot.sides.right.data[at] = coverage;
                if x < 9 {
                    robot.near.right.data[at] = coverage;
                }
            }
        }
        robot
    }

    fn template() -> TemplateTrack {
        let picture = Rgba8::from_data(SIZE, [10, 20, 200, 255].repeat(SIZE.area())).unwrap();
        let placement = Placement { transform: nalgebra::Matrix3::identity(), confidence: 1.0, visible: 0.0 };
        TemplateTrack {
            picture,
            origin: (0, 0),
            frame: crate::clip::FrameIndex(0),
            placements: vec![Some(placement)],
            scores: vec![1.0],
        }
    }

    fn composed(in_front: f32, near: f32) -> Rgb8 {
        let (template, robot, background) = (template(), robot(), flat([90, 60, 30]));
        let everything = Mask::from_fn(SIZE, |_, _| true);
        let evidence = ObjectEvidence {
            template: &template,
            placement: template.placements[0].as_ref(),
            source: &background,
            visible: None,
            hidden: &everything,
        };
        let order = LayerDecision {
            in_front: PerSide { left: 0.0, right: in_front },
            near: PerSide { left: 0.0, right: near },
        };
        let layers =
            FrameLayers { background: &background, robot: Some(&robot), object: Some(evidence), order };
        Compositor::default().compose(&layers).unwrap().picture
    }

    #[test]
    fn the_object_covers_the_hand_and_the_thumb_covers_the_object() {
        let picture = composed(0.0, 1.0);
        assert_eq!(picture.pixel(7, 6), [250, 250, 250]);
        assert_eq!(picture.pixel(12, 6), [10, 20, 200]);
        assert_eq!(picture.pixel(22, 6), [10, 20, 200]);
    }

    #[test]
    fn without_the_thumb_pass_the_object_covers_the_thumb_too() {
        assert_eq!(composed(0.0, 0.0).pixel(7, 6), [10, 20, 200]);
    }

    #[test]
    fn a_robot_in_front_meets_the_object_without_a_dark_or_background_fringe() {
        let picture = composed(1.0, 0.0);
        assert_eq!(picture.pixel(12, 6), [250, 250, 250]);
        // Half robot, half object: nothing of the background, nothing of black.
        assert_eq!(picture.pixel(18, 6), [130, 135, 225]);
    }

    #[test]
    fn a_layer_of_another_size_is_refused_by_name() {
        let background = Rgb8::new(Size::new(5, 5));
        let robot = robot();
        let layers = FrameLayers {
            background: &background,
            robot: Some(&robot),
            object: None,
            order: LayerDecision::default(),
        };
        let error = Compositor::default().compose(&layers).unwrap_err();
        assert!(error.to_string().contains("robot pass is 24×12"), "{error}");
    }
}
