//! The open session: a mirror of its history, what was found out, and where the operator is.

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

use agenticfocus::{
    clip::{FrameIndex, STANDARD_FPS},
    engine::{Access, Opened, Revision, SaveState, WorkFailure},
    geometry::{Pixel, Side, Size},
    hands::HandFrame,
    image::Mask,
    inpaint::InpaintParams,
    landmarks::KEYPOINT_COUNT,
    segment::{MaskAuthor, MaskFlag, RleMask},
    session::{Document, History, MaskEdit, MaskId, MaskLayer, ReviewState, Step},
};

use super::{Findings, StepState};
use crate::paint::SideSplit;

/// What the engine does for this session.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Work {
    /// Nothing (default).
    #[default]
    Idle,
    /// A stage.
    Running {
        /// Its name as reports spell it.
        stage: &'static str,
        /// Share of all work that is done, 0 to 1.
        share: f64,
        /// Seconds left, once that can be told.
        left: Option<f64>,
        /// Held by the operator.
        paused: bool,
    },
    /// Stopped by the operator.
    Cancelled,
    /// Ended early.
    Failed(WorkFailure),
}

/// Points from which a mask is being made on one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draft {
    /// The frame.
    pub frame: FrameIndex,
    /// Points on it.
    pub positive: Vec<Pixel>,
    /// Points beside it.
    pub negative: Vec<Pixel>,
    /// The engine's answer.
    pub mask: Option<Arc<RleMask>>,
    /// Which back end made it, as records name it.
    pub backend: String,
    /// Why there is none.
    pub fault: Option<String>,
}

/// A hand fitted to keypoints that are being dragged, on one frame alone.
#[derive(Clone, Debug, PartialEq)]
pub struct HandDraft {
    /// The frame.
    pub frame: FrameIndex,
    /// Which hand.
    pub side: Side,
    /// The keypoints it was fitted to.
    pub keypoints: Box<[Pixel; KEYPOINT_COUNT]>,
    /// The hand; invalid where nothing fits.
    pub hand: Box<HandFrame>,
}

/// A mask as it stands on a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct MaskOnFrame {
    /// The mask; empty where there is nothing of it.
    pub mask: Arc<RleMask>,
    /// Who made it.
    pub author: MaskAuthor,
    /// Whether a person said there is nothing of it here.
    pub absent: bool,
    /// Trust, 0 to 1.
    pub score: f64,
    /// What is doubtful about it.
    pub flags: Vec<MaskFlag>,
}

/// An open session as the window sees it.
#[derive(Debug)]
pub struct Workspace {
    /// Its folder.
    pub folder: PathBuf,
    /// Whether it can be changed.
    pub access: Access,
    /// The document and its undo steps, ahead of the disk by what the engine still writes.
    pub history: History,
    /// Counts changes of the document.
    pub revision: Revision,
    /// The revision the engine was last told to work for.
    pub worked_for: Option<Revision>,
    /// Masks by their ids.
    pub masks: BTreeMap<MaskId, Arc<RleMask>>,
    /// What was found out.
    pub found: Findings,
    /// What the engine does.
    pub work: Work,
    /// Whether everything reached the disk.
    pub save: SaveState,
    /// Changes sent to the engine since opening.
    pub changes_sent: u64,
    /// The frame on screen.
    pub playhead: FrameIndex,
    /// Points of a mask or an object that is being made.
    pub draft: Option<Draft>,
    /// The hand that is being dragged, as the engine fitted it last.
    pub hand_draft: Option<HandDraft>,
    /// Share of the export that is done, while it runs, and seconds left.
    pub exporting: Option<(f64, Option<f64>)>,
    /// Where the last export went, or why it did not.
    pub exported: Option<Result<PathBuf, WorkFailure>>,
}

impl Workspace {
    /// A session that was just opened.
    pub fn new(opened: Opened) -> Self {
        let Opened { folder, history, masks, access, notes: _ } = opened;
        Self {
            folder,
            access,
            history,
            revision: Revision(1),
            worked_for: None,
            masks,
            found: Findings::default(),
            work: Work::Idle,
            save: SaveState::Saved(0),
            changes_sent: 0,
            playhead: FrameIndex(0),
            draft: None,
            hand_draft: None,
            exporting: None,
            exported: None,
        }
    }

    /// The document now.
    pub fn document(&self) -> &Document {
        self.history.document()
    }

    /// Frames of the clip; 0 until it was decoded.
    pub fn frame_count(&self) -> usize {
        self.found.clip.as_ref().map_or(0, |clip| clip.frame_count())
    }

    /// The last frame.
    pub fn last_frame(&self) -> FrameIndex {
        FrameIndex(self.frame_count().saturating_sub(1) as u32)
    }

    /// Size of the clip's pictures; `None` until it was decoded.
    pub fn size(&self) -> Option<Size> {
        self.found.clip.as_ref().map(|clip| clip.size)
    }

    /// Seconds from the clip's start to `frame`.
    pub fn seconds(&self, frame: FrameIndex) -> f64 {
        f64::from(frame.0) / STANDARD_FPS
    }

    /// Whether changes are possible.
    pub fn is_writable(&self) -> bool {
        self.access == Access::Writable
    }

