//! Where the operator goes: clips, frames, steps.

use std::path::{Path, PathBuf};

use agenticfocus::{
    clip::FrameIndex,
    engine::Request,
    session::{MaskLayer, Step},
};

use super::OperatorApp;
use crate::state::StepState;

impl OperatorApp {
    /// Opens whatever lies at `path`.
    pub(super) fn open_path(&mut self, path: PathBuf) {
        // A clip of the queue is found through the queue.
        if !self.queue.items.iter().any(|item| item.path == path) {
            self.recent.add(&path);
        }
        if is_queue(&path) {
            self.options.queue_open = true;
            self.engine.send(Request::Survey(path));
        } else {
            self.opening = Some(path.clone());
            self.engine.send(Request::Open(path));
        }
    }

    /// Opens the next clip that nobody decided about.
    pub(super) fn open_next(&mut self) {
        let id = self.workspace.as_ref().map(|workspace| workspace.document().clip.id.clone());
        match self.queue.next_unreviewed(id.as_deref()).map(|item| item.path.clone()) {
            Some(path) => self.open_path(path),
            None => self.say("Every clip of the queue is reviewed"),
        }
    }

    /// Shows a frame.
    pub(super) fn seek(&mut self, frame: FrameIndex) {
        let Some(workspace) = &mut self.workspace else { return };
        workspace.playhead = frame.min(workspace.last_frame());
        if let Some(draft) = &workspace.draft
            && draft.frame != workspace.playhead
        {
            workspace.draft = None;
        }
        self.options.playing = false;
    }

    /// Shows the frame `by` frames away.
    pub(super) fn seek_by(&mut self, by: i64) {
        let Some(workspace) = &self.workspace else { return };
        let to = (i64::from(workspace.playhead.0) + by).clamp(0, i64::from(workspace.last_frame().0));
        self.seek(FrameIndex(to as u32));
    }

    /// Shows the nearest of `frames` before or behind the playhead.
    pub(super) fn seek_among(&mut self, frames: &[FrameIndex], forward: bool, nothing: &str) {
        let Some(workspace) = &self.workspace else { return };
        let here = workspace.playhead;
        let to = if forward {
            frames.iter().filter(|frame| **frame > here).min()
        } else {
            frames.iter().filter(|frame| **frame < here).max()
        };
        match to {
            Some(frame) => self.seek(*frame),
            None => self.say(nothing),
        }
    }

    /// Frames a person edited: masks, placements, hands.
    pub(super) fn edited_frames(&self) -> Vec<FrameIndex> {
        let Some(workspace) = &self.workspace else { return Vec::new() };
        let document = workspace.document();
        let mut frames: Vec<FrameIndex> = document.masks(MaskLayer::Object).keys().copied().collect();
        frames.extend(document.masks(MaskLayer::Arms).keys());
        frames.extend(document.template.placements.keys());
        frames.extend(document.hand_edits.iter().flat_map(|(_, edits)| edits.keys()));
        frames.sort_unstable();
        frames.dedup();
        frames
    }

    /// Goes to a step; masks that wait to be spread are spread when the operator leaves theirs.
    pub(super) fn set_step(&mut self, step: Step) {
        let leaves_masks = self.options.step == Step::Masks && step != Step::Masks;
        self.options.step = step;
        if let Some(workspace) = &mut self.workspace {
            workspace.draft = None;
        }
        if leaves_masks && self.masks_wait() {
            self.work();
        }
    }

    /// Goes one step on or back.
    pub(super) fn walk_steps(&mut self, forward: bool) {
        let count = Step::ALL.len();
        let here = Step::ALL.iter().position(|step| *step == self.options.step).unwrap_or(0);
        let next = if forward { (here + 1) % count } else { (here + count - 1) % count };
        self.set_step(Step::ALL[next]);
    }

    /// The step a session opens at: the first that nobody confirmed.
    pub(super) fn first_open_step(&self) -> Step {
        let Some(workspace) = &self.workspace else { return Step::Object };
        let confirmed = &workspace.document().confirmed;
        Step::ALL.into_iter().find(|step| !confirmed.contains(step)).unwrap_or(Step::Review)
    }

    /// The next step after `step` that wants a person; the review where none does.
    pub(super) fn next_open_step(&self, step: Step) -> Step {
        let Some(workspace) = &self.workspace else { return step };
        let later = Step::ALL.into_iter().filter(|other| *other > step);
        later
            .filter(|other| *other != Step::Review)
            .find(|other| matches!(workspace.step_state(*other), StepState::NeedsLook(_)))
            .unwrap_or(Step::Review)
    }
}

/// Whether `path` is a list of clips: a folder that is no session, or a manifest.
fn is_queue(path: &Path) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("afs") => false,
        Some("toml" | "jsonl") => true,
        _ => path.is_dir(),
    }
}
