//! What learned models are used for.

/// What a learned model may be used for, where one is active.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ModelUse {
    /// Following the object through the clip.
    ObjectMasks,
    /// The mask of what a person or a proposal points at.
    PointMasks,
    /// The background without the human.
    Background,
    /// Background that no frame shows.
    UnseenBackground,
    /// Hands and their poses.
    Hands,
}

impl ModelUse {
    /// What is done where no model can be used, as the log says it.
    pub const fn instead(self) -> &'static str {
        match self {
            Self::ObjectMasks => "object masks without a network",
            Self::PointMasks => "the prompt's mask without a network",
            Self::Background => "background from plates",
            Self::UnseenBackground => "unseen background filled smoothly",
            Self::Hands => "hands from the estimator",
        }
    }
}
