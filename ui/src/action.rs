//! What panels ask for. The app carries actions out once a frame, after all panels were drawn.

use std::path::PathBuf;

use agenticfocus::{
    clip::FrameIndex,
    engine::Request,
    image::Mask,
    session::{Command, MaskLayer, Step},
};

use crate::ui_command::UiCommand;

/// Something to be done.
#[derive(Clone, Debug)]
pub enum Action {
    /// What a key or the palette can do too.
    Run(UiCommand),
    /// A change of the session by the operator: one undo step.
    Change(Command),
    /// A change that is shown and computed, not yet kept: while a slider moves. The change that follows replaces it.
    Preview(Command),
    /// A mask the operator made: one undo step.
    ChangeMask {
        /// Which mask.
        layer: MaskLayer,
        /// On which frame.
        frame: FrameIndex,
        /// Its pixels.
        mask: Mask,
    },
    /// The mask of the template on its clean frame, made by the operator: one undo step.
    ChangeTemplateMask {
        /// Its pixels.
        mask: Mask,
    },
    /// Shows a frame.
    Seek(FrameIndex),
    /// Goes to a step.
    SetStep(Step),
    /// Opens a clip, a session, or a folder or manifest as the queue.
    Open(PathBuf),
    /// Asks the engine for something that changes no document.
    Ask(Request),
}
