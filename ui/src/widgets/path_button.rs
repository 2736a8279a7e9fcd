//! A button that opens a file that was open before.

use std::path::Path;

use egui::{Button, Response, RichText, Ui, Vec2, WidgetInfo, accesskit::Role};

use crate::{action::Action, state::Context, theme::Tokens};

/// Letters shown of a folder's name: the file's name is the one that counts.
const FOLDER_LETTERS: usize = 20;

/// A row with the file's name, and the name of the folder it lies in; the tooltip says the whole path.
pub fn path_button(ui: &mut Ui, cx: &mut Context<'_>, path: &Path, width: f32) -> Response {
    let name = last_name(path);
    let folder = path.parent().map(last_name).unwrap_or_default();
    let button = Button::new(name.as_str())
        .shortcut_text(RichText::new(shortened(&folder)).color(cx.tokens.muted))
        .frame_when_inactive(false)
        .truncate()
        .min_size(Vec2::new(width, Tokens::ROW));
    let response = ui.scope(|ui| {
        ui.set_max_width(width);
        ui.add(button)
    });
    let response = response.inner;
    response.widget_info(|| WidgetInfo::labeled(Role::Button, response.enabled(), format!("Open {name}")));
    if response.clicked() {
        cx.ask(Action::Open(path.to_owned()));
    }
    response.on_hover_text(path.display().to_string())
}

fn last_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn shortened(text: &str) -> String {
    if text.chars().count() <= FOLDER_LETTERS {
        return text.to_owned();
    }
    text.chars().take(FOLDER_LETTERS - 1).chain(['…']).collect()
}
