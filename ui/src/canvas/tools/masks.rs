//! Mask tools: brush, eraser, polygon, lasso, box and points.

use std::sync::Arc;

use agenticfocus::{
    clip::FrameIndex,
    geometry::{Pixel, Side},
    image::Mask,
    segment::RleMask,
    session::MaskLayer,
};
use egui::{CursorIcon, Modifiers, PointerButton, Pos2};

use super::{
    super::{
        input::PointerEvent,
        mask_view::{Colouring, Look, MaskView},
        onion::OnionSkin,
        scene::Scene,
        shapes,
    },
    hole::HoleOutline,
    points::Points,
    shape::{ShapeInProgress, ShapeKind},
};
use crate::{
    action::Action,
    paint::{self, Area, SideSplit},
    state::{Context, Tool},
};

/// Trust below which a machine's mask has a dashed border.
const DOUBTFUL: f64 = 0.5;

/// What the pointer is in the middle of.
#[derive(Debug)]
enum Work {
    /// A stroke of brush or eraser.
    Stroke { last: Pixel, adding: bool, button: PointerButton },
    /// A line or a box.
    Shape { shape: ShapeInProgress, button: PointerButton },
}

/// Work on one mask, from the first press until it is kept or dropped.
#[derive(Debug)]
struct Edit {
    layer: MaskLayer,
    frame: FrameIndex,
    /// The mask before.
    before: Mask,
    work: Work,
}

/// The mask tools and what they draw on.
#[derive(Debug)]
pub(in super::super) struct MaskTools {
    object: MaskView,
    arms: MaskView,
    draft: MaskView,
    onion: OnionSkin,
    hole: HoleOutline,
    split: Option<(FrameIndex, usize, Arc<SideSplit>)>,
    edit: Option<Edit>,
    pub points: Option<Points>,
}

impl Default for MaskTools {
    fn default() -> Self {
        Self {
            object: MaskView::new("object mask"),
            arms: MaskView::new("arm mask"),
            draft: MaskView::new("mask from points"),
            onion: OnionSkin::default(),
            hole: HoleOutline::default(),
            split: None,
            edit: None,
            points: None,
        }
    }
}

impl MaskTools {
    /// Whether a stroke, a shape or points wait to be finished.
    pub fn is_busy(&self) -> bool {
        self.edit.is_some() || self.points.is_some()
    }

    /// Carries out what the pointer did and draws.
    pub fn show(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>, eyes: [bool; 2]) {
        self.leave_other_frames(scene, cx);
        self.sync(scene, cx);
        for event in &scene.events {
            self.handle(*event, scene, cx);
        }
        if scene.hidden {
            return;
        }
        self.draw(scene, cx, eyes);
    }

    /// Shows masks without any tool.
    pub fn show_only(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>, layer: MaskLayer, look: Look) {
        self.sync(scene, cx);
        if !scene.hidden {
            self.view(layer).draw(&scene.painter, &scene.projection, look);
        }
    }

    /// Work belongs to the frame it was begun on: it is kept there when the clip moves on.
    fn leave_other_frames(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>) {
        if self.edit.as_ref().is_some_and(|edit| edit.frame != scene.frame) {
            let stroke = self.edit.as_ref().is_some_and(|edit| matches!(edit.work, Work::Stroke { .. }));
            if stroke { self.keep(cx) } else { self.drop_edit() }
        }
        let elsewhere =
            |points: &Points| points.frame != scene.frame || points.layer != cx.options.mask_layer;
        if self.points.as_ref().is_some_and(elsewhere) {
            self.points = None;
        }
    }

    fn sync(&mut self, scene: &Scene<'_>, cx: &Context<'_>) {
        let context = scene.painter.ctx().clone();
        let empty = || Arc::new(RleMask::empty(scene.size()));
        for layer in [MaskLayer::Arms, MaskLayer::Object] {
            let mask = scene.workspace.mask(layer, scene.frame).map_or_else(empty, |on| on.mask);
            // A mask of another clip's size would not lie on this picture.
            let mask = if mask.size() == scene.size() { mask } else { empty() };
            let colouring = self.colouring(layer, scene, cx);
            self.view_mut(layer).sync(&context, scene.frame, &mask, colouring);
        }
        if let Some(points) = &self.points {
            let mask = points.answer(scene).filter(|mask| mask.size() == scene.size()).unwrap_or_else(empty);
            let colouring = self.colouring(points.layer, scene, cx);
            self.draft.sync(&context, scene.frame, &mask, colouring);
        }
    }

