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
}

impl ShapeInProgress {
    pub fn new(kind: ShapeKind, adding: bool, at: Pixel) -> Self {
        Self { kind, adding, corners: vec![at] }
    }

    /// Follows the pointer of a drag.
    pub fn drag_to(&mut self, at: Pixel) {
        match self.kind {
            ShapeKind::Box => {
                self.corners.truncate(1);
                self.corners.push(at);
            }
            ShapeKind::Lasso => self.corners.push(at),
            ShapeKind::Polygon => {}
        }
    }

    /// Whether a click at `at` closes the polygon.
    pub fn closes_at(&self, scene: &Scene<'_>, at: Pos2) -> bool {
        let first = self.corners.first().map(|first| scene.projection.to_screen(*first));
        self.corners.len() >= 3 && first.is_some_and(|first| first.distance(at) <= CLOSES)
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
            let closing = scene.hover.is_some_and(|at| self.closes_at(scene, at));
            let fixed = points.clone();
            points.extend(if closing { points.first().copied() } else { scene.hover });
            shapes::rimmed_line(painter, &points, false, style);
            for (at, corner) in fixed.iter().enumerate() {
                shapes::handle(painter, *corner, colour, at == 0 && closing);
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
