//! Pointing without a pointer: a cross that arrow keys move and Space presses, for every tool of the canvas.

use agenticfocus::geometry::Pixel;
use egui::{Color32, Event, EventFilter, Key, Modifiers, Painter, PointerButton, Response, Stroke, Ui, vec2};

use super::{input::PointerEvent, shapes, view::Projection};

/// How far Shift makes an arrow go, picture pixels; alone it goes one.
const FAR: f64 = 10.0;

/// The cross.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    at: Pixel,
    /// It was not on screen yet, so that it cannot have the keyboard.
    fresh: bool,
}

impl Aim {
    pub fn new(at: Pixel) -> Self {
        Self { at, fresh: true }
    }

    /// Where it is.
    pub fn at(&self) -> Pixel {
        self.at
    }

    /// Takes the keyboard at first; false once somebody else has it.
    pub fn holds_keyboard(&mut self, ui: &Ui, canvas: &Response) -> bool {
        if std::mem::take(&mut self.fresh) {
            canvas.request_focus();
            return true;
        }
        let arrows = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(canvas.id, arrows));
        canvas.has_focus()
    }

    /// What the keys did since the last frame, as if a pointer had done it.
    pub fn events(&mut self, ui: &Ui, projection: &Projection) -> Vec<PointerEvent> {
        let keys: Vec<(Key, bool, Modifiers)> = ui.input(|input| {
            let key = |event: &Event| match *event {
                Event::Key { key, pressed, repeat, modifiers, .. } => {
                    (key != Key::Space || !repeat).then_some((key, pressed, modifiers))
                }
                _ => None,
            };
            input.events.iter().filter_map(key).collect()
        });
        keys.into_iter()
            .filter_map(|(key, pressed, modifiers)| self.key(key, pressed, modifiers, projection))
            .collect()
    }

    fn key(
        &mut self,
        key: Key,
        pressed: bool,
        modifiers: Modifiers,
        projection: &Projection,
    ) -> Option<PointerEvent> {
        let (x, y) = match key {
            Key::ArrowLeft => (-1.0, 0.0),
            Key::ArrowRight => (1.0, 0.0),
            Key::ArrowUp => (0.0, -1.0),
            Key::ArrowDown => (0.0, 1.0),
            Key::Space => {
                let (at, button) = (projection.to_screen(self.at), PointerButton::Primary);
                return Some(if pressed {
                    PointerEvent::Press { at, button, modifiers }
                } else {
                    PointerEvent::Release { at, button }
                });
            }
            _ => return None,
        };
        if !pressed || modifiers.command || modifiers.alt {
            return None;
        }
        let step = if modifiers.shift { FAR } else { 1.0 };
        let size = projection.size;
        let inside = |value: f64, count: u32| value.clamp(0.0, f64::from(count.saturating_sub(1)));
        self.at =
            Pixel::new(inside(self.at.x + step * x, size.width), inside(self.at.y + step * y, size.height));
        Some(PointerEvent::Move(projection.to_screen(self.at)))
    }

    /// A cross with a gap, so that the pixel it means can be seen.
    pub fn draw(&self, painter: &Painter, projection: &Projection, colour: Color32) {
        let middle = projection.to_screen(self.at);
        for direction in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
            let ends = [middle + 4.0 * direction, middle + 16.0 * direction];
            painter.line_segment(ends, Stroke::new(4.0, shapes::rim_colour()));
            painter.line_segment(ends, Stroke::new(2.0, colour));
        }
    }
}
