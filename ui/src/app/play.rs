//! Playing the clip.

use std::time::{Duration, Instant};

use agenticfocus::clip::{FrameIndex, STANDARD_FPS};

use super::OperatorApp;

/// Where playing began.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Play {
    since: Option<(Instant, FrameIndex, f64)>,
}

impl OperatorApp {
    /// Moves the playhead while the clip plays; stops at the end.
    pub(super) fn keep_playing(&mut self, ctx: &egui::Context) {
        let Some(workspace) = &mut self.workspace else { return };
        if !self.options.playing {
            self.play.since = None;
            return;
        }
        let rate = STANDARD_FPS * self.options.speed.factor();
        let fresh = self.play.since.is_none_or(|(_, _, known)| (known - rate).abs() > 1e-9);
        if fresh {
            self.play.since = Some((Instant::now(), workspace.playhead, rate));
        }
        let Some((since, from, _)) = self.play.since else { return };
        let last = workspace.last_frame();
        let frames = (since.elapsed().as_secs_f64() * rate) as u32;
        workspace.playhead = FrameIndex(from.0.saturating_add(frames).min(last.0));
        if workspace.playhead == last {
            self.options.playing = false;
            self.play.since = None;
        } else {
            ctx.request_repaint_after(Duration::from_secs_f64(0.5 / rate));
        }
    }
}
