//! The timeline: transport, filmstrip, and for every frame who made what and how far to trust it.

mod filmstrip;
mod paint;
mod rows;
mod runs;
mod scale;
mod transport;
mod words;

use agenticfocus::clip::FrameIndex;
use egui::{EventFilter, Modifiers, Rangef, Rect, Response, Sense, Ui, WidgetInfo, pos2, vec2};

pub use runs::{HandRow, MaskKind, MaskRow, OrderKind, RowCache, Rows, Run, TemplateRow};
pub use scale::Scale;
pub use words::{flag_words, hand_words, mask_words};

use crate::{
    action::Action,
    state::{Context, Workspace},
    ui_command::UiCommand,
    widgets::{Thumbnails, small},
};

/// Width of the column with the rows' names, points.
const GUTTER: f32 = 80.0;
/// Room right of the last frame, points.
const RIGHT: f32 = 12.0;

/// The timeline panel.
#[derive(Debug, Default)]
pub struct Timeline {
    rows: RowCache,
    thumbnails: Thumbnails<u32>,
    transport: transport::Transport,
    /// First frame in sight and how many; `None` for the whole clip.
    view: Option<(f64, f64)>,
    /// Where a selection that is being dragged began.
    anchor: Option<FrameIndex>,
    clip: String,
    followed: FrameIndex,
}

impl Timeline {
    /// Height of the panel with its margins, points.
    pub const HEIGHT: f32 = 216.0;

    /// Carries out what concerns the timeline alone; `false` where the command is somebody else's.
    pub fn perform(&mut self, command: UiCommand) -> bool {
        if command == UiCommand::GoToFrame {
            self.transport.wants_focus = true;
        }
        command == UiCommand::GoToFrame
    }

    /// The rows of the open session.
    pub fn rows(&mut self, workspace: &Workspace) -> &Rows {
        self.rows.rows(workspace)
    }

    /// How often all frames were looked at since the start: once per change, however often it is drawn.
    pub fn times_computed(&self) -> u64 {
        self.rows.times_made()
    }

