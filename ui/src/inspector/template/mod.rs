//! The template: the clean frame it is cut from, its picture, where it goes.

mod plot;
mod rank;

use std::{collections::BTreeMap, sync::Arc};

use agenticfocus::{clip::FrameIndex, session::Command, template::TemplateTrack};
use egui::{Align, Color32, Layout, Rect, RichText, Sense, Ui, pos2, vec2};

use self::rank::{Ranked, ranked};
use super::{
    edits::choose_template_frame,
    parts::{
        TextureKey, Textures, empty, fact, frame_with_cross, hint, picture_of_rgb, picture_of_rgba, section,
        small_button,
    },
};
use crate::{
    action::Action,
    state::{Context, Workspace},
    ui_command::UiCommand,
    widgets::{Icon, command_button},
};

/// Clean frames offered.
const OFFERED: usize = 6;
/// Height asked of the engine for small pictures of frames.
const THUMBNAIL_HEIGHT: u32 = 48;

/// Keeps the ranking, which takes a moment to reason about.
#[derive(Debug, Default)]
pub(super) struct TemplateInspector {
    ranking: Option<(Arc<TemplateTrack>, Vec<Ranked>)>,
}

impl TemplateInspector {
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        workspace: &Workspace,
        textures: &mut Textures,
    ) {
        let Some(track) = workspace.found.template.clone() else {
            empty(ui, cx.tokens, "No template yet", "It is cut once the object's masks are known");
            command_button(ui, cx, UiCommand::TemplateHere);
            return;
        };
        section(ui, cx, "Template", |ui, cx| picture(ui, cx, workspace, &track, textures));
        section(ui, cx, "Clean frames, best first", |ui, cx| {
            self.clean_frames(ui, cx, workspace, &track, textures)
        });
        section(ui, cx, "Placement", |ui, cx| placement(ui, cx, workspace, &track));
        section(ui, cx, "Keyframes", |ui, cx| keyframes(ui, cx, workspace));
    }

    fn clean_frames(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        workspace: &Workspace,
        track: &Arc<TemplateTrack>,
        textures: &mut Textures,
    ) {
        if !self.ranking.as_ref().is_some_and(|(known, _)| Arc::ptr_eq(known, track)) {
            self.ranking = Some((Arc::clone(track), ranked(workspace, track, OFFERED)));
        }
        let Some((_, ranking)) = &self.ranking else { return };
        for clean in ranking {
            clean_frame(ui, cx, workspace, track, clean, textures);
        }
        ui.add_enabled_ui(workspace.is_writable(), |ui| {
            ui.horizontal(|ui| {
                command_button(ui, cx, UiCommand::TemplateHere);
                command_button(ui, cx, UiCommand::TemplateAuto);
            });
        });
    }
}

fn clean_frame(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    workspace: &Workspace,
    track: &TemplateTrack,
    clean: &Ranked,
    textures: &mut Textures,
) {
    let Ranked { frame, score, why } = clean;
    let tokens = cx.tokens;
    ui.horizontal(|ui| {
        let (place, response) = ui.allocate_exact_size(vec2(64.0, 48.0), Sense::click());
        let (enabled, name) = (ui.is_enabled(), format!("Show clean frame {}", frame.0));
        response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Button, enabled, &name));
        ui.painter().rect_filled(place, 2.0, tokens.ground);
        if let Some(small) = cx.pictures.thumbnail(*frame, THUMBNAIL_HEIGHT) {
            let texture = textures.of(ui, TextureKey::Thumbnail(*frame), &small, picture_of_rgb);
            paint_inside(ui, place, &texture);
        }
        if *frame == track.frame {
            ui.painter().rect_stroke(
                place,
                2.0,
                egui::Stroke::new(2.0, tokens.template),
                egui::StrokeKind::Inside,
            );
        }
        if response.on_hover_text("Show this frame").clicked() {
            cx.ask(Action::Seek(*frame));
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if *frame == track.frame {
                ui.label(RichText::new("in use").size(11.0).color(tokens.text));
                Icon::Check.show(ui, tokens.accent);
            } else {
                let name = format!("Cut the template from frame {}", frame.0);
                let button =
                    ui.add_enabled_ui(workspace.is_writable(), |ui| small_button(ui, "Use", &name)).inner;
                if button.clicked() {
                    cx.ask(Action::Change(choose_template_frame(workspace.document(), Some(*frame))));
                }
            }
            ui.with_layout(Layout::top_down(Align::Min), |ui| {
                ui.spacing_mut().item_spacing.y = 0.0;
                ui.add_space(6.0);
                let line = format!("Frame {} · {:.0} %", frame.0, 100.0 * score);
                ui.label(RichText::new(line).color(tokens.text));
                ui.add(egui::Label::new(RichText::new(why).size(11.0).color(tokens.muted)).truncate())
                    .on_hover_text(why);
            });
        });
    });
}

