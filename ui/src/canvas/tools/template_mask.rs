//! The mask that cuts the template out of its clean frame, painted with the brush.

use std::sync::Arc;

use agenticfocus::{clip::FrameIndex, geometry::Pixel, image::Mask, segment::RleMask, session::MaskLayer};
use egui::{CursorIcon, PointerButton};

use super::super::{
    input::PointerEvent,
    mask_view::{Colouring, Look, MaskView},
    scene::Scene,
    shapes,
};
use crate::{
    action::Action,
    paint,
    state::{Context, Workspace},
};

#[derive(Debug)]
struct StrokeInProgress {
    last: Pixel,
    adding: bool,
    button: PointerButton,
    before: Mask,
}

/// Painting the template's mask, where the operator asked for that.
#[derive(Debug)]
pub(in super::super) struct TemplateMaskTool {
    view: MaskView,
    /// The frame it is painted on; `None` while the template is placed instead.
    painting: Option<FrameIndex>,
    stroke: Option<StrokeInProgress>,
}

impl Default for TemplateMaskTool {
    fn default() -> Self {
        Self { view: MaskView::new("template mask"), painting: None, stroke: None }
    }
}

/// The frame the template is cut from: the person's choice, else the machine's.
fn clean_frame(workspace: &Workspace) -> Option<FrameIndex> {
    let chosen = workspace.document().template.frame;
    chosen.or_else(|| workspace.found.template.as_ref().map(|template| template.frame))
}

/// The template's mask as it stands: the person's, else the object's on that frame.
fn mask_now(workspace: &Workspace, frame: FrameIndex) -> Option<Arc<RleMask>> {
    let drawn = workspace.document().template.mask.as_ref();
    let drawn = drawn.and_then(|id| workspace.masks.get(id)).cloned();
    drawn.or_else(|| workspace.mask(MaskLayer::Object, frame).map(|on| on.mask))
}

impl TemplateMaskTool {
    /// Starts painting on the clean frame, or goes back to placing.
    pub fn toggle(&mut self, cx: &mut Context<'_>) {
        self.drop_stroke();
        if self.painting.take().is_some() {
            return;
        }
        let Some(workspace) = cx.workspace else { return };
        self.painting = clean_frame(workspace);
        if let Some(frame) = self.painting.filter(|frame| *frame != workspace.playhead) {
            cx.ask(Action::Seek(frame));
        }
    }

    /// Whether it is painted on `frame`.
    pub fn is_on(&self, frame: FrameIndex) -> bool {
        self.painting == Some(frame)
    }

    /// Carries out what the pointer did and draws; false where the template is placed instead.
    pub fn show(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>) -> bool {
        if !self.is_on(scene.frame) || clean_frame(scene.workspace) != self.painting {
            return false;
        }
        let mask = mask_now(scene.workspace, scene.frame).filter(|mask| mask.size() == scene.size());
        let mask = mask.unwrap_or_else(|| Arc::new(RleMask::empty(scene.size())));
        let context = scene.painter.ctx().clone();
        self.view.sync(&context, scene.frame, &mask, Colouring::One(cx.tokens.template));
        for event in &scene.events {
            self.handle(*event, scene, cx);
        }
        if scene.hidden {
            return true;
        }
        let look = Look { fill: cx.options.mask_opacity, line: 2.0, ..Look::default() };
        self.view.draw(&scene.painter, &scene.projection, look);
        if let Some(at) = scene.hover.filter(|_| scene.is_writable()) {
            context.set_cursor_icon(CursorIcon::Crosshair);
            let radius = cx.options.brush_radius * scene.projection.scale;
            let taking = self.stroke.as_ref().map_or(scene.shift, |stroke| !stroke.adding);
            shapes::brush_ring(&scene.painter, at, radius, taking);
        }
        true
    }

    fn handle(&mut self, event: PointerEvent, scene: &Scene<'_>, cx: &mut Context<'_>) {
        match event {
            PointerEvent::Press {
                at,
                button: button @ (PointerButton::Primary | PointerButton::Secondary),
                modifiers,
            } if self.stroke.is_none() && scene.is_writable() && !scene.hidden => {
                let adding = (button == PointerButton::Primary) != modifiers.shift;
                let last = scene.pixel(at);
                self.view.hold();
                let before = self.view.pixels().clone();
                self.stroke = Some(StrokeInProgress { last, adding, button, before });
                self.dab(last, scene, cx);
            }
            PointerEvent::Press { .. } => {}
            PointerEvent::Move(at) => self.dab(scene.pixel(at), scene, cx),
            PointerEvent::Release { at, button } => {
                if self.stroke.as_ref().is_some_and(|stroke| stroke.button == button) {
                    self.dab(scene.pixel(at), scene, cx);
                    self.keep(cx);
                }
            }
        }
    }

    fn dab(&mut self, pixel: Pixel, scene: &Scene<'_>, cx: &Context<'_>) {
        let Some(stroke) = &mut self.stroke else { return };
        let (from, adding) = (std::mem::replace(&mut stroke.last, pixel), stroke.adding);
        let radius = f64::from(cx.options.brush_radius);
        let context = scene.painter.ctx().clone();
        self.view.change(&context, |mask| paint::stroke(mask, from, pixel, radius, adding));
    }

    fn keep(&mut self, cx: &mut Context<'_>) {
        let Some(stroke) = self.stroke.take() else { return };
        let mask = self.view.pixels().clone();
        self.view.release();
        if mask != stroke.before {
            cx.ask(Action::ChangeTemplateMask { mask });
        }
    }

    fn drop_stroke(&mut self) {
        if self.stroke.take().is_some() {
            self.view.release();
        }
    }

    /// Drops a stroke, or else goes back to placing; false when there was neither.
    pub fn cancel(&mut self) -> bool {
        if self.stroke.is_some() {
            self.drop_stroke();
            return true;
        }
        self.painting.take().is_some()
    }
}
