//! What the engine told since the last frame.

use agenticfocus::engine::{Access, Event, Request};

use super::OperatorApp;
use crate::state::{HandDraft, Work, Workspace};

impl OperatorApp {
    /// Takes every waiting event.
    pub(super) fn hear_engine(&mut self) {
        while let Some(event) = self.engine.poll() {
            self.hear(event);
        }
    }

    fn hear(&mut self, event: Event) {
        match event {
            Event::Opened(opened) => self.opened(*opened),
            Event::NotOpened { path, message } => {
                self.opening = None;
                self.recent.forget(&path);
                self.say(&format!("{} not opened: {message}", path.display()));
            }
            Event::Queue { path, items } => {
                self.queue.path = Some(path);
                self.queue.items = items;
            }
            Event::QueueThumbnail { path, item, picture } => self.queue.take_thumbnail(&path, &item, picture),
            Event::Note(text) => self.mention(&text),
            Event::Picture { request, result } => self.pictures.take(request, result),
            other => self.hear_of_session(other),
        }
    }

    fn opened(&mut self, opened: agenticfocus::engine::Opened) {
        self.opening = None;
        self.messages.clear();
        for note in &opened.notes {
            self.say(note);
        }
        self.pictures.clear();
        self.options.selection = None;
        self.options.playing = false;
        let workspace = Workspace::new(opened);
        if let Access::ReadOnly(holder) = &workspace.access {
            self.messages.push(super::Message::new(format!("Read-only: {holder} writes to this session")));
        }
        self.workspace = Some(workspace);
        self.working = None;
        self.options.step = self.first_open_step();
        self.work();
    }

    fn hear_of_session(&mut self, event: Event) {
        let Some(workspace) = &mut self.workspace else { return };
        match event {
            Event::Save(state) => workspace.save = state,
            Event::Progress { stage, share, left } => {
                let paused = matches!(workspace.work, Work::Running { paused: true, .. });
                workspace.work = Work::Running { stage, share, left, paused };
            }
            Event::Found { finding, .. } => {
                workspace.found.take(finding);
                let last = workspace.last_frame();
                workspace.playhead = workspace.playhead.min(last);
            }
            Event::Decided { author, command, .. } => self.found(author, command),
            // An older wish that was replaced ends too; only the newest says how things stand.
            Event::WorkEnded { revision, result } if workspace.worked_for == Some(revision) => {
                workspace.work = match result {
                    Ok(()) => Work::Idle,
                    Err(None) => Work::Cancelled,
                    Err(Some(failure)) => Work::Failed(failure),
                };
            }
            Event::Draft { frame, points, result, .. } => {
                // An answer to fewer points than there are now is out of date.
                let asked = |draft: &&mut crate::state::Draft| {
                    draft.frame == frame && draft.positive == points.0 && draft.negative == points.1
                };
                if let Some(draft) = workspace.draft.as_mut().filter(asked) {
                    match result {
                        Ok(drafted) => {
                            (draft.mask, draft.fault) = (Some(drafted.mask), None);
                            draft.backend = drafted.backend;
                        }
                        Err(fault) => (draft.mask, draft.fault) = (None, Some(fault)),
                    }
                }
            }
            Event::HandDraft { frame, side, keypoints, result: Ok(hand) } => {
                workspace.hand_draft = Some(HandDraft { frame, side, keypoints, hand });
            }
            Event::Model { purpose, fault } => workspace.found.take_model_fault(purpose, fault),
            Event::ExportProgress { share, left } => workspace.exporting = Some((share, left)),
            Event::Exported(result) => {
                workspace.exporting = None;
                match result {
                    Ok(folder) => {
                        workspace.exported = Some(Ok(folder));
                        self.refresh_queue();
                    }
                    Err(None) => self.say("Export stopped; nothing half-made was left"),
                    Err(Some(failure)) => {
                        let message = failure.message.clone();
                        workspace.exported = Some(Err(failure));
                        self.say(&format!("Not exported: {message}"));
                    }
                }
            }
            _ => {}
        }
    }

    /// Reads the queue's states again.
    pub(super) fn refresh_queue(&mut self) {
        if let Some(path) = self.queue.path.clone() {
            self.engine.send(Request::Survey(path));
        }
    }
}
