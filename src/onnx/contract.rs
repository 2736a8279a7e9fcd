//! What a model promises to be.

use super::GraphSpec;

/// A list of graphs with their tensors, under a name that `model.toml` refers to.
#[derive(Clone, Copy, Debug)]
pub struct Contract {
    /// Its name and version, for example `sam2-video/1`.
    pub id: &'static str,
    /// Its graphs.
    pub graphs: &'static [GraphSpec],
}