fn paint_inside(ui: &Ui, place: Rect, texture: &egui::TextureHandle) {
    let size = texture.size_vec2();
    let scale = (place.width() / size.x).min(place.height() / size.y);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let inside = Rect::from_center_size(place.center(), size * scale);
    ui.painter().image(texture.id(), inside, whole, Color32::WHITE);
}

fn picture(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    workspace: &Workspace,
    track: &Arc<TemplateTrack>,
    textures: &mut Textures,
) {
    let texture = textures.of(ui, TextureKey::Template, track, |track| picture_of_rgba(&track.picture));
    let (place, _) = ui.allocate_exact_size(vec2(ui.available_width(), 128.0), Sense::hover());
    checkerboard(ui, place, [cx.tokens.panel, cx.tokens.raised]);
    ui.painter().rect_stroke(place, 2.0, egui::Stroke::new(1.0, cx.tokens.line), egui::StrokeKind::Inside);
    paint_inside(ui, place.shrink(8.0), &texture);
    let size = track.picture.size();
    let by =
        if workspace.document().template.frame.is_some() { "chosen by you" } else { "chosen by the machine" };
    fact(ui, cx.tokens, &format!("From frame {}, {by}", track.frame.0), &size.to_string());
    if workspace.document().template.mask.is_some() {
        hint(ui, cx.tokens, "Its mask was drawn by you");
    }
}

/// Squares of 8 points, so that soft edges show on either.
fn checkerboard(ui: &Ui, place: Rect, colours: [Color32; 2]) {
    let painter = ui.painter().with_clip_rect(place);
    painter.rect_filled(place, 2.0, colours[0]);
    let (columns, rows) = ((place.width() / 8.0).ceil() as u32, (place.height() / 8.0).ceil() as u32);
    for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).filter(|(x, y)| (x + y) % 2 == 1)
    {
        let at = place.min + 8.0 * vec2(x as f32, y as f32);
        painter.rect_filled(Rect::from_min_size(at, vec2(8.0, 8.0)), 0.0, colours[1]);
    }
}

fn placement(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace, track: &TemplateTrack) {
    let here = track.placements.get(workspace.playhead.as_usize());
    match here {
        Some(Some(placement)) => {
            fact(ui, cx.tokens, "Trust on this frame", &format!("{:.0} %", 100.0 * placement.confidence));
            fact(ui, cx.tokens, "Visible of the object", &format!("{:.0} %", 100.0 * placement.visible));
        }
        Some(None) => hint(ui, cx.tokens, "The object is not on this frame"),
        None => {}
    }
    if let Some(frame) = plot::confidence(ui, cx.tokens, workspace, track) {
        cx.ask(Action::Seek(frame));
    }
    hint(ui, cx.tokens, "Trust over the clip; diamonds are placed by you, gaps without the object");
}

fn keyframes(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
    let placements = &workspace.document().template.placements;
    if placements.is_empty() {
        hint(ui, cx.tokens, "None: drag the template on a frame to set one");
    }
    let edits = &workspace.document().template;
    let spans: BTreeMap<FrameIndex, FrameIndex> = edits.interpolated_spans().collect();
    for frame in placements.keys().copied() {
        let name = format!("Leave frame {} to the machine", frame.0);
        let text = match spans.get(&frame) {
            Some(last) => format!("placed by you, runs to {}", last.0),
            None => "placed by you".to_owned(),
        };
        if frame_with_cross(ui, cx, frame, &text, &name) {
            cx.ask(Action::Change(Command::SetPlacement { frame, transform: None }));
        }
    }
    let here: FrameIndex = workspace.playhead;
    ui.horizontal_wrapped(|ui| {
        if placements.len() > 1 {
            command_button(ui, cx, UiCommand::InterpolatePlacement);
        }
        if placements.contains_key(&here) {
            command_button(ui, cx, UiCommand::ForgetPlacement);
        }
    });
    if let Some([(first, _), (last, _)]) = edits.keyframes_around(here) {
        let who = if spans.contains_key(&first) { "between them" } else { "by the machine" };
        hint(ui, cx.tokens, &format!("Frames {} to {}: placed {who}", first.0 + 1, last.0 - 1));
    }
}
