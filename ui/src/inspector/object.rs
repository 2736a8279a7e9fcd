//! Which object the clip is about: the task, proposals as cards, or drawn by hand.

use agenticfocus::{
    engine::ModelUse,
    geometry::{Pixel, PixelBox, Size},
    image::Rgb8,
    session::{Author, Command, ObjectChoice, ObjectPromptKind, ObjectProposal},
};
use egui::{
    Align, Color32, ColorImage, Layout, Rect, RichText, Sense, Stroke, TextureId, Ui, UiBuilder, pos2, vec2,
};

use super::{
    answer,
    parts::{TextureKey, Textures, draft, empty, hint, model_fault, section},
    words::author_of_proposal,
};
use crate::{
    action::Action,
    state::{Context, Workspace},
    ui_command::UiCommand,
    widgets::{Icon, command_button},
};

/// Picture in a card.
const CROP: egui::Vec2 = vec2(72.0, 60.0);

/// What is being typed.
#[derive(Debug, Default)]
pub(super) struct ObjectInspector {
    task: Option<String>,
}

impl ObjectInspector {
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        workspace: &Workspace,
        textures: &mut Textures,
    ) {
        section(ui, cx, "Task", |ui, cx| self.task(ui, cx, workspace));
        section(ui, cx, "Object", |ui, cx| proposals(ui, cx, workspace, textures));
        answer::show(ui, cx, workspace);
        section(ui, cx, "Draw it myself", |ui, cx| {
            ui.add_enabled_ui(workspace.is_writable(), |ui| {
                ui.horizontal_wrapped(|ui| {
                    command_button(ui, cx, UiCommand::DrawBox);
                    command_button(ui, cx, UiCommand::DrawPoints);
                    if workspace.document().object.is_some() {
                        command_button(ui, cx, UiCommand::NoObject);
                    }
                });
            });
            match &workspace.draft {
                Some(points) => draft(ui, cx.tokens, points),
                None => hint(ui, cx.tokens, "On a frame where all of the object is seen"),
            }
            if let Some(fault) = workspace.found.model_faults.get(&ModelUse::PointMasks) {
                model_fault(ui, cx.tokens, fault);
            }
        });
    }

    fn task(&mut self, ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
        let kept = workspace.document().task.clone().unwrap_or_default();
        let mut text = self.task.clone().unwrap_or_else(|| kept.clone());
        let edit = egui::TextEdit::singleline(&mut text)
            .hint_text("What the hands do, in one sentence")
            .align(egui::Align2::LEFT_CENTER)
            .desired_width(f32::INFINITY);
        let response = ui.add_enabled(workspace.is_writable(), edit).accessible_name("Task sentence");
        if response.changed() {
            self.task = Some(text.clone());
        }
        if response.lost_focus() {
            self.task = None;
            if ui.input(|input| input.key_pressed(egui::Key::Escape)) {
                return;
            }
            let task = text.trim();
            if task != kept {
                let task = (!task.is_empty()).then(|| task.to_owned());
                cx.ask(Action::Change(Command::SetTask(task)));
            }
        }
    }
}

/// A card: what is offered, its digit, and whether it is the one in use.
struct Card<'a> {
    object: &'a ObjectProposal,
    digit: Option<usize>,
    state: CardState,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum CardState {
    Offered,
    InUse,
    Chosen,
}

fn proposals(ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace, textures: &mut Textures) {
    let cards = cards_of(workspace);
    if cards.is_empty() {
        empty(ui, cx.tokens, "No object proposed yet", "Wait for the machine, or draw a box around it");
    }
    for card in cards {
        if show_card(ui, cx, &card, textures, workspace).clicked() {
            match card.state {
                CardState::Offered | CardState::InUse if workspace.is_writable() => {
                    cx.ask(Action::Change(Command::SetObject(Some(card.object.clone().taken_by_person()))));
                }
                _ => cx.ask(Action::Seek(card.object.frame)),
            }
        }
        ui.add_space(4.0);
    }
}

