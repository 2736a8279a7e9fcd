//! The canvas: the picture, what lies over it, and what the pointer does with it.

mod aim;
mod caption;
mod cards;
mod chrome;
mod input;
mod mask_view;
mod onion;
mod perform;
mod scene;
mod shapes;
mod source_view;
mod texture;
mod tools;
mod view;

use std::{path::PathBuf, sync::Arc};

use agenticfocus::{
    engine::Layers,
    session::{MaskLayer, Step},
};
use egui::{
    Color32, Key, PointerButton, Pos2, Rect, Response, Sense, Shape, Ui, Vec2, WidgetInfo, accesskit::Role,
    pos2, vec2,
};

use self::{
    aim::Aim,
    chrome::Pressed,
    input::{PointerEvent, pointer_events},
    mask_view::Look,
    scene::Scene,
    source_view::{Patience, SourceView},
    tools::{
        composite::CompositeView, hands::HandTools, masks::MaskTools, object::ObjectTools,
        template::TemplateTools, template_mask::TemplateMaskTool, wrists,
    },
};
use crate::state::{BeforeAfter, Context, Workspace};

pub use view::{Projection, View};

/// Screen pixels a picture pixel from which pixels are shown as squares.
const SQUARE_PIXELS: f32 = 4.0;
/// Height of the strips above and below the picture, points.
const STRIP: f32 = 32.0;
/// Space around a picture that is fitted in, points.
const MARGIN: f32 = 8.0;

/// The canvas.
#[derive(Debug, Default)]
pub struct Canvas {
    view: View,
    source: SourceView,
    composite: CompositeView,
    composite_patience: Patience,
    fresh: Freshness,
    masks: MaskTools,
    object: ObjectTools,
    template: TemplateTools,
    template_mask: TemplateMaskTool,
    hands: HandTools,
    /// Whether the object's and the arms' masks are shown where they are not edited.
    eyes: Eyes,
    /// The step that was shown last.
    step: Step,
    /// The button that moves the picture, and where the pointer was last.
    panning: Option<(PointerButton, Pos2)>,
    took_space: bool,
    /// Pointing by keyboard.
    aim: Option<Aim>,
    /// A button was down when events were last read.
    was_down: bool,
    /// Where pictures were drawn last, and how.
    last: Option<(Rect, Projection)>,
    /// The session that was shown last.
    session: Option<PathBuf>,
}

/// What is shown where the composite belongs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Freshness {
    /// Nothing was made yet (default).
    #[default]
    Missing,
    /// The source was asked for.
    Source,
    /// The composite of another frame or document.
    Old,
    /// The composite of this frame and document.
    Exact,
}

/// Which masks are shown beside the edited one.
#[derive(Clone, Copy, Debug)]
struct Eyes {
    object: bool,
    arms: bool,
}

impl Default for Eyes {
    fn default() -> Self {
        Self { object: true, arms: true }
    }
}