    fn colouring(&mut self, layer: MaskLayer, scene: &Scene<'_>, cx: &Context<'_>) -> Colouring {
        let arms = scene.workspace.found.arms.as_ref().filter(|_| layer == MaskLayer::Arms);
        let (left, right) = (cx.tokens.left, cx.tokens.right);
        let at = scene.frame.as_usize();
        let Some(arms) = arms else {
            let one = match (layer, cx.options.side) {
                (MaskLayer::Object, _) => cx.tokens.object,
                (MaskLayer::Arms, Side::Left) => left,
                (MaskLayer::Arms, Side::Right) => right,
            };
            return Colouring::One(one);
        };
        let key = (scene.frame, Arc::as_ptr(arms) as usize);
        if self.split.as_ref().is_none_or(|(frame, track, _)| (*frame, *track) != key) {
            let sides = [&arms.sides.left, &arms.sides.right].map(|side| side.get(at));
            if let [Some(left), Some(right)] = sides {
                self.split = Some((key.0, key.1, Arc::new(SideSplit::new(left, right))));
            }
        }
        match &self.split {
            Some((.., split)) => Colouring::Sides { left, right, split: Arc::clone(split) },
            None => Colouring::One(right),
        }
    }

    fn view(&self, layer: MaskLayer) -> &MaskView {
        match layer {
            MaskLayer::Object => &self.object,
            MaskLayer::Arms => &self.arms,
        }
    }

    fn view_mut(&mut self, layer: MaskLayer) -> &mut MaskView {
        match layer {
            MaskLayer::Object => &mut self.object,
            MaskLayer::Arms => &mut self.arms,
        }
    }

    fn handle(&mut self, event: PointerEvent, scene: &Scene<'_>, cx: &mut Context<'_>) {
        match event {
            PointerEvent::Press { at, button, modifiers } => {
                let draws = matches!(button, PointerButton::Primary | PointerButton::Secondary);
                if draws && scene.is_writable() && !scene.hidden {
                    self.press(at, button, modifiers, scene, cx);
                }
            }
            PointerEvent::Move(at) => self.drag(scene.pixel(at), scene, cx),
            PointerEvent::Release { at, button } => {
                self.drag(scene.pixel(at), scene, cx);
                let closes = match &mut self.edit {
                    Some(Edit { work: Work::Shape { shape, .. }, .. }) => shape.let_go(scene),
                    _ => false,
                };
                if closes || self.edit.as_ref().is_some_and(|edit| edit.ends_with(button)) {
                    self.keep_shape(scene, cx);
                }
            }
        }
    }

    fn press(
        &mut self,
        at: Pos2,
        button: PointerButton,
        modifiers: Modifiers,
        scene: &Scene<'_>,
        cx: &mut Context<'_>,
    ) {
        let adding = (button == PointerButton::Primary) != modifiers.shift;
        let pixel = scene.pixel(at);
        cx.options.playing = false;
        let shape = |kind| Work::Shape { shape: ShapeInProgress::new(kind, adding, pixel), button };
        match cx.options.tool {
            Tool::Points => {
                let new = || Points::new(cx.options.mask_layer, scene.frame);
                let mut points = self.points.take().unwrap_or_else(new);
                points.add(pixel, adding, cx);
                self.points = Some(points);
            }
            Tool::Polygon => self.press_polygon(at, adding, button, scene, cx),
            // A second button during a stroke means nothing.
            _ if self.edit.is_some() => {}
            Tool::Brush | Tool::Eraser => {
                let adding = (cx.options.tool == Tool::Brush) == adding;
                self.begin(Work::Stroke { last: pixel, adding, button }, scene, cx);
                self.dab(pixel, scene, cx);
            }
            Tool::Lasso => self.begin(shape(ShapeKind::Lasso), scene, cx),
            Tool::Box => self.begin(shape(ShapeKind::Box), scene, cx),
        }
    }

    fn press_polygon(
        &mut self,
        at: Pos2,
        adding: bool,
        button: PointerButton,
        scene: &Scene<'_>,
        cx: &mut Context<'_>,
    ) {
        let pixel = scene.pixel(at);
        let Some(Edit { work: Work::Shape { shape, .. }, .. }) = &mut self.edit else {
            let shape = ShapeInProgress::new(ShapeKind::Polygon, adding, pixel);
            self.begin(Work::Shape { shape, button }, scene, cx);
            return;
        };
        shape.press(scene, at);
    }

