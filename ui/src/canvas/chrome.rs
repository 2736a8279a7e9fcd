//! The strips at the edges of the canvas: the step's tools above, the view below.

use agenticfocus::{
    geometry::Side,
    session::{MaskLayer, Step},
};
use egui::{
    Align, Button, Label, Layout, Popup, PopupCloseBehavior, Rect, RichText, Stroke, Ui, UiBuilder,
    WidgetInfo, accesskit::Role, vec2,
};

use super::{Eyes, STRIP, caption::Caption, scene::Scene, tools::object::ObjectTool};
use crate::{
    state::{BeforeAfter, Context, Tool},
    theme::{Tokens, small_number_font},
    ui_command::UiCommand,
    widgets::{Icon, command_button, command_icon_button, command_switch, command_toggle},
};

/// Commands of the strip; with `Some` where they switch something that is on or off.
type Group = Vec<(UiCommand, Option<bool>)>;

/// What is pressed in beside what options tell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pressed {
    pub object: ObjectTool,
    pub template_mask: bool,
}

fn groups(cx: &Context<'_>, pressed: Pressed) -> [Group; 2] {
    let options = &cx.options;
    let tool = |command, tool| (command, Some(options.tool == tool));
    match options.step {
        Step::Object => [
            vec![
                (UiCommand::DrawBox, Some(pressed.object == ObjectTool::Box)),
                (UiCommand::DrawPoints, Some(pressed.object == ObjectTool::Points)),
            ],
            vec![(UiCommand::NoObject, None)],
        ],
        Step::Masks => [
            vec![
                (UiCommand::LayerObject, Some(options.mask_layer == MaskLayer::Object)),
                (UiCommand::LayerLeftArm, Some(options.arm() == Some(Side::Left))),
                (UiCommand::LayerRightArm, Some(options.arm() == Some(Side::Right))),
            ],
            vec![
                tool(UiCommand::Brush, Tool::Brush),
                tool(UiCommand::Eraser, Tool::Eraser),
                tool(UiCommand::Polygon, Tool::Polygon),
                tool(UiCommand::Lasso, Tool::Lasso),
                tool(UiCommand::BoxTool, Tool::Box),
                tool(UiCommand::PointsTool, Tool::Points),
            ],
        ],
        Step::Template => [
            vec![(UiCommand::TemplateHere, None), (UiCommand::TemplateAuto, None)],
            vec![(UiCommand::TemplateMask, Some(pressed.template_mask)), (UiCommand::ForgetPlacement, None)],
        ],
        Step::Hands => {
            let left = options.side == Side::Left;
            [
                vec![(UiCommand::LeftHand, Some(left)), (UiCommand::RightHand, Some(!left))],
                vec![(UiCommand::SwapSides, None), (UiCommand::InvalidHand, None)],
            ]
        }
        Step::Composite => {
            let compared = options.before_after != BeforeAfter::After;
            [vec![(UiCommand::BeforeAfter, Some(compared))], Vec::new()]
        }
        Step::Retarget | Step::Review => [Vec::new(), Vec::new()],
    }
}

fn command(ui: &mut Ui, cx: &mut Context<'_>, (command, on): (UiCommand, Option<bool>)) {
    match on {
        Some(on) if matches!(command, UiCommand::BeforeAfter | UiCommand::TemplateMask) => {
            command_switch(ui, cx, command, on)
        }
        Some(on) => command_toggle(ui, cx, command, on),
        None => command_button(ui, cx, command),
    };
}

