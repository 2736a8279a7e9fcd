//! The template and where it goes.

use agenticfocus::{clip::FrameIndex, session::Command};
use nalgebra::{Matrix3, Vector2};

use super::super::OperatorApp;
use crate::ui_command::UiCommand as C;

/// One step of scaling a placement by key.
const SCALE_STEP: f64 = 1.01;

impl OperatorApp {
    pub(super) fn perform_template(&mut self, command: C) {
        let Some(workspace) = &self.workspace else { return };
        let here = workspace.playhead;
        match command {
            C::TemplateHere => self.cut_template_from(Some(here)),
            C::TemplateAuto => self.cut_template_from(None),
            C::ForgetPlacement => {
                if workspace.document().template.placements.contains_key(&here) {
                    self.change(Command::SetPlacement { frame: here, transform: None }, Vec::new());
                } else {
                    self.say("This frame's placement is the machine's already");
                }
            }
            C::NudgeLeft => self.move_placement(-1.0, 0.0),
            C::NudgeRight => self.move_placement(1.0, 0.0),
            C::NudgeUp => self.move_placement(0.0, -1.0),
            C::NudgeDown => self.move_placement(0.0, 1.0),
            C::PlacementLarger => self.scale_placement(SCALE_STEP),
            C::PlacementSmaller => self.scale_placement(1.0 / SCALE_STEP),
            _ => {}
        }
    }

    /// The mask drawn for another frame does not fit the new one.
    fn cut_template_from(&mut self, frame: Option<FrameIndex>) {
        let commands = vec![Command::SetTemplateFrame(frame), Command::SetTemplateMask(None)];
        self.change(Command::Together(commands), Vec::new());
    }

    fn placement_here(&self) -> Option<(FrameIndex, Matrix3<f64>, Vector2<f64>)> {
        let workspace = self.workspace.as_ref()?;
        let here = workspace.playhead;
        let template = workspace.found.template.as_ref()?;
        let by_hand = workspace.document().template.placements.get(&here).copied();
        let found = template.placements.get(here.as_usize())?.as_ref().map(|placement| placement.transform);
        let size = template.picture.size();
        let centre = Vector2::new(0.5 * f64::from(size.width), 0.5 * f64::from(size.height));
        Some((here, by_hand.or(found)?, centre))
    }

    fn move_placement(&mut self, x: f64, y: f64) {
        let Some((frame, transform, _)) = self.placement_here() else {
            self.say("The template is not placed on this frame");
            return;
        };
        let moved = Matrix3::new_translation(&Vector2::new(x, y)) * transform;
        self.change(Command::SetPlacement { frame, transform: Some(moved) }, Vec::new());
    }

    fn scale_placement(&mut self, factor: f64) {
        let Some((frame, transform, centre)) = self.placement_here() else {
            self.say("The template is not placed on this frame");
            return;
        };
        let about = Matrix3::new_translation(&centre)
            * Matrix3::new_scaling(factor)
            * Matrix3::new_translation(&-centre);
        self.change(Command::SetPlacement { frame, transform: Some(transform * about) }, Vec::new());
    }
}
