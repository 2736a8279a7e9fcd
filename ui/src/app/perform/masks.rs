//! Masks: tools, whole-frame operations, propagation.

use agenticfocus::{
    clip::FrameIndex,
    engine::Direction,
    image::Mask,
    session::{Command, MaskEdit, MaskLayer, MaskReach},
};

use super::super::OperatorApp;
use crate::{paint, state::Tool, ui_command::UiCommand as C};

impl OperatorApp {
    pub(super) fn perform_masks(&mut self, command: C) {
        match command {
            C::LayerObject => self.options.mask_layer = MaskLayer::Object,
            C::LayerArms => self.options.mask_layer = MaskLayer::Arms,
            C::Brush => self.options.tool = Tool::Brush,
            C::Eraser => self.options.tool = Tool::Eraser,
            C::SwapBrush => {
                let brush = self.options.tool == Tool::Brush;
                self.options.tool = if brush { Tool::Eraser } else { Tool::Brush };
            }
            C::BoxTool => self.options.tool = Tool::Box,
            C::Polygon => self.options.tool = Tool::Polygon,
            C::Lasso => self.options.tool = Tool::Lasso,
            C::PointsTool => self.options.tool = Tool::Points,
            C::BrushSmaller => self.options.brush_radius = (self.options.brush_radius / 1.25).max(0.5),
            C::BrushLarger => self.options.brush_radius = (self.options.brush_radius * 1.25).min(300.0),
            C::OnionSkin => self.options.onion_skin = !self.options.onion_skin,
            C::FillHoles => self.edit_mask(|mask, _| {
                let mut filled = mask.clone();
                paint::fill_holes(&mut filled);
                filled
            }),
            C::Grow => self.edit_mask(paint::grow),
            C::Shrink => self.edit_mask(paint::shrink),
            C::Trust => self.edit_mask(|mask, _| mask.clone()),
            C::Absent => self.set_edit(Some(MaskEdit::Absent)),
            C::ForgetMask => self.set_edit(None),
            C::PropagateForward => self.propagate(Direction::Forward),
            C::PropagateBackward => self.propagate(Direction::Backward),
            C::PropagateBoth => self.propagate(Direction::Both),
            // The canvas had its chance: nothing is open that could be finished.
            C::FinishShape => self.confirm(),
            _ => {}
        }
    }

    /// Makes another mask of the one on screen: one undo step.
    fn edit_mask(&mut self, edit: impl FnOnce(&Mask, u32) -> Mask) {
        let (layer, radius) = (self.options.mask_layer, self.options.grow_by);
        let Some((frame, mask)) = self.mask_here(layer) else { return };
        let edited = edit(&mask, radius);
        self.change_mask(layer, frame, &edited);
    }

    fn mask_here(&self, layer: MaskLayer) -> Option<(FrameIndex, Mask)> {
        let workspace = self.workspace.as_ref()?;
        Some((workspace.playhead, workspace.mask_pixels(layer, workspace.playhead)?))
    }

    /// Says something about the mask on screen, or takes back what was said.
    fn set_edit(&mut self, edit: Option<MaskEdit>) {
        let Some(workspace) = &self.workspace else { return };
        let (layer, frame) = (self.options.mask_layer, workspace.playhead);
        if edit.is_none() && !workspace.document().masks(layer).contains_key(&frame) {
            self.say("This frame is the machine's already");
            return;
        }
        self.change(Command::SetMask { layer, frame, edit }, Vec::new());
    }

    /// Spreads the operator's masks. One on screen is spread the way the command says from now on; the others as before.
    fn propagate(&mut self, direction: Direction) {
        self.set_reach(direction);
        if self.masks_wait() {
            self.work(direction);
        } else {
            self.say("Masks are spread already; edit one first, or trust the one on screen");
        }
    }

    fn set_reach(&mut self, direction: Direction) {
        let Some(workspace) = &self.workspace else { return };
        let (document, frame) = (workspace.document(), workspace.playhead);
        if self.options.mask_layer != MaskLayer::Object || !document.object_masks.contains_key(&frame) {
            return;
        }
        let reach = match direction {
            Direction::Forward => Some(MaskReach { backward: false, forward: true }),
            Direction::Backward => Some(MaskReach { backward: true, forward: false }),
            Direction::Both => None,
        };
        if document.object_reach.get(&frame).copied() != reach {
            self.change(Command::SetReach { frame, reach }, Vec::new());
        }
    }
}
