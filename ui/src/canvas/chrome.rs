//! The strips at the edges of the canvas: the step's tools above, the view below.

use agenticfocus::{
    segment::{MaskAuthor, MaskFlag},
    session::{MaskLayer, Step},
};
use egui::{
    Align, Button, Layout, Popup, PopupCloseBehavior, Rect, RichText, Stroke, Ui, UiBuilder, containers::menu::MenuConfig,
    vec2,
};

use super::{
    Eyes, STRIP,
    scene::Scene,
    tools::{
        object::{ObjectTool, ObjectTools},
        template,
    },
};
use crate::{
    action::Action,
    state::{BeforeAfter, Context, MaskOnFrame, Tool},
    ui_command::UiCommand,
};

/// A button that runs `command`, pressed in where that is how things are.
pub(super) fn run_button(ui: &mut Ui, cx: &mut Context<'_>, command: UiCommand, selected: bool) {
    let button = Button::new(command.text()).selected(selected).min_size(vec2(0.0, 24.0));
    let keys = command.keys().first().map(|key| ui.ctx().format_shortcut(key)).unwrap_or_default();
    let tip = format!("{}  ({keys})", command.tooltip());
    if ui.add(button).on_hover_text(tip).clicked() {
        cx.ask(Action::Run(command));
    }
}

/// What is selected, as (command, whether it is how things are).
type Row = Vec<(UiCommand, bool)>;

fn commands_of(cx: &Context<'_>, object: &ObjectTools) -> [Row; 2] {
    let options = &cx.options;
    let tool = |command, tool| (command, options.tool == tool);
    match options.step {
        Step::Object => [
            vec![
                (UiCommand::DrawBox, object.tool == ObjectTool::Box),
                (UiCommand::DrawPoints, object.tool == ObjectTool::Points),
            ],
            vec![(UiCommand::NoObject, false)],
        ],
        Step::Masks => [
            vec![
                (UiCommand::LayerObject, options.mask_layer == MaskLayer::Object),
                (UiCommand::LayerArms, options.mask_layer == MaskLayer::Arms),
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
        Step::Template => {
            [vec![(UiCommand::TemplateHere, false), (UiCommand::TemplateAuto, false)], vec![(UiCommand::ForgetPlacement, false)]]
        }
        Step::Hands => {
            let left = options.side == agenticfocus::geometry::Side::Left;
            [
                vec![(UiCommand::LeftHand, left), (UiCommand::RightHand, !left)],
                vec![(UiCommand::SwapSides, false), (UiCommand::InvalidHand, false)],
            ]
        }
        Step::Retarget => [Vec::new(), Vec::new()],
        Step::Composite | Step::Review => {
            [vec![(UiCommand::BeforeAfter, options.before_after != BeforeAfter::After)], Vec::new()]
        }
    }
}

/// The step's tools at the left, what is on screen at the right.
pub(super) fn tool_strip(ui: &mut Ui, cx: &mut Context<'_>, scene: &Scene<'_>, object: &ObjectTools, whole: Rect) {
    let strip = Rect::from_min_size(whole.min, vec2(whole.width(), STRIP));
    ui.painter().rect_filled(strip, 0.0, cx.tokens.panel);
    ui.painter().hline(strip.x_range(), strip.max.y - 0.5, Stroke::new(1.0, cx.tokens.line));
    let builder = UiBuilder::new().max_rect(strip.shrink2(vec2(8.0, 4.0))).layout(Layout::left_to_right(Align::Center));
    ui.scope_builder(builder, |ui| {
        ui.set_clip_rect(strip);
        ui.spacing_mut().item_spacing.x = 4.0;
        let groups = commands_of(cx, object);
        let [first, second] = &groups;
        for (command, selected) in first {
            run_button(ui, cx, *command, *selected);
        }
        if !first.is_empty() && !second.is_empty() {
            ui.add_space(4.0);
            let x = ui.cursor().min.x;
            ui.painter().vline(x, strip.shrink(8.0).y_range(), Stroke::new(1.0, cx.tokens.line));
            ui.add_space(8.0);
        }
        for (command, selected) in second {
            run_button(ui, cx, *command, *selected);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let text = caption(cx, scene);
            ui.add(egui::Label::new(RichText::new(text).color(cx.tokens.muted)).truncate());
        });
    });
}

/// What is on screen, in words.
fn caption(cx: &Context<'_>, scene: &Scene<'_>) -> String {
    if !scene.is_writable() {
        return "Read-only: another program has this session open".to_owned();
    }
    match cx.options.step {
        Step::Object => match scene.workspace.document().object.as_ref() {
            Some(object) => format!("✔ {}", object.label),
            None if scene.workspace.document().proposals.is_empty() => "Drag a box around the object".to_owned(),
            None => "A digit takes a proposal; drag to draw a box".to_owned(),
        },
        Step::Masks => {
            let on = scene.workspace.mask(cx.options.mask_layer, scene.frame);
            on.map_or_else(|| "No mask on this frame".to_owned(), |on| mask_caption(&on))
        }
        Step::Template => match (template::placed(scene, scene.frame), &scene.workspace.found.template) {
            (_, None) => "No template yet".to_owned(),
            (None, _) => "The object is absent on this frame".to_owned(),
            (Some((_, true)), _) => "◆ placed by hand".to_owned(),
            (Some((_, false)), Some(track)) => {
                let placement = track.placements.get(scene.frame.as_usize()).and_then(Option::as_ref);
                let trust = placement.map_or(0.0, |placement| placement.confidence * 100.0);
                format!("— placed by the machine, trust {trust:.0} %")
            }
        },
        Step::Hands if scene.workspace.found.hands.is_none() => "Hands are not known yet".to_owned(),
        Step::Hands => "Drag a joint; Shift moves the whole hand".to_owned(),
        Step::Retarget => "○ target  ● reached wrist".to_owned(),
        Step::Composite | Step::Review => String::new(),
    }
}

fn mask_caption(on: &MaskOnFrame) -> String {
    if on.absent {
        return "◆ absent here, you said".to_owned();
    }
    let trust = on.score * 100.0;
    match on.author {
        MaskAuthor::Human => "◆ drawn by hand".to_owned(),
        _ if !on.flags.is_empty() => {
            let words: Vec<&str> = on.flags.iter().map(|flag| flag_text(*flag)).collect();
            format!("▲ {}, trust {trust:.0} %", words.join(", "))
        }
        MaskAuthor::Seeded => format!("● from a prompt, trust {trust:.0} %"),
        MaskAuthor::Propagated => format!("— propagated, trust {trust:.0} %"),
    }
}

fn flag_text(flag: MaskFlag) -> &'static str {
    match flag {
        MaskFlag::AreaJump => "area jumps",
        MaskFlag::LowOverlap => "moves oddly",
        MaskFlag::ColourDrift => "colours drift",
        MaskFlag::TouchesBorder => "touches the border",
        MaskFlag::Occluded => "mostly hidden",
        MaskFlag::Lost => "lost",
    }
}