/// The step's tools at the left, what is on screen at the right.
pub(super) fn tool_strip(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    pressed: Pressed,
    (icon, text): Caption,
    whole: Rect,
) {
    let strip = Rect::from_min_size(whole.min, vec2(whole.width(), STRIP));
    ui.painter().rect_filled(strip, 0.0, cx.tokens.panel);
    ui.painter().hline(strip.x_range(), strip.max.y - 0.5, Stroke::new(1.0, cx.tokens.line));
    let builder =
        UiBuilder::new().max_rect(strip.shrink2(vec2(8.0, 4.0))).layout(Layout::left_to_right(Align::Center));
    ui.scope_builder(builder, |ui| {
        ui.set_clip_rect(strip);
        ui.spacing_mut().item_spacing.x = 4.0;
        let [first, second] = groups(cx, pressed);
        let divided = !first.is_empty() && !second.is_empty();
        for entry in first {
            command(ui, cx, entry);
        }
        if divided {
            ui.add_space(4.0);
            let x = ui.cursor().min.x;
            ui.painter().vline(x, strip.shrink(8.0).y_range(), Stroke::new(1.0, cx.tokens.line));
            ui.add_space(8.0);
        }
        for entry in second {
            command(ui, cx, entry);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            // The glyph is drawn to the left of the words, so it comes after them here.
            let width = (ui.available_width() - 24.0).max(0.0);
            ui.scope(|ui| {
                ui.set_max_width(width);
                ui.add(Label::new(RichText::new(text).color(cx.tokens.muted)).truncate());
            });
            if let Some(icon) = icon {
                icon.show(ui, cx.tokens.muted);
            }
        });
    });
}

/// Where the pointer is at the left, zoom and layers at the right.
pub(super) fn view_strip(ui: &mut Ui, cx: &mut Context<'_>, scene: &Scene<'_>, eyes: &mut Eyes, whole: Rect) {
    let strip = Rect::from_min_max(whole.max - vec2(whole.width(), STRIP), whole.max);
    ui.painter().rect_filled(strip, 0.0, cx.tokens.panel);
    ui.painter().hline(strip.x_range(), strip.min.y + 0.5, Stroke::new(1.0, cx.tokens.line));
    let builder =
        UiBuilder::new().max_rect(strip.shrink2(vec2(8.0, 4.0))).layout(Layout::left_to_right(Align::Center));
    ui.scope_builder(builder, |ui| {
        ui.set_clip_rect(strip);
        ui.spacing_mut().interact_size.y = Tokens::ROW;
        let place = scene.hover.map(|at| scene.pixel(at));
        let (width, height) = (f64::from(scene.size().width), f64::from(scene.size().height));
        let inside =
            place.filter(|at| at.x >= -0.5 && at.y >= -0.5 && at.x < width - 0.5 && at.y < height - 0.5);
        let text = match inside {
            Some(at) => format!("x {:.0}  y {:.0}", at.x, at.y),
            None => format!("{} px", scene.size()),
        };
        ui.label(RichText::new(text).font(small_number_font()).color(cx.tokens.muted));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            command_button(ui, cx, UiCommand::OneToOne);
            command_button(ui, cx, UiCommand::Fit);
            command_icon_button(ui, cx, Icon::Plus, UiCommand::ZoomIn);
            let zoom = format!("{:>4.0} %", scene.projection.zoom * 100.0);
            ui.label(RichText::new(zoom).font(small_number_font()).color(cx.tokens.text));
            command_icon_button(ui, cx, Icon::Minus, UiCommand::ZoomOut);
            layers_menu(ui, cx, eyes);
        });
    });
}

/// Which layers are shown.
fn layers_menu(ui: &mut Ui, cx: &mut Context<'_>, eyes: &mut Eyes) {
    let response = ui.add(Button::new(("Layers", Icon::Down.atom())));
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Layers"));
    Popup::menu(&response).close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        ui.set_min_width(160.0);
        match cx.options.step {
            Step::Object | Step::Hands => {
                ui.label(RichText::new("No layers in this step").color(cx.tokens.muted));
            }
            Step::Masks | Step::Template => {
                ui.checkbox(&mut eyes.object, "Object mask");
                if cx.options.step == Step::Masks {
                    ui.checkbox(&mut eyes.arms, "Arm masks");
                    ui.checkbox(&mut cx.options.onion_skin, "Onion skin");
                    ui.checkbox(&mut cx.options.hole_outline, "Outline of the hole");
                }
            }
            Step::Retarget | Step::Composite | Step::Review => {
                let layers = &mut cx.options.eyes;
                ui.checkbox(&mut layers.front.shown, "Robot in front");
                ui.checkbox(&mut layers.object.shown, "Object");
                ui.checkbox(&mut layers.robot.shown, "Robot");
                ui.checkbox(&mut layers.background.shown, "Background");
            }
        }
    });
}
