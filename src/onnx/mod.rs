//! Learned models through ONNX Runtime: their folders, descriptions, checks and runs.
//!
//! A model is a folder with a `model.toml` ([`ModelDescription`]) and one ONNX file a graph. Its description names
//! a contract: a list of [`GraphSpec`]s that say which tensors go in and out. [`ModelFolder::checked`] looks at the
//! files without running anything (all inside the folder, unaltered, trusted), [`Graph::open`] then loads each and
//! compares what it declares with what the contract asks.

mod contract;
mod description;
mod error;
mod graph;
mod model;
mod probe;
mod references;
mod registry;
mod runtime;
mod signature;
mod value;

pub use contract::Contract;
pub use description::{ChannelOrder, Layout, ModelDescription, Normalisation, PictureDescription};
pub use error::OnnxError;
pub use graph::{Graph, Outputs};
pub use model::{CheckedModel, ModelFolder, Trust};
pub use probe::{Binding, Bound, Declared, Mismatch, Sizes, bind};
pub use registry::{ListedModel, Registry, hash_file};
pub use runtime::{Provider, Runtime, RuntimeOptions};
pub use signature::{Dim, ElementType, GraphSpec, TensorSpec};
pub use value::Value;