/// The chosen one first, the rest as ranked. Digits are ranks, so that they mean the same before and after.
fn cards_of(workspace: &Workspace) -> Vec<Card<'_>> {
    let document = workspace.document();
    let chosen: Option<&ObjectChoice> = document.object.as_ref();
    let used = chosen.or(workspace.found.choice.as_ref());
    let state = if chosen.is_some() { CardState::Chosen } else { CardState::InUse };
    let mut cards: Vec<Card<'_>> = document
        .proposals
        .iter()
        .enumerate()
        .map(|(rank, object)| {
            // A proposal that a person took is shown as theirs.
            let taken = used.filter(|used| used.points_where(object));
            let state = if taken.is_some() { state } else { CardState::Offered };
            Card { object: taken.unwrap_or(object), digit: Some(rank + 1), state }
        })
        .collect();
    match cards.iter().position(|card| card.state != CardState::Offered) {
        Some(at) => cards[..=at].rotate_right(1),
        None => cards.splice(0..0, used.map(|object| Card { object, digit: None, state })).for_each(drop),
    }
    cards
}

fn show_card(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    card: &Card<'_>,
    textures: &mut Textures,
    workspace: &Workspace,
) -> egui::Response {
    let crop = crop_of(ui, cx, card.object, workspace.size(), textures);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), CROP.y + 16.0), Sense::click());
    let name = match card.digit {
        Some(digit) => format!("Proposal {digit}: {}", card.object.label),
        None => format!("Chosen object: {}", card.object.label),
    };
    let (enabled, selected) = (workspace.is_writable(), card.state == CardState::Chosen);
    response
        .widget_info(|| egui::WidgetInfo::selected(egui::accesskit::Role::Button, enabled, selected, &name));
    if ui.is_rect_visible(rect) {
        let tokens = cx.tokens;
        let border = match card.state {
            CardState::Chosen => Stroke::new(2.0, tokens.accent),
            CardState::InUse => Stroke::new(1.0, tokens.object),
            CardState::Offered if response.hovered() || response.has_focus() => {
                Stroke::new(1.0, tokens.muted)
            }
            CardState::Offered => Stroke::new(1.0, tokens.line),
        };
        ui.painter().rect(rect, 4.0, tokens.raised, border, egui::StrokeKind::Inside);
        let inside = rect.shrink(8.0);
        paint_crop(ui, cx, Rect::from_min_size(inside.min, CROP), crop);
        let words = Rect::from_min_max(inside.min + vec2(CROP.x + 8.0, 0.0), inside.max);
        let mut column = ui.new_child(UiBuilder::new().max_rect(words).layout(Layout::top_down(Align::Min)));
        card_words(&mut column, cx, card);
    }
    response.on_hover_text(&card.object.reason)
}

fn card_words(ui: &mut Ui, cx: &Context<'_>, card: &Card<'_>) {
    let Card { object, digit, state } = card;
    let tokens = cx.tokens;
    ui.spacing_mut().item_spacing.y = 2.0;
    ui.style_mut().interaction.selectable_labels = false;
    ui.horizontal(|ui| {
        if let Some(digit) = digit {
            ui.label(RichText::new(digit.to_string()).monospace().color(tokens.muted));
        }
        let percent = RichText::new(format!("{:.0} %", 100.0 * object.confidence)).color(tokens.text);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if object.author != Author::Human {
                ui.label(percent);
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(egui::Label::new(RichText::new(&object.label).strong().color(tokens.text)).truncate());
            });
        });
    });
    ui.add(egui::Label::new(RichText::new(&object.reason).size(11.0).color(tokens.muted)).truncate());
    let who = author_of_proposal(&object.author);
    let (icon, line) = match state {
        CardState::Chosen => (Some((Icon::Check, tokens.accent)), format!("chosen · by {who}")),
        CardState::InUse => (Some((Icon::Dot, tokens.object)), format!("in use, not confirmed · by {who}")),
        CardState::Offered => (None, format!("by {who} · frame {}", object.frame.0)),
    };
    let colour = if *state == CardState::Offered { tokens.muted } else { tokens.text };
    ui.horizontal(|ui| {
        if let Some((icon, colour)) = icon {
            icon.show(ui, colour);
        }
        ui.add(egui::Label::new(RichText::new(line).size(11.0).color(colour)).truncate());
    });
}

