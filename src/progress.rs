//! How long work reports progress and learns that it is no longer wanted.

/// Watches one stage at work. Stages call it about once a frame.
pub trait Watch: Sync {
    /// `done` of `total` steps are finished.
    fn advance(&self, done: usize, total: usize);

    /// Whether the work should stop at the next frame.
    fn is_cancelled(&self) -> bool;

    /// # Errors
    /// [`Cancelled`] when the work should stop.
    fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// The work was cancelled; nothing half-made is left behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Nobody watches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn advance(&self, _done: usize, _total: usize) {}

    fn is_cancelled(&self) -> bool {
        false
    }
}
