//! The session document: commands, journal, undo, review state.
//!
//! A session is a folder `NAME.afs/`. [`Session::apply`] is the only thing that changes its
//! [`Document`]; a command is acknowledged when its journal line is on disk. Everything here builds
//! without the feature `engine`, so that the same document can live in a browser.

mod apply;
mod command;
mod document;
mod durable;
mod error;
mod folder;
mod history;
mod journal;
mod lock;
mod mask_store;
mod object_answer;
mod settings;
mod step;

pub use apply::ApplyError;
pub use command::{Author, Command};
pub use document::{
    ClipReference, Document, HandEdit, LayerOrder, LayerOrderRange, MaskEdit, MaskLayer, MaskReach,
    ObjectChoice, ObjectPromptKind, ObjectProposal, ReviewState, SidesSwapped, TemplateEdits,
};
pub use durable::write_durably;
pub use error::SessionError;
pub use folder::{LoadReport, Session};
pub use history::{Entry, History};
pub use journal::{JournalLine, parse_journal};
pub use lock::{LockHolder, SessionLock};
pub use mask_store::{FreshMasks, MaskId, MaskStore};
pub use object_answer::{ObjectAnswer, Said};
pub use settings::RetargetSettings;
pub use step::Step;

/// The version of the folder's format that this build writes and the newest it reads.
pub const FORMAT_VERSION: u32 = 1;
