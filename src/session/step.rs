//! The steps in which a person goes through a clip.

use serde::{Deserialize, Serialize};

/// A step of curation, in the method's order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Step {
    /// Which object (default).
    #[default]
    Object,
    /// Object and arm masks.
    Masks,
    /// The object whole, and where it goes.
    Template,
    /// Both hands.
    Hands,
    /// The robot's motion.
    Retarget,
    /// The finished picture.
    Composite,
    /// Accept, reject, flag.
    Review,
}

impl Step {
    /// All steps in order.
    pub const ALL: [Self; 7] = [
        Self::Object,
        Self::Masks,
        Self::Template,
        Self::Hands,
        Self::Retarget,
        Self::Composite,
        Self::Review,
    ];
}
