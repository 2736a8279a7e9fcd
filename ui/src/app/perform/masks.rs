//! Masks: what is said about a frame, propagation. Tools and what they do belong to the canvas.

use agenticfocus::{
    inpaint::InpaintParams,
    session::{Command, MaskEdit, MaskLayer, MaskReach},
};

use super::super::OperatorApp;
use crate::ui_command::UiCommand as C;

impl OperatorApp {
    pub(super) fn perform_masks(&mut self, command: C) {
        match command {
            C::Trust => self.trust(),
            C::Absent => self.say_absent(),
            C::ForgetMask => self.set_edit(None),
            C::PropagateForward => self.propagate(Some(MaskReach { backward: false, forward: true })),
            C::PropagateBackward => self.propagate(Some(MaskReach { backward: true, forward: false })),
            C::PropagateBoth => self.propagate(None),
            C::HoleWider => self.widen_hole(1.0),
            C::HoleNarrower => self.widen_hole(-1.0),
            // The canvas had its chance: nothing is open that could be finished.
            C::FinishShape => self.confirm(),
            _ => {}
        }
    }

    /// Makes the mask on screen the operator's own.
    fn trust(&mut self) {
        let Some(workspace) = &self.workspace else { return };
        let (layer, frame) = (self.options.mask_layer, workspace.playhead);
        let Some(mask) = workspace.mask_pixels(layer, frame) else { return };
        self.change_mask(layer, frame, &mask);
    }

    /// There is nothing of the object, or of the arm that is meant, on this frame; the other arm stays.
    fn say_absent(&mut self) {
        let Some(workspace) = &self.workspace else { return };
        let frame = workspace.playhead;
        let others = self.options.arm().and_then(|side| {
            let mask = workspace.mask_pixels(MaskLayer::Arms, frame)?;
            let others = mask.minus(&workspace.side_split(frame)?.part(&mask, side));
            (!others.is_empty()).then_some(others)
        });
        match others {
            Some(others) => self.change_mask(MaskLayer::Arms, frame, &others),
            None => self.set_edit(Some(MaskEdit::Absent)),
        }
    }

    /// Widens the hole in the background by pixels of the clip.
    fn widen_hole(&mut self, by: f64) {
        let Some(workspace) = &self.workspace else { return };
        let Some(size) = workspace.size() else { return };
        let width = f64::from(size.width);
        let most = (InpaintParams::WIDEST_DILATION * width).floor();
        let pixels = ((width * workspace.hole_dilation()).round() + by).clamp(0.0, most);
        self.options.hole_outline = true;
        self.change(Command::SetHoleDilation(Some(pixels / width)), Vec::new());
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

    /// Spreads the operator's masks. One on screen reaches as far as the command says from now on, `None` both ways;
    /// the others as before.
    fn propagate(&mut self, reach: Option<MaskReach>) {
        self.set_reach(reach);
        if self.masks_wait() {
            self.work();
        } else {
            self.say("Masks are spread already; edit one first, or trust the one on screen");
        }
    }

    fn set_reach(&mut self, reach: Option<MaskReach>) {
        let Some(workspace) = &self.workspace else { return };
        let (document, frame) = (workspace.document(), workspace.playhead);
        if self.options.mask_layer != MaskLayer::Object || !document.object_masks.contains_key(&frame) {
            return;
        }
        if document.object_reach.get(&frame).copied() != reach {
            self.change(Command::SetReach { frame, reach }, Vec::new());
        }
    }
}
