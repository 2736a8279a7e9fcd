//! The frame of the window: what stands around canvas and inspector.

mod queue;
mod shell;
mod status_bar;
pub mod timeline;
mod top_bar;

pub use queue::QueuePanel;
pub use shell::Shell;
pub use status_bar::StatusBar;
pub use timeline::Timeline;
pub use top_bar::TopBar;
