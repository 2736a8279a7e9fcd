//! The robot's motion, and what lies in front of what.

use agenticfocus::{
    retarget::Beta,
    session::{Command, LayerOrder, LayerOrderRange, RetargetSettings},
};

use super::super::OperatorApp;
use crate::ui_command::UiCommand as C;

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
        match command {
            C::OrderAuto => self.set_order(Some(LayerOrder::Auto)),
            C::OrderRobot => self.set_order(Some(LayerOrder::RobotInFront)),
            C::OrderObject => self.set_order(Some(LayerOrder::ObjectInFront)),
            C::OrderThumb => self.set_order(None),
            _ => self.compare(),
        }
    }

    /// Forces an order on the selected frames; without one, turns the thumb pass on or off there.
    fn set_order(&mut self, order: Option<LayerOrder>) {
        let (first, last) = self.selected_frames();
        let Some(workspace) = &self.workspace else { return };
        let mut orders = workspace.document().layer_orders.clone();
        let known = orders.iter().position(|range| range.first == first && range.last == last);
        let before = known.map(|at| orders.remove(at));
        let old = before.unwrap_or(LayerOrderRange { first, last, order: LayerOrder::Auto, thumb: None });
        let range = match order {
            Some(order) => LayerOrderRange { order, ..old },
            None => LayerOrderRange { thumb: Some(!old.thumb.unwrap_or(true)), ..old },
        };
        orders.push(range);
        self.change(Command::SetLayerOrders(orders), Vec::new());
    }
}
