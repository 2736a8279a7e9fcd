//! What lies before the object on a frame.

use serde::{Deserialize, Serialize};

use crate::geometry::PerSide;

/// What lies before the object on one frame, 0 to 1; between while a change fades.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerDecision {
    /// The whole hand and arm.
    pub in_front: PerSide<f32>,
    /// The near parts alone (the thumb), where the rest is behind.
    pub near: PerSide<f32>,
}
