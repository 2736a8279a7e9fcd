//! Glyphs of the window, drawn rather than taken from a font: sharp at every scale, and none is missing.

use egui::{
    Atom, Color32, Painter, Pos2, Rect, Shape, Stroke, Vec2,
    epaint::{PathShape, PathStroke},
    pos2, vec2,
};

/// A glyph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Icon {
    /// Three lines.
    Menu,
    /// An arrow turning back.
    Undo,
    /// An arrow turning on.
    Redo,
    /// A looking glass.
    Search,
    /// A keyboard.
    Keys,
    /// A circle.
    Ring,
    /// A circle, half full.
    HalfRing,
    /// A full circle.
    Dot,
    /// A triangle on its base.
    Warning,
    /// A tick.
    Check,
    /// A cross.
    Cross,
    /// A flag on a pole.
    Flag,
    /// A square on its corner.
    Diamond,
    /// Play.
    Play,
    /// Hold.
    Pause,
    /// Stop.
    Stop,
    /// One back.
    Previous,
    /// One on.
    Next,
    /// To the start.
    First,
    /// To the end.
    Last,
    /// An eye.
    Eye,
    /// An eye, crossed out.
    EyeOff,
    /// Plus.
    Plus,
    /// Minus.
    Minus,
    /// An arrow in a circle.
    Retry,
    /// A padlock.
    Lock,
    /// A picture.
    Picture,
    /// A chevron downwards.
    Down,
    /// A chevron to the right.
    Right,
    /// A chevron to the left.
    Left,
    /// A folder.
    Folder,
    /// Two arrows against each other.
    Swap,
}

/// Draws in a unit square that is fitted into a rectangle.
struct Pen<'a> {
    painter: &'a Painter,
    rect: Rect,
    colour: Color32,
}

impl Pen<'_> {
    fn at(&self, x: f32, y: f32) -> Pos2 {
        self.rect.min + vec2(x, y) * self.rect.width()
    }

    fn stroke(&self) -> Stroke {
        Stroke::new((self.rect.width() / 10.0).max(1.25), self.colour)
    }

    fn line(&self, points: &[(f32, f32)]) {
        let points = points.iter().map(|(x, y)| self.at(*x, *y)).collect();
        self.painter.add(Shape::line(points, self.stroke()));
    }

    fn closed(&self, points: &[(f32, f32)]) {
        let points = points.iter().map(|(x, y)| self.at(*x, *y)).collect();
        self.painter.add(Shape::closed_line(points, self.stroke()));
    }

    fn full(&self, points: &[(f32, f32)]) {
        let points = points.iter().map(|(x, y)| self.at(*x, *y)).collect();
        self.painter.add(Shape::convex_polygon(points, self.colour, Stroke::NONE));
    }

    fn circle(&self, x: f32, y: f32, radius: f32) {
        self.painter.circle_stroke(self.at(x, y), radius * self.rect.width(), self.stroke());
    }

    fn disc(&self, x: f32, y: f32, radius: f32) {
        self.painter.circle_filled(self.at(x, y), radius * self.rect.width(), self.colour);
    }

    fn arc(&self, x: f32, y: f32, radius: f32, from: f32, to: f32, filled: bool) {
        let steps = 20;
        let points: Vec<Pos2> = (0..=steps)
            .map(|step| {
                let angle = (from + (to - from) * step as f32 / steps as f32).to_radians();
                self.at(x + radius * angle.cos(), y + radius * angle.sin())
            })
            .collect();
        let shape = if filled {
            Shape::convex_polygon(points, self.colour, Stroke::NONE)
        } else {
            Shape::Path(PathShape {
                points,
                closed: false,
                fill: Color32::TRANSPARENT,
                stroke: PathStroke::from(self.stroke()),
            })
        };
        self.painter.add(shape);
    }

    fn bar(&self, x: f32) {
        self.full(&[(x - 0.06, 0.2), (x + 0.06, 0.2), (x + 0.06, 0.8), (x - 0.06, 0.8)]);
    }

    fn triangle(&self, x: f32, toward: f32) {
        self.full(&[(x, 0.2), (x + toward, 0.5), (x, 0.8)]);
    }
}

