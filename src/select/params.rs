//! Parameters of the proposals.

use serde::{Deserialize, Serialize};

/// Parameters of [`super::propose`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SelectParams {
    /// Longer side of the picture worked on, pixels. Default 320.
    pub work_size: u32,
    /// Frames looked at, spread over the clip. Default 32.
    pub samples: usize,
    /// Proposals handed back at most. Default 5.
    pub proposals: usize,
}

impl Default for SelectParams {
    fn default() -> Self {
        Self { work_size: 320, samples: 32, proposals: 5 }
    }
}
