//! AgenticFocus turns first-person video of human hands into robot demonstrations.
//!
//! Stages are pure functions in one direction:
//! `clip → select → segment → template → inpaint → hands → retarget → render → composite → export`.
//! Without the feature `engine` only the session document and the plain types remain; those
//! also build for `wasm32-unknown-unknown`. See `ARCHITECTURE.md`.

pub mod clip;
pub mod composite;
pub mod engine;
pub mod geometry;
pub mod hands;
pub mod image;
pub mod inpaint;
pub mod landmarks;
pub mod progress;
pub mod retarget;
pub mod robot;
pub mod segment;
pub mod session;
pub mod template;

#[cfg(feature = "engine")]
pub mod cli;
#[cfg(feature = "engine")]
pub mod evaluate;
#[cfg(feature = "engine")]
pub mod export;
#[cfg(feature = "engine")]
pub mod mujoco;
#[cfg(feature = "engine")]
pub mod onnx;
#[cfg(feature = "engine")]
pub mod pipeline;
#[cfg(feature = "engine")]
pub mod render;
#[cfg(feature = "engine")]
pub mod select;
#[cfg(feature = "engine")]
mod smoothing;
#[cfg(feature = "engine")]
pub mod synth;
#[cfg(feature = "engine")]
pub mod vision;
