//! Commands that the canvas carries out.

use agenticfocus::{
    geometry::Side,
    session::{MaskLayer, Step},
};

use super::{
    Canvas,
    aim::Aim,
    tools::{
        object::ObjectTool,
        template::{nudged, scale, shift},
    },
};
use crate::{
    action::Action,
    paint,
    state::{Context, Tool},
    ui_command::UiCommand,
};

/// Smallest and largest radius of the brush, picture pixels.
pub(super) const BRUSHES: (f32, f32) = (0.5, 400.0);
/// What a key changes the fill of masks by.
const FILL_STEP: f32 = 0.1;

impl Canvas {
    /// Carries out `command` if it concerns the canvas and there is something to carry out; false leaves it
    /// to others.
    pub fn perform(&mut self, command: UiCommand, cx: &mut Context<'_>) -> bool {
        self.perform_on_view(command)
            || perform_on_tools(self, command, cx)
            || self.perform_on_masks(command, cx)
            || perform_on_placement(command, cx)
    }

    fn perform_on_view(&mut self, command: UiCommand) -> bool {
        let Some((rect, now)) = self.last else { return false };
        match command {
            UiCommand::Fit => self.view.fit(),
            UiCommand::OneToOne => self.view.zoom_to(1.0, rect.center(), rect, &now),
            UiCommand::ZoomIn => self.view.zoom_by_steps(1.0, rect, &now),
            UiCommand::ZoomOut => self.view.zoom_by_steps(-1.0, rect, &now),
            UiCommand::Aim => {
                let seen = now.picture_rect().intersect(rect);
                self.aim =
                    if self.is_aiming() { None } else { Some(Aim::new(now.to_picture(seen.center()))) };
            }
            _ => return false,
        }
        self.last = Some((rect, self.view.projection(rect, now.size, now.zoom / now.scale)));
        true
    }

    fn perform_on_masks(&mut self, command: UiCommand, cx: &mut Context<'_>) -> bool {
        match command {
            UiCommand::FinishShape => return self.masks.finish(cx),
            UiCommand::Confirm => {
                return match cx.options.step {
                    Step::Object => self.object.finish(cx),
                    Step::Masks => self.masks.finish(cx),
                    _ => false,
                };
            }
            UiCommand::SelectNothing => return self.cancel(),
            UiCommand::TemplateMask => {
                self.template_mask.toggle(cx);
                return true;
            }
            UiCommand::FillHoles | UiCommand::Grow | UiCommand::Shrink => {}
            _ => return false,
        }
        let Some((frame, mask)) = self.masks.whole_mask(cx) else { return true };
        // Of the arms only the one that is meant.
        let arm = cx.options.arm();
        let part = arm.and_then(|side| Some(cx.workspace?.side_split(frame)?.part(&mask, side)));
        let mut changed = part.clone().unwrap_or_else(|| mask.clone());
        match command {
            UiCommand::Grow => changed = paint::grow(&changed, cx.options.grow_by),
            UiCommand::Shrink => changed = paint::shrink(&changed, cx.options.grow_by),
            _ => {
                paint::fill_holes(&mut changed);
            }
        }
        if let Some(part) = part {
            changed = changed.union(&mask.minus(&part));
        }
        if changed != mask {
            cx.ask(Action::ChangeMask { layer: cx.options.mask_layer, frame, mask: changed });
        }
        true
    }
}

fn perform_on_tools(canvas: &mut Canvas, command: UiCommand, cx: &mut Context<'_>) -> bool {
    let options = &mut *cx.options;
    match command {
        UiCommand::Brush => options.tool = Tool::Brush,
        UiCommand::Eraser => options.tool = Tool::Eraser,
        UiCommand::SwapBrush => {
            options.tool = if options.tool == Tool::Brush { Tool::Eraser } else { Tool::Brush };
        }
        UiCommand::BoxTool => options.tool = Tool::Box,
        UiCommand::Polygon => options.tool = Tool::Polygon,
        UiCommand::Lasso => options.tool = Tool::Lasso,
        UiCommand::PointsTool => options.tool = Tool::Points,
        UiCommand::LayerObject => options.mask_layer = MaskLayer::Object,
        UiCommand::LayerLeftArm => (options.mask_layer, options.side) = (MaskLayer::Arms, Side::Left),
        UiCommand::LayerRightArm => (options.mask_layer, options.side) = (MaskLayer::Arms, Side::Right),
        UiCommand::HoleOutline => options.hole_outline = !options.hole_outline,
        UiCommand::BrushSmaller | UiCommand::BrushLarger => {
            let radius = options.brush_radius;
            // A quarter, and at least half a pixel.
            let step = (radius * 0.25).max(0.5);
            let radius = if command == UiCommand::BrushLarger { radius + step } else { radius - step * 0.8 };
            options.brush_radius = ((radius * 2.0).round() / 2.0).clamp(BRUSHES.0, BRUSHES.1);
        }
        UiCommand::FillLess => options.mask_opacity = (options.mask_opacity - FILL_STEP).max(0.0),
        UiCommand::FillMore => options.mask_opacity = (options.mask_opacity + FILL_STEP).min(1.0),
        UiCommand::OnionSkin => options.onion_skin = !options.onion_skin,
        UiCommand::DrawBox => canvas.object.tool = ObjectTool::Box,
        UiCommand::DrawPoints => canvas.object.tool = ObjectTool::Points,
        _ => return false,
    }
    // Another tool means another intention: a shape begun with the last one is not finished by it.
    let switches = matches!(
        command,
        UiCommand::Brush
            | UiCommand::Eraser
            | UiCommand::SwapBrush
            | UiCommand::BoxTool
            | UiCommand::Polygon
            | UiCommand::Lasso
            | UiCommand::PointsTool
            | UiCommand::LayerObject
            | UiCommand::LayerLeftArm
            | UiCommand::LayerRightArm
    );
    if switches {
        canvas.masks.cancel();
    }
    if matches!(command, UiCommand::DrawBox | UiCommand::DrawPoints) {
        canvas.object.cancel();
    }
    true
}

fn perform_on_placement(command: UiCommand, cx: &mut Context<'_>) -> bool {
    let change = match command {
        UiCommand::NudgeLeft => nudged(cx, shift(-1.0, 0.0)),
        UiCommand::NudgeRight => nudged(cx, shift(1.0, 0.0)),
        UiCommand::NudgeUp => nudged(cx, shift(0.0, -1.0)),
        UiCommand::NudgeDown => nudged(cx, shift(0.0, 1.0)),
        UiCommand::PlacementLarger => nudged(cx, scale(1.01)),
        UiCommand::PlacementSmaller => nudged(cx, scale(1.0 / 1.01)),
        _ => return false,
    };
    if let Some(change) = change {
        cx.ask(Action::Change(change));
    }
    true
}
