//! What can go wrong while rendering.

use crate::geometry::Size;

/// Why a picture could not be rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No EGL device gave an OpenGL context.
    #[error(
        "no off-screen OpenGL context ({tried}): expected an EGL device; install libegl1 and libgl1-mesa-dri \
         for software rendering"
    )]
    NoContext {
        /// What was tried and what came of it.
        tried: String,
    },
    /// The context could not be made current on this thread.
    #[error(
        "the OpenGL context cannot be used on this thread: {0}; a renderer stays on the thread that made it"
    )]
    NotCurrent(String),
    /// A picture size that no buffer can hold.
    #[error("picture size {0}: expected 1 to {max} pixels a side", max = super::offscreen::MAX_SIDE)]
    Size(Size),
    /// The model given is not the one the renderer was made for.
    #[error("the renderer was made for another model; make a new renderer")]
    OtherModel,
    /// The clipping planes are not `0 < near < far`.
    #[error("clipping planes near = {near} m, far = {far} m: expected 0 < near < far")]
    Clipping {
        /// Near plane, metres.
        near: f64,
        /// Far plane, metres.
        far: f64,
    },
    /// The robot has no torso to hang the camera on.
    #[error("the robot model has no body torso_link: expected a Unitree G1")]
    NoTorso,
    /// MuJoCo could not allocate its state.
    #[error("MuJoCo: {0}")]
    MuJoCo(String),
    /// The camera's pose or intrinsics, or joint angles, are not finite, or the rotation is none.
    #[error("camera or joint angles: expected finite numbers and, in R_cam, a rotation")]
    NotFinite,
}