    /// Draws it.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        ui.spacing_mut().item_spacing = vec2(4.0, 4.0);
        let Some(workspace) = cx.workspace else {
            self.transport.show(ui, cx, 0);
            return nothing(ui, cx, "The frames of an open clip appear here");
        };
        if self.clip != workspace.document().clip.id {
            self.clip.clone_from(&workspace.document().clip.id);
            (self.view, self.anchor) = (None, None);
        }
        let problems = self.rows.rows(workspace).problems.len();
        self.transport.show(ui, cx, problems);
        if workspace.frame_count() == 0 {
            return nothing(ui, cx, "Reading the clip…");
        }
        self.show_tracks(ui, cx, workspace);
    }

    fn show_tracks(&mut self, ui: &mut Ui, cx: &mut Context<'_>, workspace: &Workspace) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let x = Rangef::new(rect.left() + GUTTER, (rect.right() - RIGHT).max(rect.left() + GUTTER + 1.0));
        let mut scale = self.scale(x, workspace);
        scale = self.zoom(ui, &response, scale, workspace.playhead);
        self.drag(ui, cx, &response, &scale);
        step_by_keys(ui, cx, &response);
        describe(&response, workspace);
        if ui.is_rect_visible(rect) {
            let rows = self.rows.rows(workspace);
            let places = rows::Places::new(rect, x);
            rows::paint(ui, cx, workspace, rows, &scale, &places);
            filmstrip::paint(ui, cx, &mut self.thumbnails, &scale, places.filmstrip, workspace);
            rows::paint_marks(ui, cx, workspace, &scale, &places, response.has_focus());
        }
        self.hover(ui, cx, workspace, response, &scale, rect);
    }

    fn scale(&self, x: Rangef, workspace: &Workspace) -> Scale {
        let count = workspace.frame_count() as u32;
        match self.view {
            Some((start, length)) => Scale::part(x, count, start, length),
            None => Scale::whole(x, count),
        }
    }

    /// Ctrl+wheel zooms at the pointer, the wheel alone moves along; a playhead that moved stays in sight.
    fn zoom(&mut self, ui: &Ui, response: &Response, scale: Scale, playhead: FrameIndex) -> Scale {
        let mut wanted = scale;
        if let Some(pointer) = response.hover_pos() {
            let (zoom, scroll) = ui.input(|input| (input.zoom_delta(), input.smooth_scroll_delta()));
            if zoom != 1.0 {
                wanted = wanted.zoomed(f64::from(zoom), pointer.x);
            }
            let along = scroll.x + scroll.y;
            if along != 0.0 {
                wanted = wanted.moved(-along);
            }
        }
        if self.followed != playhead {
            self.followed = playhead;
            wanted = wanted.showing(playhead.0);
        }
        let length = wanted.shown.1 - wanted.shown.0;
        let whole = length >= f64::from(wanted.count) - 1e-6;
        self.view = (!whole).then_some((wanted.shown.0, length));
        wanted
    }

    /// Dragging scrubs; with Shift it selects frames.
    fn drag(&mut self, ui: &Ui, cx: &mut Context<'_>, response: &Response, scale: &Scale) {
        if !response.is_pointer_button_down_on() && !response.clicked() {
            self.anchor = None;
            return;
        }
        let Some(pointer) = response.interact_pointer_pos() else { return };
        // Beyond the ends the frame at the end is meant, else a zoomed view would run away.
        let frame = scale.frame_at(pointer.x.clamp(scale.x.min, scale.x.max - 0.5));
        let selects = ui.input(|input| input.modifiers.contains(Modifiers::SHIFT));
        if selects || self.anchor.is_some() {
            let anchor = *self.anchor.get_or_insert(frame);
            cx.options.selection = Some((anchor.min(frame), anchor.max(frame)));
        }
        if cx.workspace.is_some_and(|workspace| workspace.playhead != frame) {
            cx.ask(Action::Seek(frame));
        }
    }

    fn hover(
        &mut self,
        ui: &Ui,
        cx: &mut Context<'_>,
        workspace: &Workspace,
        response: Response,
        scale: &Scale,
        rect: Rect,
    ) {
        let Some(pointer) = response.hover_pos().filter(|pointer| scale.x.contains(pointer.x)) else {
            return;
        };
        let frame = scale.frame_at(pointer.x);
        let stroke = egui::Stroke::new(1.0, cx.tokens.muted);
        ui.painter().vline(scale.middle(frame.0), rect.y_range(), stroke);
        if response.dragged() {
            return;
        }
        response.on_hover_ui_at_pointer(|ui| {
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = 12.0;
                if let Some(size) = workspace.size() {
                    filmstrip::picture(ui, cx, &mut self.thumbnails, frame, size);
                }
                ui.vertical(|ui| words::show(ui, cx.tokens, workspace, frame));
            });
        });
    }
}

/// With the keyboard the timeline keeps the keys that step through frames, which controls have elsewhere.
fn step_by_keys(ui: &Ui, cx: &mut Context<'_>, response: &Response) {
    if !response.has_focus() {
        return;
    }
    let arrows = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
    // Those with more modifiers first: they are the more special ones.
    for command in [UiCommand::BackTen, UiCommand::OnTen, UiCommand::PreviousFrame, UiCommand::NextFrame] {
        if ui.input_mut(|input| input.consume_shortcut(&command.keys()[0])) {
            cx.ask(Action::Run(command));
        }
    }
}

/// Says to a screen reader, and to tests, what is drawn.
fn describe(response: &Response, workspace: &Workspace) {
    let value = f64::from(workspace.playhead.0);
    response.widget_info(|| WidgetInfo::slider(true, value, "Timeline"));
}

fn nothing(ui: &mut Ui, cx: &Context<'_>, text: &str) {
    let rect = ui.available_rect_before_wrap();
    let at = pos2(rect.center().x, rect.center().y - 8.0);
    let place = Rect::from_center_size(at, vec2(rect.width(), 24.0));
    ui.put(place, egui::Label::new(small(cx.tokens, text)));
}
