//! The robot as layers for the compositor.

use serde::{Deserialize, Serialize};

use crate::{
    geometry::{PerSide, Side, Size},
    image::Rgba8,
};

/// How much of each pixel something fills, 0 to 255.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coverage {
    /// Width and height.
    pub size: Size,
    /// One byte a pixel, row after row.
    pub data: Vec<u8>,
}

impl Coverage {
    /// Nothing anywhere.
    pub fn empty(size: Size) -> Self {
        Self { size, data: vec![0; size.area()] }
    }

    /// Whether no pixel is touched.
    pub fn is_empty(&self) -> bool {
        self.data.iter().all(|value| *value == 0)
    }
}

/// Which parts of a hand the near-contact pass holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NearParts {
    /// The whole thumb.
    pub thumb: bool,
    /// Finger links whose centre lies nearer to the camera than this, metres along z in the robot's virtual camera.
    pub fingers_within: Option<f64>,
}

impl Default for NearParts {
    /// The thumb alone.
    fn default() -> Self {
        Self { thumb: true, fingers_within: None }
    }
}

/// What to draw of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerRequest {
    /// Whether the side's arm and hand are drawn at all.
    pub shown: PerSide<bool>,
    /// What the near-contact pass of each hand holds.
    pub near: PerSide<NearParts>,
}

impl Default for LayerRequest {
    /// Both sides, thumbs near.
    fn default() -> Self {
        Self { shown: PerSide { left: true, right: true }, near: PerSide::default() }
    }
}

/// The robot of one frame, cut out.
///
/// A part that another part of the robot hides is hidden in every layer, so that drawing `near` over an object that
/// was drawn over `full` never brings out what the hand itself covers.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotLayers {
    /// Arms and hands, straight alpha: at an edge the colour is the robot's own, so there is no dark fringe.
    pub full: Rgba8,
    /// How much of each pixel each side's arm and hand fill.
    pub sides: PerSide<Coverage>,
    /// How much of each pixel the near parts of each hand fill.
    pub near: PerSide<Coverage>,
    /// Metres along z of the robot's virtual camera, `f32::INFINITY` where there is no robot.
    pub depth: Vec<f32>,
}

impl RobotLayers {
    /// Nothing drawn.
    pub fn empty(size: Size) -> Self {
        let nothing = || PerSide::from_fn(|_| Coverage::empty(size));
        Self {
            full: Rgba8::new(size),
            sides: nothing(),
            near: nothing(),
            depth: vec![f32::INFINITY; size.area()],
        }
    }

    /// The near-contact layer of one hand: the colours of `full`, the coverage of its near parts.
    pub fn near_layer(&self, side: Side) -> Rgba8 {
        let mut layer = self.full.clone();
        for (pixel, coverage) in layer.data_mut().as_chunks_mut::<4>().0.iter_mut().zip(&self.near[side].data)
        {
            pixel[3] = *coverage;
        }
        layer
    }
}
