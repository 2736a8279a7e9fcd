//! What every tool is handed.

use agenticfocus::{
    clip::FrameIndex,
    geometry::{Pixel, Size},
};
use egui::{Painter, Pos2, Rect};

use super::{input::PointerEvent, view::Projection};
use crate::state::Workspace;

/// The canvas as a tool sees it on one frame of the window.
pub(super) struct Scene<'a> {
    pub workspace: &'a Workspace,
    /// The clip's frame on screen.
    pub frame: FrameIndex,
    pub projection: Projection,
    /// Draws over the picture, within the canvas.
    pub painter: Painter,
    /// The part of the window that pictures are drawn in.
    pub rect: Rect,
    /// What the pointer did; empty while it moves the picture.
    pub events: Vec<PointerEvent>,
    /// Where the pointer is, if it is over the canvas and over nothing else.
    pub hover: Option<Pos2>,
    /// Shift is held: tools do the opposite.
    pub shift: bool,
    /// Masks are not to be seen now.
    pub hidden: bool,
}

impl Scene<'_> {
    /// The picture's size.
    pub fn size(&self) -> Size {
        self.projection.size
    }

    /// The position of the picture at `at`.
    pub fn pixel(&self, at: Pos2) -> Pixel {
        self.projection.to_picture(at)
    }

    /// Whether tools may change anything.
    pub fn is_writable(&self) -> bool {
        self.workspace.is_writable()
    }
}
