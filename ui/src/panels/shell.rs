//! Puts the window together: bars, queue, inspector, timeline, and the canvas in what is left.

use egui::{Align, CentralPanel, Frame, Layout, Margin, Panel, Sense, Ui, UiBuilder};

use super::{QueuePanel, StatusBar, Timeline, TopBar};
use crate::{
    key_sheet::KeySheet,
    palette::Palette,
    state::{Context, Options},
    theme,
    ui_command::UiCommand,
};

/// Below this width of the window the queue folds away, points.
const NARROW: f32 = 1100.0;
/// Width of the queue, points.
const QUEUE: f32 = 220.0;
/// Width of the inspector, points.
const INSPECTOR: f32 = 320.0;

/// Everything around canvas and inspector.
#[derive(Debug, Default)]
pub struct Shell {
    /// The bar at the top.
    pub top_bar: TopBar,
    /// The clips of the folder.
    pub queue: QueuePanel,
    /// The timeline.
    pub timeline: Timeline,
    /// The bar at the bottom.
    pub status_bar: StatusBar,
    /// The command palette.
    pub palette: Palette,
    /// The key sheet.
    pub key_sheet: KeySheet,
    /// Whether the window was narrow, and whether the queue was open before it became so.
    narrow: Option<bool>,
}

/// Draws `contents` into all of `ui` and no more: a row that is too long would move the panel's edge otherwise.
fn fixed(ui: &mut Ui, contents: impl FnOnce(&mut Ui)) {
    let rect = ui.available_rect_before_wrap();
    ui.allocate_rect(rect, Sense::hover());
    contents(&mut ui.new_child(UiBuilder::new().max_rect(rect).layout(Layout::top_down(Align::Min))));
}

impl Shell {
    /// Carries out what concerns the frame of the window alone; `false` where the command is somebody else's.
    pub fn perform(&mut self, command: UiCommand, cx: &mut Context<'_>) -> bool {
        match command {
            UiCommand::Palette => self.palette.toggle(cx.options),
            UiCommand::Keys => cx.options.keys_open = !cx.options.keys_open,
            UiCommand::ToggleQueue => cx.options.queue_open = !cx.options.queue_open,
            UiCommand::ToggleInspector => cx.options.inspector_open = !cx.options.inspector_open,
            _ => return self.timeline.perform(command),
        }
        true
    }

    /// Draws the whole window; `canvas` and `inspector` draw their parts of it.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut Context<'_>,
        canvas: impl FnOnce(&mut Ui, &mut Context<'_>),
        inspector: impl FnOnce(&mut Ui, &mut Context<'_>),
    ) {
        theme::apply(ui.ctx(), cx.tokens);
        self.fold_queue(ui, cx);
        let panel = |horizontal, vertical| {
            Frame::new().fill(cx.tokens.panel).inner_margin(Margin::symmetric(horizontal, vertical))
        };
        let (bar, side, low) = (panel(8, 6), panel(0, 0), panel(8, 0));
        let time = panel(12, 6);
        Panel::top("top bar").exact_size(36.0).frame(bar).show(ui, |ui| self.top_bar.show(ui, cx));
        Panel::bottom("status bar").exact_size(26.0).frame(low).show(ui, |ui| self.status_bar.show(ui, cx));
        Panel::bottom("timeline")
            .exact_size(Timeline::HEIGHT)
            .frame(time)
            .show(ui, |ui| self.timeline.show(ui, cx));
        if cx.options.queue_open {
            Panel::left("queue")
                .exact_size(QUEUE)
                .resizable(false)
                .frame(side)
                .show(ui, |ui| fixed(ui, |ui| self.queue.show(ui, cx)));
        }
        if cx.options.inspector_open {
            Panel::right("inspector")
                .exact_size(INSPECTOR)
                .resizable(false)
                .frame(side)
                .show(ui, |ui| fixed(ui, |ui| inspector(ui, cx)));
        }
        // The canvas has a ground of its own.
        CentralPanel::default().frame(Frame::NONE).show(ui, |ui| canvas(ui, cx));
        self.palette.show(ui, cx);
        self.key_sheet.show(ui, cx);
    }

    /// Whether the operator wants the queue, were there room.
    pub fn queue_wanted(&self, options: &Options) -> bool {
        options.queue_open || self.narrow == Some(true)
    }

    /// Folds the queue away when the window becomes narrow, and back when it becomes wide again.
    fn fold_queue(&mut self, ui: &Ui, cx: &mut Context<'_>) {
        let narrow = ui.max_rect().width() < NARROW;
        match (narrow, self.narrow) {
            (true, None) => {
                self.narrow = Some(cx.options.queue_open);
                cx.options.queue_open = false;
            }
            (false, Some(was_open)) => {
                self.narrow = None;
                cx.options.queue_open |= was_open;
            }
            _ => {}
        }
    }
}