    fn begin(&mut self, work: Work, scene: &Scene<'_>, cx: &Context<'_>) {
        let layer = cx.options.mask_layer;
        let view = self.view_mut(layer);
        view.hold();
        let before = view.pixels().clone();
        self.edit = Some(Edit { layer, frame: scene.frame, before, work });
    }

    fn drag(&mut self, pixel: Pixel, scene: &Scene<'_>, cx: &Context<'_>) {
        match &mut self.edit {
            Some(Edit { work: Work::Stroke { .. }, .. }) => self.dab(pixel, scene, cx),
            Some(Edit { work: Work::Shape { shape, .. }, .. }) => shape.drag_to(pixel),
            None => {}
        }
    }

    /// Moves the brush to `pixel`.
    fn dab(&mut self, pixel: Pixel, scene: &Scene<'_>, cx: &Context<'_>) {
        let Some(mut edit) = self.edit.take() else { return };
        if let Work::Stroke { last, adding, .. } = &mut edit.work {
            let (from, adding) = (std::mem::replace(last, pixel), *adding);
            let radius = f64::from(cx.options.brush_radius);
            let context = scene.painter.ctx().clone();
            let fence = self.fence(&edit, cx);
            self.view_mut(edit.layer).change(&context, |mask| {
                fenced(mask, &edit.before, fence, |mask| paint::stroke(mask, from, pixel, radius, adding))
            });
        }
        self.edit = Some(edit);
    }

    /// What keeps an edit of one arm from the other; `None` where the object is edited, or nobody knows the arms.
    fn fence(&self, edit: &Edit, cx: &Context<'_>) -> Option<(Arc<SideSplit>, Side)> {
        let known = self.split.as_ref().filter(|(frame, ..)| *frame == edit.frame);
        let split = known.filter(|_| edit.layer == MaskLayer::Arms).map(|(.., split)| Arc::clone(split));
        Some((split?, cx.options.side))
    }

    /// Puts the shape into the mask, if there is one, and keeps the mask.
    fn keep_shape(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>) {
        if let Some(edit) = self.edit.take() {
            if let Work::Shape { shape, .. } = &edit.work {
                let context = scene.painter.ctx().clone();
                let fence = self.fence(&edit, cx);
                let fill = |mask: &mut Mask| fenced(mask, &edit.before, fence, |mask| shape.fill(mask));
                self.view_mut(edit.layer).change(&context, fill);
            }
            self.edit = Some(edit);
        }
        self.keep(cx);
    }

    /// Hands the mask on, if anything about it changed.
    fn keep(&mut self, cx: &mut Context<'_>) {
        let Some(Edit { layer, frame, before, .. }) = self.edit.take() else { return };
        let view = self.view_mut(layer);
        let mask = view.pixels().clone();
        view.release();
        if mask != before {
            cx.ask(Action::ChangeMask { layer, frame, mask });
        }
    }

    fn drop_edit(&mut self) {
        if let Some(edit) = self.edit.take() {
            self.view_mut(edit.layer).release();
        }
    }

    /// Drops what is not finished; false when there was nothing.
    pub fn cancel(&mut self) -> bool {
        let busy = self.is_busy();
        self.drop_edit();
        self.points = None;
        busy
    }

    /// Closes the polygon or takes the mask that was made from points; false when there was nothing to
    /// finish.
    pub fn finish(&mut self, cx: &mut Context<'_>) -> bool {
        if matches!(&self.edit, Some(Edit { work: Work::Shape { .. }, .. }))
            && let Some(edit) = self.edit.take()
        {
            if let Work::Shape { shape, .. } = &edit.work {
                let fence = self.fence(&edit, cx);
                // The texture follows as soon as the session has the mask.
                let fill = |mask: &mut Mask| fenced(mask, &edit.before, fence, |mask| shape.fill(mask));
                self.view_mut(edit.layer).change_unseen(fill);
            }
            self.edit = Some(edit);
            self.keep(cx);
            return true;
        }
        let Some(points) = &self.points else { return false };
        let draft = cx.workspace.and_then(|workspace| workspace.draft.as_ref());
        let answered = draft.filter(|draft| {
            draft.frame == points.frame
                && draft.positive == points.positive
                && draft.negative == points.negative
        });
        if let Some(mask) = answered.and_then(|draft| draft.mask.as_ref()) {
            let (layer, frame) = (points.layer, points.frame);
            let mut mask = mask.decode();
            // Points mean one arm; the other one stays.
            let others = cx.workspace.filter(|_| layer == MaskLayer::Arms);
            if let Some(arms) = others.and_then(|workspace| workspace.mask_pixels(layer, frame))
                && arms.size() == mask.size()
            {
                mask = mask.union(&arms);
            }
            cx.ask(Action::ChangeMask { layer, frame, mask });
            self.points = None;
        }
        true
    }

