//! The template: where it is cut from, and placements that are dropped.

use agenticfocus::{clip::FrameIndex, session::Command};

use super::super::OperatorApp;
use crate::{inspector::choose_template_frame, ui_command::UiCommand as C};

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
            C::InterpolatePlacement => self.interpolate_placement(here),
            // The canvas moves and scales placements.
            _ => {}
        }
    }

    /// Joins the keyframes around `frame`, or parts them where they are joined.
    fn interpolate_placement(&mut self, frame: FrameIndex) {
        let Some(workspace) = &self.workspace else { return };
        let template = &workspace.document().template;
        let Some([(first, _), _]) = template.keyframes_around(frame) else {
            self.say("Place the template on a frame before this one and on one after it first");
            return;
        };
        let interpolated = !template.interpolated.contains(&first);
        self.change(Command::SetInterpolated { frame: first, interpolated }, Vec::new());
    }

    fn cut_template_from(&mut self, frame: Option<FrameIndex>) {
        let Some(workspace) = &self.workspace else { return };
        let command = choose_template_frame(workspace.document(), frame);
        self.change(command, Vec::new());
    }
}
