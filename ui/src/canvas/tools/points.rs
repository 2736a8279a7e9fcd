//! Points on a thing and beside it, from which the engine makes a mask.

use std::sync::Arc;

use agenticfocus::{
    clip::FrameIndex, engine::Request, geometry::Pixel, segment::RleMask, session::MaskLayer,
};

use super::super::{scene::Scene, shapes};
use crate::{action::Action, state::Context};

/// Points clicked so far, on one frame.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct Points {
    pub layer: MaskLayer,
    pub frame: FrameIndex,
    pub positive: Vec<Pixel>,
    pub negative: Vec<Pixel>,
}

impl Points {
    pub fn new(layer: MaskLayer, frame: FrameIndex) -> Self {
        Self { layer, frame, positive: Vec::new(), negative: Vec::new() }
    }

    /// Adds a point and asks the engine for a mask.
    pub fn add(&mut self, at: Pixel, positive: bool, cx: &mut Context<'_>) {
        if positive {
            self.positive.push(at);
        } else {
            self.negative.push(at);
        }
        if !self.positive.is_empty() {
            cx.ask(Action::Ask(Request::Segment {
                layer: self.layer,
                frame: self.frame,
                positive: self.positive.clone(),
                negative: self.negative.clone(),
            }));
        }
    }

    /// The engine's answer for these very points.
    pub fn answer(&self, scene: &Scene<'_>) -> Option<Arc<RleMask>> {
        let draft = scene.workspace.draft.as_ref().filter(|draft| draft.frame == self.frame)?;
        let same = draft.positive == self.positive && draft.negative == self.negative;
        draft.mask.clone().filter(|_| same)
    }

    /// What is to be done next, in words.
    pub fn hint(&self, scene: &Scene<'_>) -> String {
        if let Some(fault) = scene.workspace.draft.as_ref().and_then(|draft| draft.fault.as_ref()) {
            return fault.clone();
        }
        match (self.positive.is_empty(), self.answer(scene).is_some()) {
            (true, _) => "Click on it too, not only beside it".to_owned(),
            (false, true) => "Enter takes this, Esc drops the points".to_owned(),
            (false, false) => "Looking for a mask…".to_owned(),
        }
    }

    pub fn draw(&self, scene: &Scene<'_>, cx: &Context<'_>) {
        for (list, positive) in [(&self.positive, true), (&self.negative, false)] {
            for point in list {
                shapes::click_mark(&scene.painter, scene.projection.to_screen(*point), positive, cx.tokens);
            }
        }
    }
}
