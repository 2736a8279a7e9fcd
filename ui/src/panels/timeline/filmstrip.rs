//! Small pictures along the clip; only those in sight are asked for.

use agenticfocus::{clip::FrameIndex, geometry::Size};
use egui::{Color32, CornerRadius, Rect, Ui, pos2};

use super::Scale;
use crate::{
    state::{Context, Workspace},
    widgets::Thumbnails,
};

/// Height that pictures are asked for with, pixels: that of the picture under the pointer.
const PICTURE_HEIGHT: u32 = 84;

/// The picture of one frame in the flow of `ui`, larger than in the strip.
pub(super) fn picture(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    thumbnails: &mut Thumbnails<u32>,
    frame: FrameIndex,
    size: Size,
) {
    let height = 84.0;
    let width = (height * size.width as f32 / size.height.max(1) as f32).clamp(48.0, 160.0);
    let (rect, _) = ui.allocate_exact_size(egui::vec2(width, height), egui::Sense::hover());
    ui.painter().rect_filled(rect, CornerRadius::same(2), cx.tokens.raised);
    if let Some(picture) = cx.pictures.thumbnail(frame, PICTURE_HEIGHT) {
        let texture = thumbnails.texture(ui.ctx(), frame.0, &picture);
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter().image(texture, rect, whole, Color32::WHITE);
    }
}

/// Draws the filmstrip into `rect`.
pub(super) fn paint(
    ui: &Ui,
    cx: &mut Context<'_>,
    thumbnails: &mut Thumbnails<u32>,
    scale: &Scale,
    rect: Rect,
    workspace: &Workspace,
) {
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    painter.rect_filled(rect, CornerRadius::same(2), cx.tokens.raised);
    let Some(size) = workspace.size() else { return };
    let width = (rect.height() * size.width as f32 / size.height.max(1) as f32).clamp(12.0, 160.0);
    // A clip shorter than the strip is not stretched beyond its frames' own width.
    let count = (rect.width() / width).ceil().max(1.0) as usize;
    for place in 0..count {
        let left = rect.left() + width * place as f32;
        let tile = Rect::from_min_max(pos2(left, rect.top()), pos2(left + width, rect.bottom()));
        let middle = tile.center().x.min(rect.right() - 1.0);
        let frame: FrameIndex = scale.frame_at(middle);
        match cx.pictures.thumbnail(frame, PICTURE_HEIGHT) {
            Some(picture) => {
                let texture = thumbnails.texture(ui.ctx(), frame.0, &picture);
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                painter.image(texture, tile.shrink2(egui::vec2(0.5, 0.0)), whole, Color32::WHITE);
            }
            None => {
                painter.vline(tile.right(), tile.y_range(), egui::Stroke::new(1.0, cx.tokens.line));
            }
        }
    }
}
