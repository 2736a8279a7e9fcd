//! What the engine tells.

use std::{collections::BTreeMap, path::PathBuf, sync::Arc, time::SystemTime};

use super::{Finding, ModelUse, PictureRequest, Revision, Shown};
use crate::{
    clip::FrameIndex,
    geometry::{Pixel, Side},
    hands::HandFrame,
    image::Rgb8,
    landmarks::KEYPOINT_COUNT,
    segment::RleMask,
    session::{Author, Command, History, LockHolder, MaskId, MaskLayer, ReviewState},
};

/// Whether a session can be changed.
#[derive(Clone, Debug, PartialEq)]
pub enum Access {
    /// Yes.
    Writable,
    /// Another program writes to it.
    ReadOnly(LockHolder),
}

/// Whether everything reached the disk.
#[derive(Clone, Debug, PartialEq)]
pub enum SaveState {
    /// All changes up to and including this many, counted from opening.
    Saved(u64),
    /// Changes wait; they are tried again every few seconds.
    NotSaved {
        /// Changes that did reach the disk.
        saved: u64,
        /// When it first failed.
        since: SystemTime,
        /// Why, in words.
        reason: String,
    },
}

/// An open session.
#[derive(Clone, Debug)]
pub struct Opened {
    /// The session's folder.
    pub folder: PathBuf,
    /// The document and its undo steps.
    pub history: History,
    /// The session's masks.
    pub masks: BTreeMap<MaskId, Arc<RleMask>>,
    /// Whether it can be changed.
    pub access: Access,
    /// What had to be mended, in words.
    pub notes: Vec<String>,
}

/// A clip or session in a folder.
#[derive(Clone, Debug)]
pub struct QueueItem {
    /// Its id.
    pub id: String,
    /// What to open.
    pub path: PathBuf,
    /// Review.
    pub review: ReviewState,
    /// Flags of its last export, for example `truncated`.
    pub flags: Vec<String>,
    /// Whether results are there.
    pub exported: bool,
    /// A small picture of its first frame.
    pub thumbnail: Option<Arc<Rgb8>>,
    /// Why it cannot be used, in words.
    pub fault: Option<String>,
}

/// Why work ended early.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorkFailure {
    /// The stage, as reports name it.
    pub stage: Option<String>,
    /// What happened, to what, and what to do.
    pub message: String,
}

/// A mask made from points.
#[derive(Clone, Debug, PartialEq)]
pub struct Drafted {
    /// The mask.
    pub mask: Arc<RleMask>,
    /// The back end that made it, as records name back ends.
    pub backend: String,
}

/// Something the engine tells.
#[derive(Clone, Debug)]
pub enum Event {
    /// A session is open.
    Opened(Box<Opened>),
    /// It could not be opened.
    NotOpened {
        /// What was to be opened.
        path: PathBuf,
        /// Why, and what to do.
        message: String,
    },
    /// Clips of a folder; their pictures come one by one.
    Queue {
        /// The folder or manifest.
        path: PathBuf,
        /// Its clips, sorted by name.
        items: Vec<QueueItem>,
    },
    /// The picture of one of them.
    QueueThumbnail {
        /// The folder or manifest.
        path: PathBuf,
        /// What the item opens.
        item: PathBuf,
        /// A small picture of its first frame.
        picture: Arc<Rgb8>,
    },
    /// How saving stands.
    Save(SaveState),
    /// How the work goes on.
    Progress {
        /// The stage as reports name it.
        stage: &'static str,
        /// Share of all work that is done, 0 to 1.
        share: f64,
        /// Seconds left, once that can be told.
        left: Option<f64>,
    },
    /// Something was found out.
    Found {
        /// For which document.
        revision: Revision,
        /// What.
        finding: Finding,
    },
    /// The machine decided something that belongs into the session.
    Decided {
        /// For which document.
        revision: Revision,
        /// Which back end.
        author: Author,
        /// What.
        command: Command,
    },
    /// Work for this document ended: `Ok` when everything was found out, `Err(None)` when it was cancelled.
    WorkEnded {
        /// For which document.
        revision: Revision,
        /// How.
        result: Result<(), Option<WorkFailure>>,
    },
    /// A picture.
    Picture {
        /// What was asked.
        request: PictureRequest,
        /// The picture, or why there is none.
        result: Result<Shown, String>,
    },
    /// A mask made from points.
    Draft {
        /// Which mask it is to become.
        layer: MaskLayer,
        /// On which frame.
        frame: FrameIndex,
        /// The points it was made from: on it and beside it.
        points: (Vec<Pixel>, Vec<Pixel>),
        /// The mask, or why there is none.
        result: Result<Drafted, String>,
    },
    /// A hand fitted to keypoints that are being dragged.
    HandDraft {
        /// The frame.
        frame: FrameIndex,
        /// Which hand.
        side: Side,
        /// The keypoints it was fitted to.
        keypoints: Box<[Pixel; KEYPOINT_COUNT]>,
        /// The hand, invalid where nothing fits; or why there is none.
        result: Result<Box<HandFrame>, String>,
    },
    /// How it stands with a learned model.
    Model {
        /// What it is used for.
        purpose: ModelUse,
        /// Why it is done without, in one line; `None` where nothing is wrong: it did its part, or none is there.
        fault: Option<String>,
    },
    /// How the export goes on, 0 to 1.
    ExportProgress {
        /// Share done.
        share: f64,
        /// Seconds left, once that can be told.
        left: Option<f64>,
    },
    /// The export ended: the folder with the results; `Err(None)` when it was cancelled.
    Exported(Result<PathBuf, Option<WorkFailure>>),
    /// Something worth a line in the log.
    Note(String),
}