    fn draw(&mut self, scene: &Scene<'_>, cx: &Context<'_>, eyes: [bool; 2]) {
        let edited = cx.options.mask_layer;
        let order = match edited {
            MaskLayer::Object => [MaskLayer::Arms, MaskLayer::Object],
            MaskLayer::Arms => [MaskLayer::Object, MaskLayer::Arms],
        };
        for layer in order {
            let shown = eyes[usize::from(layer == MaskLayer::Arms)] || layer == edited;
            if shown {
                let on = scene.workspace.mask_summary(layer, scene.frame);
                let strength = if layer == edited { 1.0 } else { 0.4 };
                let look = Look {
                    fill: cx.options.mask_opacity * strength,
                    line: if layer == edited { 2.0 } else { 1.0 },
                    dashed: self.edit.is_none() && on.is_some_and(|(_, score, _)| score < DOUBTFUL),
                    arm: (edited == MaskLayer::Arms).then_some(cx.options.side),
                };
                self.view(layer).draw(&scene.painter, &scene.projection, look);
            }
        }
        if cx.options.onion_skin {
            let colour = match edited {
                MaskLayer::Object => cx.tokens.object,
                MaskLayer::Arms => cx.tokens.text,
            };
            self.onion.draw(scene, edited, colour);
        }
        self.hole.show(scene, cx);
        self.draw_work(scene, cx);
    }

    fn draw_work(&self, scene: &Scene<'_>, cx: &Context<'_>) {
        let colour = cx.tokens.accent;
        if let Some(points) = &self.points {
            let look = Look { fill: 0.5, line: 2.0, dashed: true, arm: None };
            self.draft.draw(&scene.painter, &scene.projection, look);
            points.draw(scene, cx);
        }
        if let Some(Edit { work: Work::Shape { shape, .. }, .. }) = &self.edit {
            shape.draw(scene, colour);
        }
        self.draw_pointer(scene, cx);
    }

    /// The brush's footprint, or a cross for other tools.
    fn draw_pointer(&self, scene: &Scene<'_>, cx: &Context<'_>) {
        let Some(at) = scene.hover else { return };
        let context = scene.painter.ctx();
        if !scene.is_writable() {
            context.set_cursor_icon(CursorIcon::NotAllowed);
            return;
        }
        context.set_cursor_icon(CursorIcon::Crosshair);
        if !matches!(cx.options.tool, Tool::Brush | Tool::Eraser) {
            return;
        }
        let adding = match &self.edit {
            Some(Edit { work: Work::Stroke { adding, .. }, .. }) => *adding,
            _ => (cx.options.tool == Tool::Brush) != scene.shift,
        };
        let radius = cx.options.brush_radius * scene.projection.scale;
        shapes::brush_ring(&scene.painter, at, radius, !adding);
    }

    /// The mask on which commands for a whole mask work: none while a stroke is in progress.
    pub fn whole_mask(&self, cx: &Context<'_>) -> Option<(FrameIndex, Mask)> {
        let workspace = cx.workspace.filter(|workspace| workspace.is_writable() && self.edit.is_none())?;
        Some((workspace.playhead, workspace.mask_pixels(cx.options.mask_layer, workspace.playhead)?))
    }
}

/// Changes `mask` by `change`, but for what is taken from the arm beyond the fence.
fn fenced(
    mask: &mut Mask,
    before: &Mask,
    fence: Option<(Arc<SideSplit>, Side)>,
    change: impl FnOnce(&mut Mask) -> Option<Area>,
) -> Option<Area> {
    let area = change(mask)?;
    if let Some((split, side)) = fence {
        split.protect_other(mask, before, area, side);
    }
    Some(area)
}

impl Edit {
    /// Whether letting go of `button` ends the work; a polygon goes on.
    fn ends_with(&self, released: PointerButton) -> bool {
        match &self.work {
            Work::Stroke { button, .. } => *button == released,
            Work::Shape { shape, button } => shape.kind != ShapeKind::Polygon && *button == released,
        }
    }
}
