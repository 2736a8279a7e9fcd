//! Correcting hands.

use agenticfocus::{
    clip::FrameIndex,
    geometry::Side,
    landmarks::KEYPOINT_COUNT,
    session::{Command, HandEdit, SidesSwapped},
};

use super::super::OperatorApp;
use crate::ui_command::UiCommand as C;

impl OperatorApp {
    pub(super) fn perform_hands(&mut self, command: C) {
        match command {
            C::LeftHand => self.options.side = Side::Left,
            C::RightHand => self.options.side = Side::Right,
            C::SwapSides => self.swap_sides(),
            C::InvalidHand => {
                let edit = HandEdit { invalid: true, ..HandEdit::default() };
                self.edit_hands(|_, _| Some(Some(edit.clone())));
            }
            C::ForgetHand => self.edit_hands(|known, _| known.map(|_| None)),
            _ => self.interpolate_hand(),
        }
    }

    /// Swaps left and right on the selected frames; on those that are swapped already, back.
    fn swap_sides(&mut self) {
        let (first, last) = self.selected_frames();
        let Some(workspace) = &self.workspace else { return };
        let mut ranges = workspace.document().sides_swapped.clone();
        let same = |range: &SidesSwapped| range.first == first && range.last == last;
        match ranges.iter().position(same) {
            Some(at) => {
                ranges.remove(at);
            }
            None => ranges.push(SidesSwapped { first, last }),
        }
        self.change(Command::SetSidesSwapped(ranges), Vec::new());
    }

    /// Edits the chosen hand on every selected frame; `edit` says what a frame's edit becomes, `None` for no change.
    fn edit_hands(&mut self, edit: impl Fn(Option<&HandEdit>, FrameIndex) -> Option<Option<HandEdit>>) {
        let (first, last) = self.selected_frames();
        let side = self.options.side;
        let Some(workspace) = &self.workspace else { return };
        let edits = &workspace.document().hand_edits[side];
        let commands = (first.0..=last.0)
            .map(FrameIndex)
            .filter_map(|frame| {
                let edit = edit(edits.get(&frame), frame)?;
                Some(Command::SetHandEdit { frame, side, edit })
            })
            .collect();
        self.change_together(commands);
    }

    /// Draws the chosen hand's keypoints on straight lines between the ends of the selection.
    fn interpolate_hand(&mut self) {
        let side = self.options.side;
        let (first, last) = self.selected_frames();
        let keypoints = |frame: FrameIndex| {
            let workspace = self.workspace.as_ref()?;
            let mut points = match workspace.found.landmarks.as_ref()?.get(frame.as_usize())?[side].as_ref() {
                Some(hand) => hand.keypoints,
                None => {
                    let hand = workspace.found.hands.as_ref()?.hands[side].get(frame.as_usize())?;
                    hand.is_valid().then_some(hand.keypoints)?
                }
            };
            for (index, pixel) in
                workspace.document().hand_edits[side].get(&frame).iter().flat_map(|edit| &edit.keypoints)
            {
                points[usize::from(*index)] = *pixel;
            }
            Some(points)
        };
        let (Some(from), Some(to)) = (keypoints(first), keypoints(last)) else {
            self.say("Select frames on whose ends this hand is known");
            return;
        };
        if last.0 < first.0 + 2 {
            self.say("Select at least three frames: Shift+drag on the timeline");
            return;
        }
        let span = f64::from(last.0 - first.0);
        self.edit_hands(|_, frame| {
            if frame == first || frame == last {
                return None;
            }
            let share = f64::from(frame.0 - first.0) / span;
            let keypoints = (0..KEYPOINT_COUNT)
                .map(|at| {
                    let between = agenticfocus::geometry::Pixel::new(
                        from[at].x + share * (to[at].x - from[at].x),
                        from[at].y + share * (to[at].y - from[at].y),
                    );
                    (at as u8, between)
                })
                .collect();
            Some(Some(HandEdit { keypoints, invalid: false }))
        });
    }
}
