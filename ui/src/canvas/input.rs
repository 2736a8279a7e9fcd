//! What the pointer did on the canvas since the last frame, in order and with nothing left out: a quick stroke is
//! many movements between two frames.

use egui::{Event, Modifiers, PointerButton, Pos2, Response, Ui};

/// One thing the pointer did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PointerEvent {
    /// A button went down on the canvas.
    Press { at: Pos2, button: PointerButton, modifiers: Modifiers },
    /// It moved, here or elsewhere.
    Move(Pos2),
    /// A button came up, here or elsewhere.
    Release { at: Pos2, button: PointerButton },
}

/// All of it. Presses on what lies over the canvas are left out.
pub(super) fn pointer_events(ui: &Ui, response: &Response) -> Vec<PointerEvent> {
    let here = response.hovered() || response.is_pointer_button_down_on();
    let read = |event: &Event| match *event {
        Event::PointerMoved(at) => Some(PointerEvent::Move(at)),
        Event::PointerButton { pos, button, pressed: true, modifiers } => (here
            && response.rect.contains(pos))
        .then_some(PointerEvent::Press { at: pos, button, modifiers }),
        Event::PointerButton { pos, button, pressed: false, .. } => {
            Some(PointerEvent::Release { at: pos, button })
        }
        _ => None,
    };
    ui.input(|input| input.events.iter().filter_map(read).collect())
}
