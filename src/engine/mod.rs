//! The processing core as an interactive program sees it: requests go in, events come out, nothing blocks.
//!
//! The border is plain data: session types, artifacts, pictures. An operator's window (or, later, a browser)
//! holds a mirror of the session's history, sends every change here to be kept on disk, and asks for work and
//! pictures. What is behind the border is the very pipeline of the batch. This module builds without the
//! feature `engine`; the implementation in this process is `LocalEngine`.

mod event;
mod finding;
#[cfg(feature = "engine")]
mod local;
mod model_use;
mod picture;
mod request;

pub use event::{Access, Drafted, Event, Opened, QueueItem, SaveState, WorkFailure};
pub use finding::Finding;
#[cfg(feature = "engine")]
pub use local::{LocalEngine, Waker};
pub use model_use::ModelUse;
pub use picture::{Layers, OrbitCamera, PictureKind, PictureRequest, Shown};
pub use request::{Change, Request, Revision};

/// A processing core that works beside its caller.
pub trait Engine: Send {
    /// Takes a request; answers come as events. Never blocks.
    fn send(&self, request: Request);

    /// The next event, if there is one. Never blocks.
    fn poll(&self) -> Option<Event>;
}