impl Canvas {
    /// Draws the canvas into all of `ui` and carries out what the pointer does there.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let whole = ui.available_rect_before_wrap();
        ui.advance_cursor_after_rect(whole);
        // Filled in once it is known what will cover it: pixels drawn twice cost twice.
        let ground = ui.painter().add(Shape::Noop);
        let (painter, colour) = (ui.painter().clone(), cx.tokens.ground);
        let fill = |covered| painter.set(ground, Shape::Vec(ground_shapes(whole, covered, colour)));
        fill(None);
        let Some(workspace) = cx.workspace else {
            self.forget();
            cards::no_clip(ui, cx, whole);
            return;
        };
        self.notice_session(workspace);
        let Some(size) = workspace.size() else {
            cards::no_pictures(ui, cx, whole, workspace);
            return;
        };
        let rect = Rect::from_min_max(whole.min + vec2(0.0, STRIP), whole.max - vec2(0.0, STRIP));
        // Neither Tab nor a click moves the keyboard here: keys are commands of the whole window, unless one points
        // with them.
        let keyboard = if self.aim.is_some() { Sense::FOCUSABLE } else { Sense::empty() };
        let response = ui.interact(rect, ui.scope_id().with("canvas"), Sense::CLICK | Sense::DRAG | keyboard);
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Canvas"));
        let inner = rect.shrink(MARGIN);
        let points = ui.ctx().pixels_per_point();
        let projection = self.view.projection(inner, size, points);
        self.last = Some((inner, projection));
        self.zoom_by_wheel(ui, &response, cx);
        let mut events = pointer_events(ui, &response, &mut self.was_down);
        self.pan(ui, &mut events);
        let projection = self.view.projection(inner, size, points);
        self.last = Some((inner, projection));
        self.aim = self.aim.take().and_then(|mut aim| aim.holds_keyboard(ui, &response).then_some(aim));
        if let Some(aim) = &mut self.aim {
            events.extend(aim.events(ui, &projection));
        }
        let aimed = self.aim.map(|aim| projection.to_screen(aim.at()));
        let peeking = ui.input(|input| input.key_down(Key::H) && input.modifiers.is_none());
        let scene = Scene {
            workspace,
            frame: workspace.playhead,
            projection,
            painter: ui.painter_at(rect),
            rect,
            events,
            hover: aimed.or_else(|| response.hover_pos().filter(|_| self.panning.is_none())),
            shift: ui.input(|input| input.modifiers.shift),
            hidden: cx.options.masks_hidden || (peeking && !ui.ctx().egui_wants_keyboard_input()),
        };
        if self.draw(&scene, cx) {
            let covered = scene.projection.picture_rect().intersect(rect);
            fill(Some(covered));
        }
        if let Some(aim) = &self.aim {
            aim.draw(&scene.painter, &scene.projection, cx.tokens.accent);
        }
        let points = match cx.options.step {
            Step::Object => self.object.points.as_ref(),
            Step::Masks => self.masks.points.as_ref(),
            _ => None,
        };
        let caption = if self.aim.is_some() {
            (None, "Arrows move, Space presses, Escape ends".to_owned())
        } else if cx.options.step == Step::Template && self.template_mask.is_on(scene.frame) {
            (None, "Left adds, right takes away, Alt and wheel size".to_owned())
        } else {
            caption::caption(cx, &scene, points, self.fresh)
        };
        chrome::tool_strip(ui, cx, self.pressed(&scene), caption, whole);
        chrome::view_strip(ui, cx, &scene, &mut self.eyes, whole);
        cards::fault(ui, cx, &scene);
        cards::drop_hint(ui, cx.tokens, rect);
    }

    /// What the strip of tools shows pressed in that options do not tell.
    fn pressed(&self, scene: &Scene<'_>) -> Pressed {
        Pressed { object: self.object.tool, template_mask: self.template_mask.is_on(scene.frame) }
    }

    /// Whether Space moved the picture since the last call; if so, letting go of it means nothing more.
    pub fn took_space(&mut self) -> bool {
        std::mem::take(&mut self.took_space)
    }

    /// Whether keys point at the picture.
    pub fn is_aiming(&self) -> bool {
        self.aim.is_some()
    }

    /// Another session starts with a fitted view and nothing in progress.
    fn notice_session(&mut self, workspace: &Workspace) {
        if self.session.as_ref() != Some(&workspace.folder) {
            self.forget();
            self.session = Some(workspace.folder.clone());
        }
    }

    fn forget(&mut self) {
        if self.session.take().is_some() {
            self.masks.cancel();
            self.source.clear();
            *self = Self { source: std::mem::take(&mut self.source), eyes: self.eyes, ..Self::default() };
        }
    }

    fn zoom_by_wheel(&mut self, ui: &Ui, response: &Response, cx: &mut Context<'_>) {
        let (Some(at), Some((rect, now))) = (response.hover_pos(), self.last) else { return };
        let (scroll, zoom, modifiers) =
            ui.input(|input| (input.smooth_scroll_delta(), input.zoom_delta(), input.modifiers));
        if zoom != 1.0 {
            self.view.zoom_to(now.zoom * zoom, at, rect, &now);
        } else if modifiers.alt && scroll != Vec2::ZERO {
            if matches!(cx.options.step, Step::Masks | Step::Template) {
                let radius = cx.options.brush_radius * ((scroll.x + scroll.y) * 0.005).exp();
                cx.options.brush_radius = radius.clamp(perform::BRUSHES.0, perform::BRUSHES.1);
            }
        } else if scroll.y != 0.0 {
            self.view.zoom_to(now.zoom * (scroll.y * 0.004).exp(), at, rect, &now);
        } else if scroll.x != 0.0 {
            self.view.pan(vec2(scroll.x, 0.0), rect, &now);
        }
    }

    /// Moves the picture with the middle button or with Space; tools see nothing of that.
    fn pan(&mut self, ui: &Ui, events: &mut Vec<PointerEvent>) {
        let space = ui.input(|input| input.key_down(Key::Space)) && !ui.ctx().egui_wants_keyboard_input();
        let mut left = Vec::with_capacity(events.len());
        for event in events.drain(..) {
            match (event, self.panning) {
                (PointerEvent::Press { at, button, .. }, None)
                    if button == PointerButton::Middle || (space && button == PointerButton::Primary) =>
                {
                    self.panning = Some((button, at));
                    self.took_space |= button == PointerButton::Primary;
                }
                (PointerEvent::Move(at), Some((button, before))) => {
                    if let Some((rect, now)) = self.last {
                        self.view.pan(at - before, rect, &now);
                        self.last = Some((rect, self.view.projection(rect, now.size, now.zoom / now.scale)));
                    }
                    self.panning = Some((button, at));
                }
                (PointerEvent::Release { button, .. }, Some((held, _))) if held == button => {
                    self.panning = None
                }
                (_, Some(_)) => {}
                (event, None) => left.push(event),
            }
        }
        if self.panning.is_some() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Grabbing);
        } else if space && ui.rect_contains_pointer(ui.max_rect()) {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Grab);
        }
        *events = left;
    }

    /// Draws the picture and what lies over it; whether the picture covers all of its place.
    fn draw(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>) -> bool {
        let sharp = scene.projection.zoom >= SQUARE_PIXELS;
        let step = cx.options.step;
        let finished = matches!(step, Step::Retarget | Step::Composite | Step::Review);
        let composite = finished.then(|| self.composite_here(scene, cx)).flatten();
        let hidden = composite.is_some() && cx.options.before_after == BeforeAfter::After;
        if hidden {
            // It is there at once when it is asked for.
            cx.pictures.source(scene.frame);
        } else if !self.source.draw(sharp, scene, cx) {
            // The picture's place, so that nothing jumps when it comes.
            scene.painter.rect_filled(scene.projection.picture_rect(), 0.0, cx.tokens.raised);
        }
        if self.step != step {
            // What was begun in one step does not wait in another.
            self.cancel();
            self.step = step;
        }
        if let Some((layers, strength)) = composite {
            self.composite.draw(&layers, strength, sharp, scene, cx);
        }
        let faint = Look { line: 1.0, ..Look::default() };
        match step {
            Step::Object => self.object.show(scene, cx),
            Step::Masks => self.masks.show(scene, cx, [self.eyes.object, self.eyes.arms]),
            Step::Template => {
                if self.eyes.object && !self.template_mask.is_on(scene.frame) {
                    self.masks.show_only(scene, cx, MaskLayer::Object, faint);
                }
                if !self.template_mask.show(scene, cx) {
                    self.template.show(scene, cx);
                }
            }
            Step::Hands => self.hands.show(scene, cx),
            Step::Retarget => wrists::show(scene, cx),
            Step::Composite | Step::Review => self.composite.wipe(scene, cx),
        }
        hidden || self.source.is_opaque()
    }

    /// Drops what is not finished, whatever it is; false when there was nothing.
    fn cancel(&mut self) -> bool {
        let held = [
            self.masks.cancel(),
            self.object.cancel(),
            self.template.cancel() || self.template_mask.cancel(),
            self.hands.cancel(),
            self.composite.cancel(),
        ];
        held.contains(&true)
    }

    /// The composite to draw, and how strongly; `None` where there is none or the source alone is asked for.
    fn composite_here(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>) -> Option<(Arc<Layers>, f32)> {
        if cx.options.before_after == BeforeAfter::Before && cx.options.step != Step::Retarget {
            self.fresh = Freshness::Source;
            return None;
        }
        let found = cx.pictures.composite(scene.frame, scene.workspace.revision);
        let Some((layers, exact)) = found.filter(|(layers, _)| fits(layers, scene)) else {
            self.fresh = Freshness::Missing;
            return None;
        };
        self.fresh = if exact { Freshness::Exact } else { Freshness::Old };
        Some((layers, self.composite_patience.strength(exact, cx.options.playing, scene)))
    }
}

/// The ground of `whole`, but for what is `covered`: pixels drawn twice cost twice where no graphics card draws them.
fn ground_shapes(whole: Rect, covered: Option<Rect>, colour: Color32) -> Vec<Shape> {
    // The seam lies under the picture, whatever part of a pixel its edge is on.
    let covered = covered.map(|rect| rect.shrink(1.0)).filter(|rect| rect.is_positive());
    let parts = match covered {
        None => vec![whole],
        Some(inner) => vec![
            Rect::from_min_max(whole.min, pos2(whole.max.x, inner.min.y)),
            Rect::from_min_max(pos2(whole.min.x, inner.max.y), whole.max),
            Rect::from_min_max(pos2(whole.min.x, inner.min.y), pos2(inner.min.x, inner.max.y)),
            Rect::from_min_max(pos2(inner.max.x, inner.min.y), pos2(whole.max.x, inner.max.y)),
        ],
    };
    parts.into_iter().filter(Rect::is_positive).map(|part| Shape::rect_filled(part, 0.0, colour)).collect()
}

/// Layers of another clip would not lie on this picture.
fn fits(layers: &Arc<Layers>, scene: &Scene<'_>) -> bool {
    layers.composite.size() == scene.size()
}