/// Where the pointer is at the left, zoom and layers at the right.
pub(super) fn view_strip(ui: &mut Ui, cx: &mut Context<'_>, scene: &Scene<'_>, eyes: &mut Eyes, whole: Rect) {
    let strip = Rect::from_min_max(whole.max - vec2(whole.width(), STRIP), whole.max);
    ui.painter().rect_filled(strip, 0.0, cx.tokens.panel);
    ui.painter().hline(strip.x_range(), strip.min.y + 0.5, Stroke::new(1.0, cx.tokens.line));
    let builder = UiBuilder::new().max_rect(strip.shrink2(vec2(8.0, 4.0))).layout(Layout::left_to_right(Align::Center));
    ui.scope_builder(builder, |ui| {
        ui.set_clip_rect(strip);
        let place = scene.hover.map(|at| scene.pixel(at));
        let (width, height) = (f64::from(scene.size().width), f64::from(scene.size().height));
        let inside = place.filter(|at| at.x >= -0.5 && at.y >= -0.5 && at.x < width - 0.5 && at.y < height - 0.5);
        let text = match inside {
            Some(at) => format!("x {:.0}  y {:.0}", at.x, at.y),
            None => super::cards::size_text(scene.size()),
        };
        ui.label(RichText::new(text).monospace().size(11.0).color(cx.tokens.muted));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            run_button(ui, cx, UiCommand::OneToOne, false);
            run_button(ui, cx, UiCommand::Fit, false);
            small_button(ui, cx, "+", UiCommand::ZoomIn);
            let zoom = format!("{:>4.0} %", scene.projection.zoom * 100.0);
            ui.label(RichText::new(zoom).monospace().size(11.0).color(cx.tokens.text));
            small_button(ui, cx, "−", UiCommand::ZoomOut);
            layers_menu(ui, cx, eyes);
        });
    });
}

fn small_button(ui: &mut Ui, cx: &mut Context<'_>, sign: &str, command: UiCommand) {
    let button = Button::new(sign).min_size(vec2(24.0, 24.0));
    let keys = command.keys().first().map(|key| ui.ctx().format_shortcut(key)).unwrap_or_default();
    let response = ui.add(button).on_hover_text(format!("{}  ({keys})", command.tooltip()));
    if response.accessible_name(command.text()).clicked() {
        cx.ask(Action::Run(command));
    }
}

/// Which layers are shown.
fn layers_menu(ui: &mut Ui, cx: &mut Context<'_>, eyes: &mut Eyes) {
    let response = ui.add(Button::new("Layers ⏷").min_size(vec2(0.0, 24.0))).accessible_name("Layers");
    let _ = MenuConfig::new();
    Popup::menu(&response).close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        ui.set_min_width(160.0);
        match cx.options.step {
            Step::Object | Step::Hands => {
                ui.label(RichText::new("Nothing to choose in this step").color(cx.tokens.muted));
            }
            Step::Masks | Step::Template => {
                ui.checkbox(&mut eyes.object, "Object mask");
                if cx.options.step == Step::Masks {
                    ui.checkbox(&mut eyes.arms, "Arm masks");
                    ui.checkbox(&mut cx.options.onion_skin, "Onion skin");
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
