//! Every frame read once for all who need its pixels.

use std::sync::{
    Arc,
    mpsc::{Receiver, SyncSender},
};

use super::{export::Parts, frame::FramePixels};
use crate::{
    clip::{FrameIndex, FrameSource as _},
    pipeline::{ClipFailure, ExitCode},
    progress::Watch,
};

/// Frames that may wait for each reader: enough to overlap, few enough to bound memory.
pub(super) const READ_AHEAD: usize = 2;

/// Reads every frame in order and hands it to everyone who still listens.
pub(super) fn read_all(
    parts: &Parts<'_>,
    listeners: [SyncSender<Arc<FramePixels>>; 2],
    watch: &dyn Watch,
) -> Result<(), ClipFailure> {
    let failed =
        |error: &(dyn std::error::Error + 'static)| ClipFailure::from_error(error, ExitCode::InputOutput);
    for index in FrameIndex::all(parts.clip.frame_count()) {
        watch.check().map_err(|error| ClipFailure::from_error(&error, ExitCode::Internal))?;
        let source = parts.clip.frame(index).map_err(|error| failed(&error))?;
        let background = parts.background.frames.frame(index).map_err(|error| failed(&error))?;
        let frame = Arc::new(FramePixels { source, background });
        // Who stopped listening says why; the other goes on, so that its own end is no consequence of that.
        if listeners.iter().filter(|listener| listener.send(Arc::clone(&frame)).is_ok()).count() == 0 {
            return Ok(());
        }
    }
    Ok(())
}

/// The next frame of [`read_all`].
pub(super) fn next_frame(frames: &Receiver<Arc<FramePixels>>) -> Result<Arc<FramePixels>, ClipFailure> {
    frames.recv().map_err(|_| {
        let message = "the frames ended early".to_owned();
        ClipFailure { stage: None, exit: ExitCode::Internal, message }
    })
}
