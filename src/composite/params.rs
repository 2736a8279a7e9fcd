//! What can be tuned.

use serde::{Deserialize, Serialize};

/// Parameters of the layer stack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CompositeParams {
    /// Width of the fade between the object's own pixels and the template beside a hand, as a share
    /// of the picture's width (default: 0.005).
    pub feather: f64,
    /// Placements below this confidence are not drawn (default: 0.05).
    pub least_confidence: f64,
    /// Largest colour correction of the template, levels (default: 50).
    pub colour_limit: f32,
}

impl Default for CompositeParams {
    fn default() -> Self {
        Self { feather: 0.005, least_confidence: 0.05, colour_limit: 50.0 }
    }
}
