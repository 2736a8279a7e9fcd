//! The finished picture: as exported, as single layers, or beside the source.

use std::sync::Arc;

use agenticfocus::{engine::Layers, image::Rgba8};
use egui::{
    Align2, Color32, ColorImage, Context as EguiContext, CursorIcon, PointerButton, Pos2, Rect, Stroke, pos2,
    vec2,
};

use super::super::{input::PointerEvent, scene::Scene, shapes, texture::Texture};
use crate::state::{BeforeAfter, Context, LayerEye, LayerEyes};

/// How near the pointer must be to the wipe's line, points.
const HIT: f32 = 8.0;

/// Textures of the finished picture, and the wipe.
#[derive(Debug, Default)]
pub(in super::super) struct CompositeView {
    shown: Option<(Arc<Layers>, Kind, bool)>,
    whole: Texture,
    background: Texture,
    robot: Texture,
    object: Texture,
    front: Texture,
    wiping: bool,
}

/// What the textures hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Whole,
    Stack,
}

impl CompositeView {
    /// Draws the composite over the source that is drawn already; `strength` below 1 says that it is not the
    /// one for this frame and document.
    pub fn draw(
        &mut self,
        layers: &Arc<Layers>,
        strength: f32,
        nearest: bool,
        scene: &Scene<'_>,
        cx: &Context<'_>,
    ) {
        let kind = if cx.options.eyes == LayerEyes::default() { Kind::Whole } else { Kind::Stack };
        self.upload(scene.painter.ctx(), layers, kind, nearest);
        let picture = scene.projection.picture_rect();
        let painter = match cx.options.before_after {
            BeforeAfter::Before => return,
            BeforeAfter::After => scene.painter.clone(),
            BeforeAfter::Wipe(share) => {
                let line = wipe_line(picture, share);
                let right = Rect::from_min_max(pos2(line, scene.rect.min.y), scene.rect.max);
                scene.painter.with_clip_rect(scene.painter.clip_rect().intersect(right))
            }
        };
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        let draw = |texture: &Texture, eye: LayerEye| {
            if let Some(id) = texture.id().filter(|_| eye.shown) {
                let tint = Color32::WHITE.gamma_multiply(eye.opacity.clamp(0.0, 1.0) * strength);
                painter.image(id, picture, whole, tint);
            }
        };
        if strength < 1.0 {
            painter.rect_filled(picture, 0.0, cx.tokens.ground);
        }
        if kind == Kind::Whole {
            draw(&self.whole, LayerEye::default());
            return;
        }
        let eyes = cx.options.eyes;
        // Where a layer is not drawn, nothing is: the source would pretend to be part of the result.
        shapes::checkerboard(&painter, cx.tokens, picture);
        draw(&self.background, eyes.background);
        draw(&self.robot, eyes.robot);
        if layers.object.is_some() {
            draw(&self.object, eyes.object);
        }
        draw(&self.front, eyes.front);
    }

    fn upload(&mut self, context: &EguiContext, layers: &Arc<Layers>, kind: Kind, nearest: bool) {
        let same = self.shown.as_ref().is_some_and(|(shown, holds, sharp)| {
            Arc::ptr_eq(shown, layers) && *holds == kind && *sharp == nearest
        });
        if same {
            return;
        }
        self.shown = Some((Arc::clone(layers), kind, nearest));
        let extent = |width: u32, height: u32| [width as usize, height as usize];
        let size = extent(layers.composite.size().width, layers.composite.size().height);
        if kind == Kind::Whole {
            let image = ColorImage::from_rgb(size, layers.composite.data());
            self.whole.write(context, "composite", image, nearest);
            return;
        }
        let image = ColorImage::from_rgb(size, layers.background.data());
        self.background.write(context, "background", image, nearest);
        let straight = |picture: &Rgba8| {
            ColorImage::from_rgba_unmultiplied(
                extent(picture.size().width, picture.size().height),
                picture.data(),
            )
        };
        self.robot.write(context, "robot", straight(&layers.robot), nearest);
        if let Some(object) = &layers.object {
            self.object.write(context, "object", straight(object), nearest);
        }
        self.front.write(context, "robot in front", straight(&layers.front), nearest);
    }

    /// The line between before and after, which can be dragged.
    pub fn wipe(&mut self, scene: &Scene<'_>, cx: &mut Context<'_>) {
        let BeforeAfter::Wipe(share) = cx.options.before_after else {
            self.wiping = false;
            return;
        };
        let picture = scene.projection.picture_rect();
        let mut share = share;
        for event in &scene.events {
            match *event {
                PointerEvent::Press { at, button: PointerButton::Primary, .. } => {
                    self.wiping = (at.x - wipe_line(picture, share)).abs() <= HIT;
                }
                PointerEvent::Move(at) if self.wiping => {
                    share = ((at.x - picture.min.x) / picture.width().max(1.0)).clamp(0.0, 1.0);
                }
                PointerEvent::Release { .. } => self.wiping = false,
                PointerEvent::Press { .. } | PointerEvent::Move(_) => {}
            }
        }
        cx.options.before_after = BeforeAfter::Wipe(share);
        let line = wipe_line(picture, share);
        if self.wiping || scene.hover.is_some_and(|at| (at.x - line).abs() <= HIT) {
            scene.painter.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
        }
        draw_wipe(scene, cx, picture, line);
    }

    /// Lets go of the line; false when nobody held it.
    pub fn cancel(&mut self) -> bool {
        std::mem::take(&mut self.wiping)
    }
}

fn wipe_line(picture: Rect, share: f32) -> f32 {
    picture.min.x + picture.width() * share.clamp(0.0, 1.0)
}

fn draw_wipe(scene: &Scene<'_>, cx: &Context<'_>, picture: Rect, line: f32) {
    let painter = &scene.painter;
    let visible = picture.intersect(scene.rect);
    painter.vline(line, visible.y_range(), Stroke::new(4.0, shapes::rim_colour()));
    painter.vline(line, visible.y_range(), Stroke::new(2.0, Color32::WHITE));
    let grip = Rect::from_center_size(pos2(line, visible.center().y), vec2(20.0, 36.0));
    painter.rect(
        grip,
        4.0,
        Color32::WHITE,
        Stroke::new(1.0, shapes::rim_colour()),
        egui::StrokeKind::Outside,
    );
    for x in [-3.0, 3.0] {
        let middle = grip.center() + vec2(x, 0.0);
        painter.line_segment(
            [middle - vec2(0.0, 8.0), middle + vec2(0.0, 8.0)],
            Stroke::new(2.0, Color32::GRAY),
        );
    }
    let sides = [(-10.0, Align2::RIGHT_TOP, "source"), (10.0, Align2::LEFT_TOP, "composite")];
    for (x, align, text) in sides {
        let at = pos2(line + x, visible.min.y + 10.0);
        let galley =
            painter.layout_no_wrap(text.to_owned(), egui::FontId::proportional(11.0), cx.tokens.text);
        let rect = align.anchor_size(at, galley.size());
        painter.rect_filled(rect.expand2(vec2(6.0, 3.0)), 4.0, cx.tokens.panel.gamma_multiply(0.9));
        painter.galley(rect.min, galley, cx.tokens.text);
    }
}
