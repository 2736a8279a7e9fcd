//! Borders of the mask on the frames before and after.

use std::sync::Arc;

use agenticfocus::{clip::FrameIndex, segment::RleMask, session::MaskLayer};
use egui::Color32;

use super::{
    scene::Scene,
    shapes::{LineStyle, outlines},
};
use crate::paint::{Outline, outline};

/// Opacity of the neighbours' borders.
const OPACITY: f32 = 0.4;

/// The neighbours' borders, kept until their masks change.
#[derive(Debug, Default)]
pub(super) struct OnionSkin {
    /// Before, after.
    neighbours: [Option<Neighbour>; 2],
}

#[derive(Debug)]
struct Neighbour {
    frame: FrameIndex,
    mask: Arc<RleMask>,
    lines: Vec<Outline>,
}

impl OnionSkin {
    /// Draws both: the frame before dashed, the one after solid.
    pub fn draw(&mut self, scene: &Scene<'_>, layer: MaskLayer, colour: Color32) {
        let frame = scene.frame.0;
        let frames = [frame.checked_sub(1), frame.checked_add(1)].map(|frame| frame.map(FrameIndex));
        for (at, (kept, frame)) in self.neighbours.iter_mut().zip(frames).enumerate() {
            let Some((frame, on)) =
                frame.and_then(|frame| Some((frame, scene.workspace.mask(layer, frame)?)))
            else {
                *kept = None;
                continue;
            };
            if kept.as_ref().is_none_or(|kept| kept.frame != frame || kept.mask != on.mask) {
                let lines = outline(&on.mask.decode());
                *kept = Some(Neighbour { frame, mask: on.mask, lines });
            }
            let style = LineStyle { width: 1.0, colour: colour.gamma_multiply(OPACITY), dashed: at == 0 };
            let lines = kept.iter().flat_map(|kept| &kept.lines);
            outlines(&scene.painter, &scene.projection, lines.map(|line| (line, style)));
        }
    }
}
