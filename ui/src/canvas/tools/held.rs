//! What the primary button holds while it is down: the same for everything on the canvas that can be dragged.

use agenticfocus::{clip::FrameIndex, geometry::Pixel};
use egui::{Modifiers, PointerButton, Pos2};

use super::super::{input::PointerEvent, scene::Scene};

/// Something that follows the pointer.
pub(super) trait Follow {
    /// The pointer is at `to` of the picture now.
    fn follow(&mut self, to: Pixel);
}

/// What is held, and on which frame it was taken hold of.
#[derive(Debug)]
pub(super) struct Held<T>(Option<(FrameIndex, T)>);

impl<T> Default for Held<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<T: Follow> Held<T> {
    /// Follows the pointer; `grab` says what a press takes hold of. What was let go of comes back, with its frame:
    /// by the button, or because another frame is on screen.
    pub fn follow(
        &mut self,
        scene: &Scene<'_>,
        mut grab: impl FnMut(Pos2, Modifiers) -> Option<T>,
    ) -> Vec<(FrameIndex, T)> {
        let mut let_go = Vec::new();
        if self.0.as_ref().is_some_and(|(frame, _)| *frame != scene.frame) {
            let_go.extend(self.0.take());
        }
        for event in &scene.events {
            match *event {
                PointerEvent::Press { at, button: PointerButton::Primary, modifiers } if !scene.hidden => {
                    if let Some(held) = grab(at, modifiers) {
                        self.0 = Some((scene.frame, held));
                    }
                }
                PointerEvent::Move(at) => {
                    if let Some((_, held)) = &mut self.0 {
                        held.follow(scene.pixel(at));
                    }
                }
                PointerEvent::Release { button: PointerButton::Primary, .. } => let_go.extend(self.0.take()),
                PointerEvent::Press { .. } | PointerEvent::Release { .. } => {}
            }
        }
        let_go
    }

    /// What is held.
    pub fn get(&self) -> Option<&T> {
        self.0.as_ref().map(|(_, held)| held)
    }

    /// Drops it; false when nothing was held.
    pub fn cancel(&mut self) -> bool {
        self.0.take().is_some()
    }
}
