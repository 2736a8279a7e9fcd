//! Why a robot description is refused.

/// Why a robot model could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RobotError {
    /// MuJoCo does not compile the description.
    #[error("MuJoCo refuses the robot description: {0}")]
    Compile(String),
    /// A file the description needs could not be handed to MuJoCo.
    #[error("asset `{name}` of the robot description: {reason}")]
    Asset {
        /// File name as the description spells it.
        name: String,
        /// What MuJoCo says.
        reason: String,
    },
    /// A joint, body or site that retargeting needs is missing.
    #[error("the robot description has no {kind} `{name}`; expected a Unitree G1 with BrainCo hands")]
    Missing {
        /// `joint`, `body` or `site`.
        kind: &'static str,
        /// Its name.
        name: String,
    },
    /// A joint between the torso and a fingertip is of a kind that has no angle.
    #[error(
        "joint `{0}` is not a hinge; only hinge joints between torso_link and the fingertips are supported"
    )]
    NotHinge(String),
    /// A limit is not usable.
    #[error("joint `{joint}`: limits {lower}..{upper} rad are not an interval of finite numbers")]
    Limits {
        /// Joint name.
        joint: String,
        /// Lower limit in radians.
        lower: f64,
        /// Upper limit in radians.
        upper: f64,
    },
    /// The body is not below `torso_link`.
    #[error("body `{0}` does not hang below torso_link")]
    Detached(String),
    /// The two embedded files do not fit together.
    #[error("embedded robot model: {0}")]
    Embedded(String),
}
