//! The operator's desktop application: panels over a session's history and an engine handle.

pub mod action;
pub mod app;
pub mod canvas;
pub mod inspector;
pub mod key_sheet;
#[cfg(feature = "engine")]
pub mod measure;
pub mod paint;
pub mod palette;
pub mod panels;
#[cfg(feature = "engine")]
pub mod renderer;
pub mod state;
pub mod theme;
#[cfg(feature = "engine")]
pub mod tour;
pub mod ui_command;
pub mod widgets;