    /// The mask on `frame`: the person's where there is one, else the machine's newest; `None` before either.
    pub fn mask(&self, layer: MaskLayer, frame: FrameIndex) -> Option<MaskOnFrame> {
        if let Some(edit) = self.document().masks(layer).get(&frame) {
            let mask = match edit {
                MaskEdit::Mask(id) => Arc::clone(self.masks.get(id)?),
                MaskEdit::Absent => Arc::new(RleMask::empty(self.size()?)),
            };
            let absent = matches!(edit, MaskEdit::Absent);
            return Some(MaskOnFrame {
                mask,
                author: MaskAuthor::Human,
                absent,
                score: 1.0,
                flags: Vec::new(),
            });
        }
        let found = match layer {
            MaskLayer::Object => self.found.object_on(frame)?,
            MaskLayer::Arms => self.found.arms_on(frame)?,
        };
        Some(MaskOnFrame {
            mask: Arc::new(found.mask.clone()),
            author: found.author,
            absent: false,
            score: found.score,
            flags: found.flags.clone(),
        })
    }

    /// Which pixels of the arms' mask on `frame` are whose; `None` before the arms were found.
    pub fn side_split(&self, frame: FrameIndex) -> Option<SideSplit> {
        let arms = self.found.arms.as_ref()?;
        let at = frame.as_usize();
        Some(SideSplit::new(arms.sides.left.get(at)?, arms.sides.right.get(at)?))
    }

    /// How far the hole in the background is widened, as a share of the picture's width.
    pub fn hole_dilation(&self) -> f64 {
        self.document().hole_dilation.unwrap_or_else(|| InpaintParams::default().hole_dilation)
    }

    /// Pixels of the mask on `frame`, all unset where there is none; `None` until the clip was decoded.
    pub fn mask_pixels(&self, layer: MaskLayer, frame: FrameIndex) -> Option<Mask> {
        let size = self.size()?;
        Some(self.mask(layer, frame).map_or_else(|| Mask::new(size), |on| on.mask.decode()))
    }

    /// Who made the mask on `frame`, how far to trust it and what is doubtful, without copying the mask.
    pub fn mask_summary(
        &self,
        layer: MaskLayer,
        frame: FrameIndex,
    ) -> Option<(MaskAuthor, f64, &[MaskFlag])> {
        if self.document().masks(layer).contains_key(&frame) {
            return Some((MaskAuthor::Human, 1.0, &[]));
        }
        let found = match layer {
            MaskLayer::Object => self.found.object_on(frame)?,
            MaskLayer::Arms => self.found.arms_on(frame)?,
        };
        Some((found.author, found.score, &found.flags))
    }

    /// Whether a person should look at the object's or the arms' mask on `frame`.
    pub fn is_problem(&self, frame: FrameIndex) -> bool {
        let doubtful = |layer| {
            self.mask_summary(layer, frame).is_some_and(|(author, score, flags)| {
                let counts =
                    flags.iter().any(|flag| !matches!(flag, MaskFlag::TouchesBorder | MaskFlag::Occluded));
                author != MaskAuthor::Human && (counts || score < 0.35)
            })
        };
        doubtful(MaskLayer::Object) || (self.found.object.is_none() && doubtful(MaskLayer::Arms))
    }

    /// Frames that want a look, in order.
    pub fn problems(&self) -> Vec<FrameIndex> {
        FrameIndex::all(self.frame_count()).filter(|frame| self.is_problem(*frame)).collect()
    }

    /// How far `step` is.
    pub fn step_state(&self, step: Step) -> StepState {
        let found = &self.found;
        if self.document().confirmed.contains(&step) {
            return StepState::Confirmed;
        }
        let (done, stages): (bool, &[&str]) = match step {
            Step::Object => {
                (found.choice.is_some() || self.document().object.is_some(), &["clip", "landmarks", "select"])
            }
            Step::Masks => (found.arms.is_some() && found.object.is_some(), &["arms", "object"]),
            Step::Template => (found.template.is_some(), &["template"]),
            Step::Hands => (found.hands.is_some(), &["hands"]),
            Step::Retarget => (found.motion.is_some(), &["retarget"]),
            Step::Composite => (found.order.is_some() && found.background.is_some(), &["inpaint"]),
            Step::Review => return self.review_state(),
        };
        if let Work::Running { stage, .. } = &self.work
            && stages.contains(stage)
        {
            return StepState::Running;
        }
        if !done {
            return StepState::NotRun;
        }
        match step {
            Step::Object if matches!(self.document().review, ReviewState::NeedsReview { .. }) => {
                StepState::NeedsLook(1)
            }
            Step::Masks => match self.problems().len() {
                0 => StepState::Done,
                count => StepState::NeedsLook(count),
            },
            _ => StepState::Done,
        }
    }

    fn review_state(&self) -> StepState {
        match self.document().review {
            ReviewState::Accepted | ReviewState::Rejected { .. } => StepState::Confirmed,
            ReviewState::Flagged { .. } => StepState::NeedsLook(1),
            ReviewState::Unreviewed | ReviewState::NeedsReview { .. } => StepState::NotRun,
        }
    }
}
