//! What the engine's threads share: what is wanted, what is open, and what pictures are made from.

use std::{
    collections::VecDeque,
    path::PathBuf,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use super::{Outbox, place_of};
use crate::{
    clip::FrameIndex,
    engine::{Event, PictureRequest, Revision},
    geometry::{Pixel, Side},
    landmarks::KEYPOINT_COUNT,
    pipeline::{ClipJob, Evidence, Installation, LayerPlan, Memory, Stage, Understood},
    segment::RleMask,
    session::{Document, MaskId, MaskLayer},
};

/// The session that is open, as worker and painter need it.
#[derive(Clone, Debug)]
pub(super) struct OpenClip {
    pub(super) job: ClipJob,
    pub(super) folder: PathBuf,
    pub(super) memory: Arc<Memory>,
}

/// Everything a composite is made from, for one document.
#[derive(Clone, Debug)]
pub(super) struct Scene {
    pub(super) revision: Revision,
    pub(super) found: Arc<Understood>,
    pub(super) evidence: Arc<Evidence>,
    pub(super) plan: Arc<LayerPlan>,
}

/// A document somebody wants everything found out for.
#[derive(Clone, Debug)]
pub(super) struct Wish {
    pub(super) document: Arc<Document>,
    pub(super) revision: Revision,
}

/// Points somebody wants a mask from.
#[derive(Clone, Debug)]
pub(super) struct DraftWish {
    pub(super) layer: MaskLayer,
    pub(super) frame: FrameIndex,
    pub(super) positive: Vec<Pixel>,
    pub(super) negative: Vec<Pixel>,
    /// Whether the arms' masks say what the wanted one is not.
    pub(super) arms_matter: bool,
}

#[derive(Default)]
struct State {
    stopping: bool,
    open: Option<OpenClip>,
    wish: Option<Wish>,
    /// The document being worked for, and the stage it is in.
    working: Option<(Arc<Document>, Stage)>,
    scene: Option<Scene>,
    /// Why there is no scene for the newest document.
    fault: Option<String>,
    pictures: [Option<PictureRequest>; 3],
    thumbnails: VecDeque<PictureRequest>,
    draft: Option<DraftWish>,
    hand: Option<HandWish>,
}

/// Shared between the engine's threads.
pub(super) struct Shared {
    pub(super) out: PathBuf,
    pub(super) installation: Installation,
    pub(super) outbox: Outbox,
    state: Mutex<State>,
    changed: Condvar,
    /// Ends the work in progress.
    pub(super) cancel: AtomicBool,
    paused: Mutex<bool>,
    resumed: Condvar,
    pub(super) export_cancel: Arc<AtomicBool>,
    pub(super) exporting: AtomicBool,
}

/// A hand somebody drags.
#[derive(Clone, Debug)]
pub(super) struct HandWish {
    pub(super) frame: FrameIndex,
    pub(super) side: Side,
    pub(super) keypoints: Box<[Pixel; KEYPOINT_COUNT]>,
}

/// What the painter is to do next.
pub(super) enum PaintJob {
    Picture(PictureRequest),
    Draft(DraftWish),
    Hand(HandWish),
    Stop,
}

impl Shared {
    pub(super) fn new(out: PathBuf, installation: Installation, outbox: Outbox) -> Self {
        Self {
            out,
            installation,
            outbox,
            state: Mutex::default(),
            changed: Condvar::new(),
            cancel: AtomicBool::new(false),
            paused: Mutex::new(false),
            resumed: Condvar::new(),
            export_cancel: Arc::default(),
            exporting: AtomicBool::new(false),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Every change leaves the state whole, so that a panic elsewhere has spoilt nothing.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn stop(&self) {
        self.state().stopping = true;
        self.cancel_work();
        self.cancel_export();
        self.changed.notify_all();
    }

    pub(super) fn is_stopping(&self) -> bool {
        self.state().stopping
    }

    /// Another clip is open, or none: what belonged to the last one is forgotten.
    pub(super) fn set_open(&self, open: Option<OpenClip>) {
        let mut state = self.state();
        let stopping = state.stopping;
        *state = State { open, stopping, ..State::default() };
        self.changed.notify_all();
    }

    /// The session lies in another folder now.
    pub(super) fn move_open(&self, folder: PathBuf) {
        if let Some(open) = &mut self.state().open {
            open.folder = folder;
        }
    }

    pub(super) fn open_clip(&self) -> Option<OpenClip> {
        self.state().open.clone()
    }

    /// Holds masks that the desk is about to write, so that work for them need not wait for the disk, and goes on where
    /// it is full.
    pub(super) fn hold_masks(&self, masks: &[(MaskId, Arc<RleMask>)]) {
        let Some(open) = self.open_clip() else { return };
        for (id, mask) in masks {
            open.memory.masks().hold(id.clone(), Arc::clone(mask));
        }
    }

    /// Asks the worker to find everything out for `document`. Work in progress goes on where the change only
    /// touches what comes after it.
    pub(super) fn want_work(&self, document: Arc<Document>, revision: Revision) {
        let mut state = self.state();
        let spoilt = state.working.as_ref().is_some_and(|(old, stage)| {
            first_affected(old, &document).is_some_and(|affected| affected <= *stage)
        });
        state.wish = Some(Wish { document, revision });
        state.fault = None;
        drop(state);
        if spoilt {
            self.cancel.store(true, Ordering::Relaxed);
            self.resumed.notify_all();
        }
        self.changed.notify_all();
    }

    /// Ends the work in progress and what waits behind it.
    pub(super) fn cancel_work(&self) {
        self.state().wish = None;
        self.cancel.store(true, Ordering::Relaxed);
        self.pause(false);
    }

    pub(super) fn cancel_export(&self) {
        self.export_cancel.store(true, Ordering::Relaxed);
    }

    pub(super) fn pause(&self, paused: bool) {
        *self.paused.lock().unwrap_or_else(PoisonError::into_inner) = paused;
        self.resumed.notify_all();
    }

    /// Waits while the work is held.
    pub(super) fn wait_while_paused(&self) {
        let mut paused = self.paused.lock().unwrap_or_else(PoisonError::into_inner);
        while *paused && !self.cancel.load(Ordering::Relaxed) {
            paused = self.resumed.wait(paused).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits for the next wish; `None` when the program ends.
    pub(super) fn next_wish(&self) -> Option<(OpenClip, Wish)> {
        let mut state = self.state();
        loop {
            if state.stopping {
                return None;
            }
            if let (Some(open), Some(wish)) = (state.open.clone(), state.wish.take()) {
                state.working = Some((Arc::clone(&wish.document), Stage::Clip));
                self.cancel.store(false, Ordering::Relaxed);
                return Some((open, wish));
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Notes how far the work is.
    pub(super) fn at_stage(&self, stage: Stage) {
        if let Some((_, now)) = &mut self.state().working {
            *now = stage;
        }
    }

    /// Ends a wish: with a scene, or with the reason why there is none.
    pub(super) fn finish(&self, open: &OpenClip, result: Result<Scene, String>) {
        let mut state = self.state();
        state.working = None;
        // Another clip may have been opened meanwhile.
        if state.open.as_ref().is_none_or(|now| !Arc::ptr_eq(&now.memory, &open.memory)) {
            return;
        }
        match result {
            Ok(scene) => state.scene = Some(scene),
            Err(fault) => state.fault = Some(fault),
        }
        drop(state);
        self.changed.notify_all();
    }

    pub(super) fn scene(&self) -> Option<Scene> {
        self.state().scene.clone()
    }

    pub(super) fn want_picture(&self, request: PictureRequest) {
        let mut state = self.state();
        match place_of(&request.kind) {
            Some(place) => state.pictures[place] = Some(request),
            None => state.thumbnails.push_back(request),
        }
        drop(state);
        self.changed.notify_all();
    }

    pub(super) fn want_draft(&self, wish: DraftWish) {
        self.state().draft = Some(wish);
        self.changed.notify_all();
    }

    pub(super) fn want_hand(&self, wish: HandWish) {
        self.state().hand = Some(wish);
        self.changed.notify_all();
    }

    /// Waits for something to paint: what the operator looks at first, then drafts, then thumbnails.
    pub(super) fn next_paint_job(&self) -> PaintJob {
        let mut state = self.state();
        loop {
            if state.stopping {
                return PaintJob::Stop;
            }
            let has_clip = state.open.as_ref().is_some_and(|open| open.memory.latest_clip().is_some());
            let newest = state.scene.as_ref().map(|scene| scene.revision);
            let faulty = state.fault.is_some();
            if has_clip {
                // A composite waits until its document is worked out, or until that failed.
                let ready = |request: &PictureRequest| {
                    faulty || newest.is_some_and(|newest| newest >= request.revision)
                };
                for place in 0..state.pictures.len() {
                    if state.pictures[place].as_ref().is_some_and(|request| place == 0 || ready(request))
                        && let Some(request) = state.pictures[place].take()
                    {
                        return PaintJob::Picture(request);
                    }
                }
                if let Some(hand) = state.hand.take() {
                    return PaintJob::Hand(hand);
                }
                if let Some(draft) = state.draft.take() {
                    return PaintJob::Draft(draft);
                }
                if let Some(request) = state.thumbnails.pop_front() {
                    return PaintJob::Picture(request);
                }
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Wakes who waits for a decoded clip.
    pub(super) fn clip_is_there(&self) {
        self.changed.notify_all();
    }

    /// Why there is no scene for the newest document.
    pub(super) fn fault(&self) -> Option<String> {
        self.state().fault.clone()
    }

    pub(super) fn tell(&self, event: Event) {
        self.outbox.tell(event);
    }
}

/// The first stage whose result differs between two documents of one clip; `None` when none does.
fn first_affected(old: &Document, new: &Document) -> Option<Stage> {
    let differs = [
        (old.clip != new.clip || old.camera != new.camera, Stage::Clip),
        (
            (&old.hand_track, struck_out(old), &old.sides_swapped)
                != (&new.hand_track, struck_out(new), &new.sides_swapped),
            Stage::Landmarks,
        ),
        (old.arm_masks != new.arm_masks || old.object != new.object, Stage::Arms),
        ((&old.object_masks, &old.object_reach) != (&new.object_masks, &new.object_reach), Stage::Object),
        // The background is restored beside the template.
        (old.template != new.template || old.hole_dilation != new.hole_dilation, Stage::Template),
        (
            old.hand_edits != new.hand_edits || old.retarget.hand_length != new.retarget.hand_length,
            Stage::Hands,
        ),
        (old.retarget != new.retarget, Stage::Retarget),
    ];
    differs.into_iter().find(|(differs, _)| *differs).map(|(_, stage)| stage)
}

/// Hands a person struck out, by side and frame.
fn struck_out(document: &Document) -> Vec<(Side, FrameIndex)> {
    let edits = document.hand_edits.iter();
    edits
        .flat_map(|(side, edits)| edits.iter().map(move |(frame, edit)| (side, *frame, edit)))
        .filter(|(_, _, edit)| edit.invalid)
        .map(|(side, frame, _)| (side, frame))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{Command, LayerOrderRange, RetargetSettings, Step};

    #[test]
    fn a_change_affects_its_own_stage_and_nothing_before() {
        let old = Document::default();
        let with = |command| {
            let mut new = old.clone();
            new.apply(command).unwrap();
            first_affected(&old, &new)
        };
        let alpha = RetargetSettings { alpha: Some(0.3), ..RetargetSettings::default() };
        assert_eq!(with(Command::SetRetarget(alpha)), Some(Stage::Retarget));
        assert_eq!(with(Command::SetHoleDilation(Some(0.02))), Some(Stage::Template));
        assert_eq!(with(Command::SetTemplateFrame(Some(FrameIndex(3)))), Some(Stage::Template));
        assert_eq!(with(Command::SetConfirmed { step: Step::Masks, confirmed: true }), None);
        let order = LayerOrderRange {
            first: FrameIndex(0),
            last: FrameIndex(1),
            order: crate::session::LayerOrder::RobotInFront,
            thumb: None,
        };
        assert_eq!(with(Command::SetLayerOrders(vec![order])), None);
    }
}
