//! What an operator's program asks of the engine.

use std::{path::PathBuf, sync::Arc};

use super::PictureRequest;
use crate::{
    clip::FrameIndex,
    geometry::{Pixel, Side},
    landmarks::KEYPOINT_COUNT,
    segment::RleMask,
    session::{Author, Document, Entry, MaskId, MaskLayer},
};

/// Counts the changes of a session's document in the caller's order; answers carry the one they were made for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Revision(pub u64);

impl Revision {
    /// The one after this.
    pub const fn next(self) -> Self {
        Self(self.0 + 1)
    }
}

/// One change of the session that must reach the disk.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Who made it.
    pub author: Author,
    /// What the journal will say.
    pub entry: Entry,
    /// Masks the entry names that may not be stored yet; they are stored before its line is written.
    pub masks: Vec<(MaskId, Arc<RleMask>)>,
}

/// A request.
#[derive(Clone, Debug)]
pub enum Request {
    /// Opens a clip (its session beside the results, created where there is none) or a session folder, closing what
    /// was open. Answer: [`super::Event::Opened`] or [`super::Event::NotOpened`].
    Open(PathBuf),
    /// Closes what is open.
    Close,
    /// Lists a folder's clips and sessions, or a manifest's. Answer: [`super::Event::Queue`].
    Survey(PathBuf),
    /// Keeps a change on disk. Answer: [`super::Event::Save`].
    Keep(Change),
    /// Tries at once to write what could not be written.
    RetrySave,
    /// Keeps the session, with everything not written yet, in another folder from now on.
    SaveElsewhere(PathBuf),
    /// Finds everything out for this document, replacing work in progress. Unchanged stages cost nothing.
    /// Answers: [`super::Event::Found`] and more.
    Work {
        /// The document to work for.
        document: Arc<Document>,
        /// Its revision.
        revision: Revision,
    },
    /// Holds or goes on with the work in progress.
    Pause(bool),
    /// Stops the work in progress; what was found stays.
    Cancel,
    /// Wants a picture; an older wish of the same kind that was not begun is dropped.
    Show(PictureRequest),
    /// A mask on one frame from points. Answer: [`super::Event::Draft`].
    Segment {
        /// Which mask it is to become.
        layer: MaskLayer,
        /// The frame.
        frame: FrameIndex,
        /// Points on it.
        positive: Vec<Pixel>,
        /// Points beside it.
        negative: Vec<Pixel>,
    },
    /// A hand on one frame alone, fitted to keypoints that are being dragged. An older wish that was not begun is
    /// dropped. Answer: [`super::Event::HandDraft`].
    FitHand {
        /// The frame.
        frame: FrameIndex,
        /// Which hand.
        side: Side,
        /// Its keypoints as they are now.
        keypoints: Box<[Pixel; KEYPOINT_COUNT]>,
    },
    /// Writes the results of the saved session. Answer: [`super::Event::Exported`].
    Export,
    /// Stops the export.
    CancelExport,
}
