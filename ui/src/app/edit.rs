//! Changes of the session: applied at once to the mirror, kept on disk by the engine, and worked for.

use std::sync::Arc;

use agenticfocus::{
    clip::FrameIndex,
    engine::{Change, Request},
    image::Mask,
    segment::RleMask,
    session::{Author, Command, Document, Entry, MaskEdit, MaskId, MaskLayer, Step},
};

use super::OperatorApp;

impl OperatorApp {
    /// A change by the operator: one undo step.
    pub(super) fn change(&mut self, command: Command, masks: Vec<(MaskId, Arc<RleMask>)>) {
        if self.take_entry(Author::Human, Entry::Do(command), masks) {
            self.follow_up();
        }
    }

    /// Takes the last step back, or does it again.
    pub(super) fn step_history(&mut self, entry: Entry) {
        if self.take_entry(Author::Human, entry, Vec::new()) {
            self.follow_up();
        }
    }

    /// A decision of the machine's: no step of undo, and no reason to work anew.
    pub(super) fn found(&mut self, author: Author, command: Command) {
        self.take_entry(author, Entry::Found(command), Vec::new());
    }

    /// Applies an entry to the mirror and sends it to be kept; `false` when nothing changed.
    fn take_entry(&mut self, author: Author, entry: Entry, masks: Vec<(MaskId, Arc<RleMask>)>) -> bool {
        let Some(workspace) = &mut self.workspace else { return false };
        let by_human = author == Author::Human;
        if !workspace.is_writable() {
            if by_human {
                self.say("Read-only: another program writes to this session");
            }
            return false;
        }
        match workspace.history.apply(entry.clone()) {
            Ok(true) => {}
            Ok(false) => return false,
            Err(error) => {
                self.say(&format!("Not changed: {error}"));
                return false;
            }
        }
        for (id, mask) in &masks {
            workspace.masks.insert(id.clone(), Arc::clone(mask));
        }
        if by_human {
            workspace.revision = workspace.revision.next();
        }
        workspace.changes_sent += 1;
        self.engine.send(Request::Keep(Change { author, entry, masks }));
        true
    }

    /// A mask the operator made.
    pub(super) fn change_mask(&mut self, layer: MaskLayer, frame: FrameIndex, mask: &Mask) {
        let Some((id, mask)) = self.encoded(mask) else { return };
        let edit = Some(MaskEdit::Mask(id.clone()));
        self.change(Command::SetMask { layer, frame, edit }, vec![(id, mask)]);
    }

    /// The template's mask the operator made.
    pub(super) fn change_template_mask(&mut self, mask: &Mask) {
        let Some((id, mask)) = self.encoded(mask) else { return };
        let Some(workspace) = &self.workspace else { return };
        let chosen = workspace.document().template.frame;
        let found = workspace.found.template.as_ref().map(|template| template.frame);
        let set_mask = Command::SetTemplateMask(Some(id.clone()));
        // The mask is of one frame: the choice of that frame belongs to it.
        let command = match (chosen, found) {
            (None, Some(frame)) => Command::Together(vec![Command::SetTemplateFrame(Some(frame)), set_mask]),
            _ => set_mask,
        };
        self.change(command, vec![(id, mask)]);
    }

    fn encoded(&mut self, mask: &Mask) -> Option<(MaskId, Arc<RleMask>)> {
        let mask = Arc::new(RleMask::encode(mask));
        match MaskId::of(&mask) {
            Ok(id) => Some((id, mask)),
            Err(error) => {
                self.say(&format!("Mask not kept: {error}"));
                None
            }
        }
    }

    /// Shows and computes a change that is not kept.
    pub(super) fn preview(&mut self, command: Command) {
        let Some(workspace) = &mut self.workspace else { return };
        let mut document = workspace.document().clone();
        if document.apply(command).is_err() {
            // The field is being typed into; the final change says what is wrong.
            return;
        }
        workspace.revision = workspace.revision.next();
        let document = Arc::new(document);
        self.work_for(document);
    }

    /// After a change: masks wait until they are propagated, everything else is worked out at once.
    pub(super) fn follow_up(&mut self) {
        let Some(workspace) = &self.workspace else { return };
        let document = workspace.document();
        let only_masks = self.working.as_ref().is_some_and(|(_, worked)| {
            let mut same = document.clone();
            same.object_masks.clone_from(&worked.object_masks);
            same.object_reach.clone_from(&worked.object_reach);
            same.arm_masks.clone_from(&worked.arm_masks);
            same == **worked && *document != **worked
        });
        if only_masks && self.options.step == Step::Masks {
            return;
        }
        self.work();
    }

    /// Asks for everything about the document as it stands.
    pub(super) fn work(&mut self) {
        let Some(workspace) = &self.workspace else { return };
        let document = Arc::new(workspace.document().clone());
        self.work_for(document);
    }

    fn work_for(&mut self, document: Arc<Document>) {
        let Some(workspace) = &mut self.workspace else { return };
        let revision = workspace.revision;
        workspace.worked_for = Some(revision);
        self.working = Some((revision, Arc::clone(&document)));
        self.engine.send(Request::Work { document, revision });
    }

    /// Whether masks were edited since the engine was last asked to spread them.
    pub(super) fn masks_wait(&self) -> bool {
        let (Some(workspace), Some((_, worked))) = (&self.workspace, &self.working) else { return false };
        let document = workspace.document();
        document.object_reach != worked.object_reach
            || [MaskLayer::Object, MaskLayer::Arms]
                .iter()
                .any(|layer| document.masks(*layer) != worked.masks(*layer))
    }
}