impl Icon {
    /// Side of the square glyphs are drawn in, points.
    pub const SIZE: f32 = 14.0;

    /// Draws the glyph into the middle of `rect`.
    pub fn paint(self, painter: &Painter, rect: Rect, colour: Color32) {
        let side = rect.width().min(rect.height());
        let pen = Pen { painter, rect: Rect::from_center_size(rect.center(), Vec2::splat(side)), colour };
        match self {
            Self::Ring
            | Self::HalfRing
            | Self::Dot
            | Self::Warning
            | Self::Check
            | Self::Cross
            | Self::Flag
            | Self::Diamond
            | Self::Lock => self.paint_state(&pen),
            Self::Play
            | Self::Pause
            | Self::Stop
            | Self::Previous
            | Self::Next
            | Self::First
            | Self::Last => {
                self.paint_transport(&pen);
            }
            _ => self.paint_tool(&pen),
        }
    }

    fn paint_state(self, pen: &Pen<'_>) {
        match self {
            Self::HalfRing => {
                pen.circle(0.5, 0.5, 0.32);
                pen.arc(0.5, 0.5, 0.32, -90.0, 90.0, true);
            }
            Self::Dot => pen.disc(0.5, 0.5, 0.32),
            Self::Warning => pen.full(&[(0.5, 0.14), (0.9, 0.82), (0.1, 0.82)]),
            Self::Check => pen.line(&[(0.16, 0.54), (0.4, 0.78), (0.86, 0.24)]),
            Self::Cross => {
                pen.line(&[(0.22, 0.22), (0.78, 0.78)]);
                pen.line(&[(0.78, 0.22), (0.22, 0.78)]);
            }
            Self::Flag => {
                pen.line(&[(0.25, 0.1), (0.25, 0.92)]);
                pen.full(&[(0.25, 0.12), (0.86, 0.32), (0.25, 0.56)]);
            }
            Self::Diamond => pen.full(&[(0.5, 0.1), (0.9, 0.5), (0.5, 0.9), (0.1, 0.5)]),
            Self::Lock => {
                pen.arc(0.5, 0.46, 0.2, 180.0, 360.0, false);
                pen.full(&[(0.2, 0.46), (0.8, 0.46), (0.8, 0.88), (0.2, 0.88)]);
            }
            _ => pen.circle(0.5, 0.5, 0.32),
        }
    }

    fn paint_transport(self, pen: &Pen<'_>) {
        match self {
            Self::Pause => {
                for x in [0.34, 0.66] {
                    pen.full(&[(x - 0.09, 0.2), (x + 0.09, 0.2), (x + 0.09, 0.8), (x - 0.09, 0.8)]);
                }
            }
            Self::Stop => pen.full(&[(0.22, 0.22), (0.78, 0.22), (0.78, 0.78), (0.22, 0.78)]),
            Self::Previous => {
                pen.triangle(0.62, -0.42);
                pen.bar(0.76);
            }
            Self::Next => {
                pen.triangle(0.38, 0.42);
                pen.bar(0.24);
            }
            Self::First => {
                pen.bar(0.14);
                pen.triangle(0.56, -0.34);
                pen.triangle(0.9, -0.34);
            }
            Self::Last => {
                pen.triangle(0.1, 0.34);
                pen.triangle(0.44, 0.34);
                pen.bar(0.86);
            }
            _ => pen.full(&[(0.26, 0.14), (0.84, 0.5), (0.26, 0.86)]),
        }
    }

