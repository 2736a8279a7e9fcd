//! Why a robot description is refused.

use std::path::PathBuf;

/// Why a description could not be checked or imported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// A file or folder could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Larger than any real description.
    #[error("{what} is {found}, expected at most {limit}")]
    TooLarge {
        /// What is too large, by name.
        what: String,
        /// Its size, with unit.
        found: String,
        /// The limit, with unit.
        limit: String,
    },
    /// Elements nested deeper than any real description.
    #[error("line {line}: elements are nested {depth} deep, expected at most {limit}")]
    TooDeep {
        /// Line of the first element that is too deep, from 1.
        line: usize,
        /// Its depth.
        depth: usize,
        /// The limit.
        limit: usize,
    },
    /// A document type declaration, which can define entities that explode or read other files.
    #[error("line {line}: the description has a DOCTYPE; remove it, URDF has no use for one")]
    DocumentType {
        /// Its line, from 1.
        line: usize,
    },
    /// No well-formed XML.
    #[error("line {line}: no well-formed XML: {reason}")]
    Malformed {
        /// Line, from 1.
        line: usize,
        /// What the parser says.
        reason: String,
    },
    /// Well-formed, but no URDF.
    #[error("no URDF: {0}")]
    NotUrdf(String),
    /// Two links or two joints of one name.
    #[error("two {kind}s are called `{name}`; names must be unique")]
    Duplicate {
        /// `link` or `joint`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A joint between links of which one does not exist.
    #[error("joint `{joint}` refers to link `{link}`, which the description does not have")]
    UnknownLink {
        /// The joint.
        joint: String,
        /// The missing link.
        link: String,
    },
    /// A link with two parents.
    #[error(
        "link `{link}` is the child of joint `{first}` and of joint `{second}`; the links must form a tree"
    )]
    TwoParents {
        /// The link.
        link: String,
        /// The one joint.
        first: String,
        /// The other joint.
        second: String,
    },
    /// A loop of joints.
    #[error("joint `{joint}` closes a loop through link `{link}`; the links must form a tree")]
    Cycle {
        /// A joint of the loop.
        joint: String,
        /// Its child.
        link: String,
    },
    /// Not exactly one link without a parent.
    #[error("links {found:?} have no parent; expected exactly one root")]
    Roots {
        /// The links without a parent.
        found: Vec<String>,
    },
    /// A number that is none.
    #[error("{of}: {what} is {value}; expected a finite number")]
    NotFinite {
        /// The link or joint, by name.
        of: String,
        /// What holds the number.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// Limits the wrong way round.
    #[error("joint `{joint}`: lower limit {lower} is above the upper limit {upper}")]
    Limits {
        /// The joint.
        joint: String,
        /// Lower limit, radians or metres.
        lower: f64,
        /// Upper limit, radians or metres.
        upper: f64,
    },
    /// An axis without a direction.
    #[error("joint `{joint}`: the axis is zero")]
    Axis {
        /// The joint.
        joint: String,
    },
    /// A joint that is neither fixed nor moves along or about one axis.
    #[error("joint `{joint}` is {kind}; expected fixed, revolute, continuous or prismatic")]
    JointKind {
        /// The joint.
        joint: String,
        /// Its kind.
        kind: String,
    },
    /// A joint that follows one that does not exist, or itself.
    #[error("joint `{joint}` follows joint `{target}`, which does not move on its own in this description")]
    Mimic {
        /// The joint.
        joint: String,
        /// The joint it names.
        target: String,
    },
    /// A mesh file that is not there.
    #[error("link `{link}`: mesh `{file}` does not exist in the folder of the description")]
    MissingMesh {
        /// The link.
        link: String,
        /// The file name as written.
        file: String,
    },
    /// A mesh outside the description's folder.
    #[error(
        "link `{link}`: mesh `{file}` lies outside the folder of the description, or is no relative path"
    )]
    MeshOutside {
        /// The link.
        link: String,
        /// The file name as written.
        file: String,
    },
    /// A mesh that cannot be used.
    #[error("link `{link}`: mesh `{file}`: {reason}")]
    Mesh {
        /// The link.
        link: String,
        /// The file name as written.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// MuJoCo refuses the model, or it is no G1 with BrainCo hands.
    #[error(transparent)]
    Robot(#[from] crate::robot::RobotError),
}
