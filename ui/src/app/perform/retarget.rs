//! The robot's motion, and what lies in front of what.

use agenticfocus::{
    retarget::Beta,
    session::{Command, LayerOrder, RetargetSettings},
};

use super::super::OperatorApp;
use crate::{
    inspector::{LayerOrderChange, layer_order_on, with_layer_order},
    ui_command::UiCommand as C,
};

impl OperatorApp {
    pub(super) fn perform_retarget(&mut self, command: C) {
        let Some(workspace) = &self.workspace else { return };
        let now = workspace.document().retarget;
        let settings = match command {
            C::FitBeta => RetargetSettings { beta: Some(Beta::Fit), ..now },
            // The hand's length belongs to the hands.
            _ => RetargetSettings { hand_length: now.hand_length, ..RetargetSettings::default() },
        };
        if settings != now {
            self.change(Command::SetRetarget(settings), Vec::new());
        }
    }

    pub(super) fn perform_composite(&mut self, command: C) {
        let change = match command {
            C::OrderAuto => LayerOrderChange::Order(LayerOrder::Auto),
            C::OrderRobot => LayerOrderChange::Order(LayerOrder::RobotInFront),
            C::OrderObject => LayerOrderChange::Order(LayerOrder::ObjectInFront),
            C::OrderThumb => self.thumb_turned(),
            _ => return self.compare(),
        };
        let (first, last) = self.selected_frames();
        let Some(workspace) = &self.workspace else { return };
        let command = with_layer_order(workspace.document(), first, last, change);
        self.change(command, Vec::new());
    }

    /// The thumb pass off where it was on or left to the contact, else on.
    fn thumb_turned(&self) -> LayerOrderChange {
        let (first, _) = self.selected_frames();
        let document = self.workspace.as_ref().map(|workspace| workspace.document());
        let (_, thumb) = document.map_or_else(Default::default, |document| layer_order_on(document, first));
        LayerOrderChange::Thumb(Some(!thumb.unwrap_or(true)))
    }
}