/// A texture and the part of it that is the crop.
struct Crop {
    texture: TextureId,
    size: egui::Vec2,
}

fn paint_crop(ui: &Ui, cx: &Context<'_>, place: Rect, crop: Option<Crop>) {
    ui.painter().rect_filled(place, 2.0, cx.tokens.ground);
    let Some(Crop { texture, size }) = crop else { return };
    let scale = (place.width() / size.x).min(place.height() / size.y);
    let picture = Rect::from_center_size(place.center(), size * scale);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter().image(texture, picture, whole, Color32::WHITE);
}

/// The object cut out of the source picture of its frame; `None` while that picture is on its way.
fn crop_of(
    ui: &Ui,
    cx: &mut Context<'_>,
    object: &ObjectProposal,
    size: Option<Size>,
    textures: &mut Textures,
) -> Option<Crop> {
    let bounds = bounds_of(object, size?)?;
    let key = TextureKey::Crop(object.frame, bounds);
    if textures.get(key).is_none() {
        let picture = cx.pictures.source(object.frame)?;
        let crop = cut(&picture, bounds)?;
        textures.keep(ui, key, crop);
    }
    let texture = textures.get(key)?;
    Some(Crop { texture: texture.id(), size: texture.size_vec2() })
}

/// Left, top, width and height of what a card shows: the object with a margin around it.
fn bounds_of(object: &ObjectProposal, size: Size) -> Option<[u32; 4]> {
    let around = match &object.prompt {
        ObjectPromptKind::Box(around) => *around,
        ObjectPromptKind::Points { positive, .. } => {
            let first = *positive.first()?;
            let spread = |to: Pixel, around: PixelBox| PixelBox {
                x0: around.x0.min(to.x),
                y0: around.y0.min(to.y),
                x1: around.x1.max(to.x),
                y1: around.y1.max(to.y),
            };
            let around =
                positive.iter().fold(PixelBox::from_corners(first, first), |all, to| spread(*to, all));
            around.grown(0.05 * size.diagonal())
        }
    };
    let margin = 0.15 * around.width().max(around.height());
    let clipped = around.grown(margin).clipped(size)?;
    let (x, y) = (clipped.x0.floor() as u32, clipped.y0.floor() as u32);
    let right = (clipped.x1.ceil() as u32).min(size.width);
    let bottom = (clipped.y1.ceil() as u32).min(size.height);
    (right > x && bottom > y).then(|| [x, y, right - x, bottom - y])
}

fn cut(picture: &Rgb8, [left, top, width, height]: [u32; 4]) -> Option<ColorImage> {
    let size = picture.size();
    if left + width > size.width || top + height > size.height {
        return None;
    }
    let mut bytes = Vec::with_capacity((width * height * 3) as usize);
    for y in top..top + height {
        let start = ((y * size.width + left) * 3) as usize;
        bytes.extend_from_slice(&picture.data()[start..start + (width * 3) as usize]);
    }
    Some(ColorImage::from_rgb([width as usize, height as usize], &bytes))
}

#[cfg(test)]
mod tests {
    use agenticfocus::clip::FrameIndex;

    use super::*;

    #[test]
    fn a_crop_stays_inside_the_picture() {
        let object = ObjectProposal {
            label: "cup".to_owned(),
            frame: FrameIndex(0),
            prompt: ObjectPromptKind::Box(PixelBox { x0: -5.0, y0: 200.0, x1: 60.0, y1: 260.0 }),
            confidence: 0.5,
            reason: String::new(),
            author: Author::Human,
        };
        let [x, y, width, height] = bounds_of(&object, Size::new(320, 240)).unwrap();
        assert_eq!((x, y + height), (0, 240));
        assert!(cut(&Rgb8::new(Size::new(320, 240)), [x, y, width, height]).is_some());
        let nowhere = ObjectPromptKind::Points { positive: Vec::new(), negative: Vec::new() };
        assert!(bounds_of(&ObjectProposal { prompt: nowhere, ..object }, Size::new(320, 240)).is_none());
    }
}
