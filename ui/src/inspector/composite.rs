//! The finished picture: its layers, what lies before what, and how honest the background is.

use std::sync::Arc;

use agenticfocus::{
    engine::{Layers, ModelUse},
    image::{Rgb8, Rgba8},
    inpaint::FrameCoverage,
    session::LayerOrder,
};
use egui::{Button, Color32, ColorImage, Rect, RichText, Sense, Slider, Ui, pos2, vec2};

use super::{
    edits::{LayerOrderChange, layer_order_on, with_layer_order, without_layer_order},
    hands::{frames_in_words, frames_meant},
    parts::{
        Share, TextureKey, Textures, bar_of_shares, fact, frame_with_cross, hint, made_by, model_fault,
        section,
    },
};
use crate::{
    action::Action,
    state::{BeforeAfter, Context, LayerEye, Workspace},
    widgets::{Icon, icon_button},
};

pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace, textures: &mut Textures) {
    section(ui, cx, "Layers, front to back", |ui, cx| stack(ui, cx, workspace, textures));
    section(ui, cx, "What lies in front", |ui, cx| {
        ui.add_enabled_ui(workspace.is_writable(), |ui| order(ui, cx, workspace));
    });
    section(ui, cx, "Compare", compare);
    section(ui, cx, "Background in the hole", |ui, cx| coverage(ui, cx, workspace));
}

const NAMES: [&str; 4] = ["Robot parts in front", "Object", "Robot", "Background"];

fn stack(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace, textures: &mut Textures) {
    let layers = cx.pictures.composite(workspace.playhead, workspace.revision).map(|(layers, _)| layers);
    for (index, name) in NAMES.into_iter().enumerate() {
        ui.horizontal(|ui| {
            ui.set_min_height(40.0);
            let (place, _) = ui.allocate_exact_size(vec2(52.0, 39.0), Sense::hover());
            ui.painter().rect_filled(place, 2.0, cx.tokens.ground);
            if let Some(layers) = &layers {
                thumbnail(ui, place, layers, index, textures);
            }
            let LayerEye { mut shown, mut opacity } = *eye(cx, index);
            let name_of_eye = format!("{} {}", if shown { "Hide" } else { "Show" }, name.to_lowercase());
            let icon = if shown { Icon::Eye } else { Icon::EyeOff };
            if icon_button(ui, icon, &name_of_eye).clicked() {
                shown = !shown;
            }
            ui.vertical(|ui| {
                ui.spacing_mut().item_spacing.y = 0.0;
                ui.spacing_mut().interact_size.y = 18.0;
                ui.add(egui::Label::new(RichText::new(name).color(cx.tokens.text)).truncate());
                ui.spacing_mut().slider_width = (ui.available_width() - 64.0).max(40.0);
                let slider = Slider::new(&mut opacity, 0.0..=1.0)
                    .custom_formatter(|value, _| format!("{:.0} %", 100.0 * value))
                    .custom_parser(|text| {
                        Some(text.trim_end_matches('%').trim().parse::<f64>().ok()? / 100.0)
                    });
                ui.add_enabled(shown, slider).accessible_name(format!("Opacity of {}", name.to_lowercase()));
            });
            *eye(cx, index) = LayerEye { shown, opacity };
        });
    }
    hint(ui, cx.tokens, "For looking only: the export always has all layers in full");
}

fn eye<'a>(cx: &'a mut Context<'_>, index: usize) -> &'a mut LayerEye {
    let eyes = &mut cx.options.eyes;
    match index {
        0 => &mut eyes.front,
        1 => &mut eyes.object,
        2 => &mut eyes.robot,
        _ => &mut eyes.background,
    }
}

