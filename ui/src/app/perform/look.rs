//! How things are looked at: selection, playing, theme, scale.

use super::super::OperatorApp;
use crate::{
    state::{BeforeAfter, PlaySpeed},
    theme::ThemeChoice,
    ui_command::UiCommand as C,
};

/// Scale steps of the whole window.
const ZOOM_STEP: f32 = 1.1;

impl OperatorApp {
    pub(super) fn perform_look(&mut self, command: C) {
        let options = &mut self.options;
        match command {
            C::PlayPause => {
                let at_end =
                    self.workspace.as_ref().is_some_and(|space| space.playhead == space.last_frame());
                if at_end && !options.playing {
                    self.seek(agenticfocus::clip::FrameIndex(0));
                }
                self.options.playing = !self.options.playing;
            }
            C::Slower => options.speed = neighbour(options.speed, false),
            C::Faster => options.speed = neighbour(options.speed, true),
            C::SelectFrom | C::SelectTo => self.select(command == C::SelectFrom),
            C::SelectNothing => {
                options.selection = None;
                if let Some(workspace) = &mut self.workspace {
                    workspace.draft = None;
                }
            }
            C::Controls => {
                options.inspector_open = true;
                self.inspector.take_keyboard();
            }
            C::ThemeDark => options.theme = ThemeChoice::Dark,
            C::ThemeLight => options.theme = ThemeChoice::Light,
            C::Larger => options.zoom = (options.zoom * ZOOM_STEP).min(2.5),
            C::Smaller => options.zoom = (options.zoom / ZOOM_STEP).max(0.6),
            // Canvas and shell carry out what is left, or it lasts as long as its key.
            _ => {}
        }
    }

    fn select(&mut self, start: bool) {
        let Some(workspace) = &self.workspace else { return };
        let here = workspace.playhead;
        let (first, last) = self.options.selection.unwrap_or((here, here));
        self.options.selection = Some(if start { (here, last.max(here)) } else { (first.min(here), here) });
    }

    pub(super) fn compare(&mut self) {
        self.options.before_after = match self.options.before_after {
            BeforeAfter::After => BeforeAfter::Before,
            BeforeAfter::Before => BeforeAfter::Wipe(0.5),
            BeforeAfter::Wipe(_) => BeforeAfter::After,
        };
    }
}

fn neighbour(speed: PlaySpeed, faster: bool) -> PlaySpeed {
    let all = PlaySpeed::ALL;
    let at = all.iter().position(|other| *other == speed).unwrap_or(0);
    all[if faster { (at + 1).min(all.len() - 1) } else { at.saturating_sub(1) }]
}
