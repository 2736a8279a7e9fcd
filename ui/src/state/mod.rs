//! What the window knows: mirrors of the engine's truth, and how the operator looks at it.

mod context;
mod findings;
mod options;
mod pictures;
mod queue;
mod step_state;
mod workspace;

pub use context::Context;
pub use findings::Findings;
pub use options::{BeforeAfter, LayerEye, LayerEyes, Options, PlaySpeed, Tool};
pub use pictures::Pictures;
pub use queue::Queue;
pub use step_state::StepState;
pub use workspace::{Draft, HandDraft, MaskOnFrame, Work, Workspace};