fn thumbnail(ui: &Ui, place: Rect, layers: &Arc<Layers>, index: usize, textures: &mut Textures) {
    let make = |layers: &Layers| match index {
        0 => small_rgba(&layers.front),
        1 => layers
            .object
            .as_ref()
            .map_or_else(|| ColorImage::filled([1, 1], Color32::TRANSPARENT), small_rgba),
        2 => small_rgba(&layers.robot),
        _ => small_rgb(&layers.background),
    };
    let texture = textures.of(ui, TextureKey::Layer(index), layers, make);
    let size = texture.size_vec2();
    let scale = (place.width() / size.x).min(place.height() / size.y);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter().image(
        texture.id(),
        Rect::from_center_size(place.center(), size * scale),
        whole,
        Color32::WHITE,
    );
}

/// Every nth pixel: at this size nobody sees more, and it is made anew for every frame.
fn small(size: agenticfocus::geometry::Size, at: impl Fn(u32, u32) -> Color32) -> ColorImage {
    let step = (size.height / 64).max(1);
    let (width, height) = ((size.width / step).max(1), (size.height / step).max(1));
    let pixels =
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| at(x * step, y * step));
    ColorImage::new([width as usize, height as usize], pixels.collect())
}

fn small_rgba(picture: &Rgba8) -> ColorImage {
    small(picture.size(), |x, y| {
        let [r, g, b, a] = picture.pixel(x, y);
        Color32::from_rgba_unmultiplied(r, g, b, a)
    })
}

fn small_rgb(picture: &Rgb8) -> ColorImage {
    small(picture.size(), |x, y| {
        let [r, g, b] = picture.pixel(x, y);
        Color32::from_rgb(r, g, b)
    })
}

fn order(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let document = workspace.document();
    let (first, last) = frames_meant(cx, workspace);
    let (order, thumb) = layer_order_on(document, first);
    hint(ui, cx.tokens, &format!("On {}; select more on the timeline", frames_in_words(cx, workspace)));
    let mut wanted = None;
    let width = (ui.available_width() - 2.0 * ui.spacing().item_spacing.x) / 3.0;
    ui.horizontal(|ui| {
        let choices = [
            (LayerOrder::Auto, "Auto", "Order: auto", "Decided by contact and by what the source shows"),
            (LayerOrder::RobotInFront, "Robot", "Order: robot in front", "The robot covers the object"),
            (LayerOrder::ObjectInFront, "Object", "Order: object in front", "The object covers the robot"),
        ];
        for (choice, text, name, tooltip) in choices {
            let button = Button::selectable(order == choice, text).frame_when_inactive(true);
            let response = ui.add_sized([width, 24.0], button);
            if response.accessible_name(name).on_hover_text(tooltip).clicked() {
                wanted = Some(LayerOrderChange::Order(choice));
            }
        }
    });
    ui.horizontal(|ui| {
        ui.label(RichText::new("Thumb pass").color(cx.tokens.muted));
        for (choice, text) in [(None, "Auto"), (Some(true), "On"), (Some(false), "Off")] {
            let button = ui.add(Button::selectable(thumb == choice, text).frame_when_inactive(true));
            let name = format!("Thumb pass: {}", text.to_lowercase());
            if button
                .accessible_name(&name)
                .on_hover_text("The thumb over the object, fingers behind it")
                .clicked()
            {
                wanted = Some(LayerOrderChange::Thumb(choice));
            }
        }
    });
    if let Some(change) = wanted {
        cx.ask(Action::Change(with_layer_order(document, first, last, change)));
    }
    for (index, range) in document.layer_orders.iter().enumerate() {
        let text = format!("to {}: {}", range.last.0, order_in_words(range.order, range.thumb));
        let name = format!("Leave frames {} to {} to the machine", range.first.0, range.last.0);
        if frame_with_cross(ui, cx, range.first, &text, &name) {
            cx.ask(Action::Change(without_layer_order(document, index)));
        }
    }
}

fn order_in_words(order: LayerOrder, thumb: Option<bool>) -> String {
    let order = match order {
        LayerOrder::Auto => "auto",
        LayerOrder::RobotInFront => "robot in front",
        LayerOrder::ObjectInFront => "object in front",
    };
    match thumb {
        None => order.to_owned(),
        Some(true) => format!("{order}, thumb on"),
        Some(false) => format!("{order}, thumb off"),
    }
}

