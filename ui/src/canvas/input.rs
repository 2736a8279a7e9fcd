//! What the pointer did on the canvas since the last frame, in order and with nothing left out: a quick
//! stroke is many movements between two frames.

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

/// All of it. Presses on what lies over the canvas are left out. `was_down` remembers whether a button was
/// down: one that comes up without a word, because the window lost the pointer, is told too.
pub(super) fn pointer_events(ui: &Ui, response: &Response, was_down: &mut bool) -> Vec<PointerEvent> {
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
    let (mut events, down, last): (Vec<_>, _, _) = ui.input(|input| {
        let pointer = &input.pointer;
        (input.events.iter().filter_map(read).collect(), pointer.any_down(), pointer.latest_pos())
    });
    let told = events.iter().any(|event| matches!(event, PointerEvent::Release { .. }));
    if *was_down && !down && !told {
        let at = last.unwrap_or(response.rect.center());
        let buttons = [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle];
        events.extend(buttons.map(|button| PointerEvent::Release { at, button }));
    }
    *was_down = down;
    events
}
