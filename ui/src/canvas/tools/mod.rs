//! What the pointer does on the canvas, step by step.

pub(super) mod composite;
pub(super) mod hands;
mod held;
mod hole;
pub(super) mod masks;
pub(super) mod object;
mod placement;
pub(super) mod points;
mod shape;
pub(super) mod template;
pub(super) mod template_mask;
pub(super) mod wrists;