fn compare(ui: &mut Ui, cx: &mut Context<'_>) {
    let share = match cx.options.before_after {
        BeforeAfter::Wipe(share) => share,
        _ => 0.5,
    };
    let width = (ui.available_width() - 2.0 * ui.spacing().item_spacing.x) / 3.0;
    ui.horizontal(|ui| {
        let choices = [
            (BeforeAfter::Before, "Before"),
            (BeforeAfter::Wipe(share), "Wipe"),
            (BeforeAfter::After, "After"),
        ];
        for (choice, text) in choices {
            let chosen = std::mem::discriminant(&choice) == std::mem::discriminant(&cx.options.before_after);
            let button = Button::selectable(chosen, text).frame_when_inactive(true);
            if ui.add_sized([width, 24.0], button).clicked() {
                cx.options.before_after = choice;
            }
        }
    });
    if let BeforeAfter::Wipe(share) = &mut cx.options.before_after {
        ui.spacing_mut().slider_width = ui.available_width();
        ui.add(Slider::new(share, 0.0..=1.0).show_value(false)).accessible_name("Place of the wipe");
    }
}

fn coverage(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let fault = workspace.found.model_faults.get(&ModelUse::Background);
    let Some(report) = &workspace.found.background else {
        hint(ui, cx.tokens, "Not restored yet");
        return fault.into_iter().for_each(|fault| model_fault(ui, cx.tokens, fault));
    };
    made_by(ui, cx.tokens, &report.backend, fault);
    if let Some(fault) = workspace.found.model_faults.get(&ModelUse::UnseenBackground) {
        model_fault(ui, cx.tokens, fault);
    }
    if let Some(here) = report.coverage.get(workspace.playhead.as_usize()) {
        row(ui, cx, "This frame", here);
    }
    row(ui, cx, "Clip", &whole(&report.coverage));
}

fn row(ui: &mut Ui, cx: &Context<'_>, name: &str, coverage: &FrameCoverage) {
    let tokens = cx.tokens;
    if coverage.hole == 0 {
        return fact(ui, tokens, name, "no hole");
    }
    fact(ui, tokens, name, &coverage_in_words(coverage));
    bar_of_shares(
        ui,
        tokens,
        &[
            Share { share: coverage.seen, colour: tokens.template, hatched: false },
            Share { share: coverage.behind_template, colour: tokens.muted, hatched: true },
            Share { share: coverage.synthesised, colour: tokens.hole, hatched: true },
        ],
    );
    if coverage.behind_template >= 0.005 {
        hint(
            ui,
            tokens,
            &format!("{:.0} % lies behind the object and is never seen", 100.0 * coverage.behind_template),
        );
    }
}

/// What is really seen and what is made up.
pub(super) fn coverage_in_words(coverage: &FrameCoverage) -> String {
    format!("seen {:.0} %, synthesised {:.0} %", 100.0 * coverage.seen, 100.0 * coverage.synthesised)
}

/// All frames together, each by the size of its hole.
pub(super) fn whole(frames: &[FrameCoverage]) -> FrameCoverage {
    let hole: u64 = frames.iter().map(|frame| frame.hole).sum();
    let mean = |share: fn(&FrameCoverage) -> f64| {
        frames.iter().map(|frame| frame.hole as f64 * share(frame)).sum::<f64>() / hole.max(1) as f64
    };
    FrameCoverage {
        hole,
        seen: mean(|frame| frame.seen),
        synthesised: mean(|frame| frame.synthesised),
        behind_template: mean(|frame| frame.behind_template),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_with_a_larger_hole_weigh_more() {
        let frame = |hole, seen| FrameCoverage { hole, seen, synthesised: 1.0 - seen, behind_template: 0.0 };
        let all = whole(&[frame(300, 1.0), frame(100, 0.0), frame(0, 0.0)]);
        assert_eq!(coverage_in_words(&all), "seen 75 %, synthesised 25 %");
    }
}
