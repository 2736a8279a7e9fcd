//! What the colours and the arm mask say about every pixel around the object.

use super::view::{Roi, View, arm};
use crate::vision::{ColourModel, Plane, log_odds};

/// Colours of the object and of what surrounds it.
#[derive(Clone)]
pub(crate) struct Colours {
    pub object: ColourModel,
    pub around: ColourModel,
}

/// Per-pixel evidence inside a rectangle of a view.
pub(crate) struct Evidence {
    /// ln P(colour | object) / P(colour | surroundings), clamped.
    pub object: Vec<f32>,
    /// Log-odds that an arm covers the pixel, against the object.
    pub arm: Vec<f32>,
}

/// Colour log-odds are trusted up to this much.
const COLOUR_LIMIT: f32 = 2.5;

impl Evidence {
    /// Reads the evidence inside `roi`.
    pub fn read(view: &View, roi: &Roi, colours: &Colours, arm_colours: Option<&ColourModel>) -> Self {
        let lab = roi.crop(&view.lab, view.width);
        let classes = roi.crop(&view.arms, view.width);
        let object = lab
            .iter()
            .map(|lab| {
                let (f, b) = (colours.object.likelihood(*lab), colours.around.likelihood(*lab));
                log_odds(f, b).clamp(-COLOUR_LIMIT, COLOUR_LIMIT)
            })
            .collect();
        let arm = lab
            .iter()
            .zip(&classes)
            .map(|(lab, class)| {
                let prior = match *class {
                    arm::SKELETON => 2.2,
                    arm::MASK => 1.5,
                    arm::NEAR => -1.5,
                    _ => -5.0,
                };
                let colour = arm_colours
                    .map_or(0.0, |model| log_odds(model.likelihood(*lab), colours.object.likelihood(*lab)));
                prior + colour.clamp(-2.8, 2.8)
            })
            .collect();
        Self { object, arm }
    }

    /// Probability by colour alone that a pixel is object rather than surroundings.
    pub fn object_probability(&self, roi: &Roi) -> Plane {
        let data = self.object.iter().map(|logit| sigmoid(1.5 * logit)).collect();
        Plane { width: roi.width, height: roi.height, data }
    }

    /// Probability that no arm covers a pixel.
    pub fn free_of_arm(&self, roi: &Roi) -> Plane {
        let data = self.arm.iter().map(|logit| sigmoid(-1.5 * logit)).collect();
        Plane { width: roi.width, height: roi.height, data }
    }
}

/// The logistic function.
pub(crate) fn sigmoid(logit: f32) -> f32 {
    1.0 / (1.0 + (-logit).exp())
}

/// Learns what surrounds a shape: pixels of `roi` between `near` and `far` pixels outside it,
/// arms left out.
pub(crate) fn learn_surroundings(
    view: &View,
    roi: &Roi,
    distance: &Plane,
    near: f32,
    far: f32,
) -> Option<ColourModel> {
    let lab = roi.crop(&view.lab, view.width);
    let classes = roi.crop(&view.arms, view.width);
    let samples = lab.into_iter().zip(classes).zip(&distance.data).filter_map(|((lab, class), d)| {
        let beside = -*d >= near && -*d <= far && class <= arm::NEAR;
        beside.then_some((lab, 1.0))
    });
    ColourModel::learn(samples)
}