    fn paint_tool(self, pen: &Pen<'_>) {
        match self {
            Self::Menu => {
                for y in [0.24, 0.5, 0.76] {
                    pen.line(&[(0.12, y), (0.88, y)]);
                }
            }
            Self::Undo => {
                pen.arc(0.52, 0.6, 0.3, 190.0, 380.0, false);
                pen.full(&[(0.02, 0.44), (0.42, 0.44), (0.2, 0.72)]);
            }
            Self::Redo => {
                pen.arc(0.48, 0.6, 0.3, 160.0, 350.0, false);
                pen.full(&[(0.98, 0.44), (0.58, 0.44), (0.8, 0.72)]);
            }
            Self::Search => {
                pen.circle(0.42, 0.42, 0.28);
                pen.line(&[(0.63, 0.63), (0.9, 0.9)]);
            }
            Self::Keys => {
                pen.closed(&[(0.04, 0.24), (0.96, 0.24), (0.96, 0.78), (0.04, 0.78)]);
                pen.line(&[(0.3, 0.62), (0.7, 0.62)]);
                for x in [0.24, 0.5, 0.76] {
                    pen.disc(x, 0.42, 0.06);
                }
            }
            Self::Eye | Self::EyeOff => {
                pen.line(&[(0.04, 0.5), (0.26, 0.3), (0.5, 0.24), (0.74, 0.3), (0.96, 0.5)]);
                pen.line(&[(0.04, 0.5), (0.26, 0.7), (0.5, 0.76), (0.74, 0.7), (0.96, 0.5)]);
                if self == Self::Eye {
                    pen.disc(0.5, 0.5, 0.15);
                } else {
                    pen.line(&[(0.16, 0.9), (0.84, 0.1)]);
                }
            }
            Self::Plus => {
                pen.line(&[(0.5, 0.16), (0.5, 0.84)]);
                pen.line(&[(0.16, 0.5), (0.84, 0.5)]);
            }
            Self::Minus => pen.line(&[(0.16, 0.5), (0.84, 0.5)]),
            Self::Retry => {
                pen.arc(0.5, 0.52, 0.32, -40.0, 260.0, false);
                pen.full(&[(0.56, 0.02), (0.98, 0.16), (0.66, 0.44)]);
            }
            Self::Picture => {
                pen.closed(&[(0.08, 0.18), (0.92, 0.18), (0.92, 0.82), (0.08, 0.82)]);
                pen.line(&[(0.14, 0.74), (0.38, 0.46), (0.56, 0.66), (0.7, 0.54), (0.86, 0.72)]);
                pen.disc(0.68, 0.36, 0.07);
            }
            Self::Down => pen.line(&[(0.22, 0.36), (0.5, 0.66), (0.78, 0.36)]),
            Self::Left => pen.line(&[(0.64, 0.22), (0.34, 0.5), (0.64, 0.78)]),
            Self::Folder => pen.closed(&[
                (0.06, 0.2),
                (0.38, 0.2),
                (0.48, 0.32),
                (0.94, 0.32),
                (0.94, 0.82),
                (0.06, 0.82),
            ]),
            Self::Swap => {
                pen.line(&[(0.1, 0.34), (0.86, 0.34), (0.66, 0.14)]);
                pen.line(&[(0.9, 0.66), (0.14, 0.66), (0.34, 0.86)]);
            }
            _ => pen.line(&[(0.36, 0.22), (0.66, 0.5), (0.36, 0.78)]),
        }
    }

    /// The glyph for use in a button, in the button's own text colour.
    pub fn atom(self) -> Atom<'static> {
        Atom::paint(Vec2::splat(Self::SIZE), move |ui, args| {
            self.paint(ui.painter(), args.rect, args.fallback_text_color);
        })
    }

    /// The glyph for use in a button, in a colour of its own.
    pub fn atom_in(self, colour: Color32) -> Atom<'static> {
        Atom::paint(Vec2::splat(Self::SIZE), move |ui, args| self.paint(ui.painter(), args.rect, colour))
    }

    /// Draws the glyph in the flow of `ui`.
    pub fn show(self, ui: &mut egui::Ui, colour: Color32) -> egui::Response {
        let (rect, response) = ui.allocate_exact_size(Vec2::splat(Self::SIZE), egui::Sense::hover());
        if ui.is_rect_visible(rect) {
            self.paint(ui.painter(), rect, colour);
        }
        response
    }

    /// Draws the glyph, `size` points wide, about `centre`.
    pub fn paint_at(self, painter: &Painter, centre: impl Into<Pos2>, size: f32, colour: Color32) {
        let centre: Pos2 = centre.into();
        self.paint(painter, Rect::from_center_size(pos2(centre.x, centre.y), Vec2::splat(size)), colour);
    }
}
