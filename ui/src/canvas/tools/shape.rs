//! A line or a box that is being drawn and is to become part of a mask.

use agenticfocus::{
    geometry::{Pixel, PixelBox},
    image::Mask,
};
use egui::{Color32, Pos2};

use super::super::{scene::Scene, shapes};
use crate::paint::{self, Area};

/// A click this near the first corner closes a polygon, points.
const CLOSES: f32 = 9.0;
/// A press this near another corner takes hold of it, points.
const HOLDS: f32 = 6.0;
/// A corner that was moved less than this was clicked, points.
const CLICKED: f32 = 4.0;

/// What kind of shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum ShapeKind {
    /// Corner by corner.
    Polygon,
    /// Drawn by hand.
    Lasso,
    /// Between two corners.
    Box,
}

/// A shape in progress.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct ShapeInProgress {
    pub kind: ShapeKind,
    /// Adds to the mask, or takes away from it.
    pub adding: bool,
    pub corners: Vec<Pixel>,
    /// The corner that is being moved, and where it was.
    held: Option<(usize, Pixel)>,
}

impl ShapeInProgress {
    pub fn new(kind: ShapeKind, adding: bool, at: Pixel) -> Self {
        Self { kind, adding, corners: vec![at], held: None }
    }

    /// Follows the pointer of a drag.
    pub fn drag_to(&mut self, at: Pixel) {
        match self.kind {
            ShapeKind::Box => {
                self.corners.truncate(1);
                self.corners.push(at);
            }
            ShapeKind::Lasso => self.corners.push(at),
            ShapeKind::Polygon => {
                if let Some((corner, _)) = self.held {
                    self.corners[corner] = at;
                }
            }
        }
    }

    /// A press on a polygon: takes hold of the corner there, or adds one.
    pub fn press(&mut self, scene: &Scene<'_>, at: Pos2) {
        self.held = self.corner_at(scene, at).map(|corner| (corner, self.corners[corner]));
        let pixel = scene.pixel(at);
        if self.held.is_none() && self.corners.last().is_none_or(|last| last.distance(pixel) > 0.5) {
            self.corners.push(pixel);
        }
    }

    /// Lets go of a corner; true where the first one was only clicked, which closes the polygon.
    pub fn let_go(&mut self, scene: &Scene<'_>) -> bool {
        let Some((corner, from)) = self.held.take() else { return false };
        let place = |pixel: Pixel| scene.projection.to_screen(pixel);
        let clicked = place(from).distance(place(self.corners[corner])) <= CLICKED;
        if clicked {
            self.corners[corner] = from;
        }
        clicked && corner == 0 && self.corners.len() >= 3
    }

    /// The corner under the pointer: the first one where it closes the polygon, else the nearest.
    fn corner_at(&self, scene: &Scene<'_>, at: Pos2) -> Option<usize> {
        let distance = |corner: &Pixel| scene.projection.to_screen(*corner).distance(at);
        if self.corners.len() >= 3 && distance(&self.corners[0]) <= CLOSES {
            return Some(0);
        }
        let near = self.corners.iter().map(distance).enumerate().filter(|(_, distance)| *distance <= HOLDS);
        near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(corner, _)| corner)
    }

    /// Puts the shape into a mask.
    pub fn fill(&self, mask: &mut Mask) -> Option<Area> {
        match (self.kind, self.corners.as_slice()) {
            (ShapeKind::Box, [from, to]) => paint::fill_box(mask, &box_between(*from, *to), self.adding),
            (ShapeKind::Box, _) => None,
            (_, corners) => paint::fill_polygon(mask, corners, self.adding),
        }
    }

    pub fn draw(&self, scene: &Scene<'_>, colour: Color32) {
        let painter = &scene.painter;
        let style = shapes::LineStyle { width: 2.0, colour, dashed: !self.adding };
        let mut points: Vec<Pos2> = self.corners.iter().map(|at| scene.projection.to_screen(*at)).collect();
        if let (ShapeKind::Box, [from, to]) = (self.kind, points.as_slice()) {
            let rect = egui::Rect::from_two_pos(*from, *to);
            painter.rect_filled(rect, 0.0, colour.gamma_multiply(0.2));
            shapes::rimmed_line(painter, &shapes::corners(rect), true, style);
            return;
        }
        if self.kind == ShapeKind::Polygon {
            let under = scene.hover.and_then(|at| self.corner_at(scene, at));
            let lit = self.held.map(|(corner, _)| corner).or(under);
            let fixed = points.clone();
            points.extend(match lit {
                // A click closes the polygon.
                Some(0) if self.held.is_none() && fixed.len() >= 3 => fixed.first().copied(),
                Some(_) => None,
                None => scene.hover,
            });
            shapes::rimmed_line(painter, &points, false, style);
            for (at, corner) in fixed.iter().enumerate() {
                shapes::handle(painter, *corner, colour, lit == Some(at));
            }
        } else {
            shapes::rimmed_line(painter, &points, true, style);
        }
    }
}

/// The box between two positions, which count from pixel centres while boxes count from corners.
pub(in super::super) fn box_between(from: Pixel, to: Pixel) -> PixelBox {
    let corner = |at: Pixel| Pixel::new(at.x + 0.5, at.y + 0.5);
    PixelBox::from_corners(corner(from), corner(to))
}
