//! Files that an ONNX graph refers to: its external weights.
//!
//! Only the fields that can name a file are decoded (field numbers of `onnx.proto3`, ONNX 1.16); prost skips the rest.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use prost::Message;

use super::{OnnxError, description::inside};

/// The largest file that protocol buffers, and so an ONNX graph, can be.
const LARGEST: u64 = 2 << 30;

#[derive(Clone, PartialEq, Message)]
struct Model {
    #[prost(message, optional, tag = "7")]
    graph: Option<Graph>,
    #[prost(message, repeated, tag = "20")]
    training: Vec<Training>,
    #[prost(message, repeated, tag = "25")]
    functions: Vec<Function>,
}

#[derive(Clone, PartialEq, Message)]
struct Training {
    #[prost(message, optional, tag = "1")]
    initialization: Option<Graph>,
    #[prost(message, optional, tag = "2")]
    algorithm: Option<Graph>,
}

#[derive(Clone, PartialEq, Message)]
struct Function {
    #[prost(message, repeated, tag = "7")]
    nodes: Vec<Node>,
    #[prost(message, repeated, tag = "11")]
    defaults: Vec<Attribute>,
}

#[derive(Clone, PartialEq, Message)]
struct Graph {
    #[prost(message, repeated, tag = "1")]
    nodes: Vec<Node>,
    #[prost(message, repeated, tag = "5")]
    initializers: Vec<Tensor>,
    #[prost(message, repeated, tag = "15")]
    sparse_initializers: Vec<SparseTensor>,
}

#[derive(Clone, PartialEq, Message)]
struct Node {
    #[prost(string, tag = "4")]
    operator: String,
    #[prost(message, repeated, tag = "5")]
    attributes: Vec<Attribute>,
}

#[derive(Clone, PartialEq, Message)]
struct Attribute {
    #[prost(message, optional, tag = "5")]
    tensor: Option<Tensor>,
    #[prost(message, optional, tag = "6")]
    graph: Option<Graph>,
    #[prost(message, repeated, tag = "10")]
    tensors: Vec<Tensor>,
    #[prost(message, repeated, tag = "11")]
    graphs: Vec<Graph>,
    #[prost(message, optional, tag = "22")]
    sparse_tensor: Option<SparseTensor>,
    #[prost(message, repeated, tag = "23")]
    sparse_tensors: Vec<SparseTensor>,
}

#[derive(Clone, PartialEq, Message)]
struct SparseTensor {
    #[prost(message, optional, tag = "1")]
    values: Option<Tensor>,
    #[prost(message, optional, tag = "2")]
    indices: Option<Tensor>,
}

#[derive(Clone, PartialEq, Message)]
struct Tensor {
    #[prost(message, repeated, tag = "13")]
    external: Vec<Entry>,
}

#[derive(Clone, PartialEq, Message)]
struct Entry {
    #[prost(string, tag = "1")]
    key: String,
    #[prost(string, tag = "2")]
    value: String,
}

/// Operators whose attributes name files of a vendor's own.
const FILE_OPERATORS: [&str; 1] = ["EPContext"];

/// What was collected from a graph.
#[derive(Default)]
struct References {
    locations: BTreeSet<String>,
    forbidden: Option<String>,
}

impl References {
    fn graph(&mut self, graph: &Graph) {
        graph.nodes.iter().for_each(|node| self.node(node));
        graph.initializers.iter().for_each(|tensor| self.tensor(tensor));
        graph.sparse_initializers.iter().for_each(|tensor| self.sparse(tensor));
    }

    fn node(&mut self, node: &Node) {
        if FILE_OPERATORS.contains(&node.operator.as_str()) {
            self.forbidden = Some(node.operator.clone());
        }
        node.attributes.iter().for_each(|attribute| self.attribute(attribute));
    }

    fn attribute(&mut self, attribute: &Attribute) {
        attribute.tensor.iter().chain(&attribute.tensors).for_each(|tensor| self.tensor(tensor));
        attribute.graph.iter().chain(&attribute.graphs).for_each(|graph| self.graph(graph));
        let sparse = attribute.sparse_tensor.iter().chain(&attribute.sparse_tensors);
        sparse.for_each(|tensor| self.sparse(tensor));
    }

    fn sparse(&mut self, tensor: &SparseTensor) {
        tensor.values.iter().chain(&tensor.indices).for_each(|tensor| self.tensor(tensor));
    }

    fn tensor(&mut self, tensor: &Tensor) {
        let locations = tensor.external.iter().filter(|entry| entry.key == "location");
        self.locations.extend(locations.map(|entry| entry.value.clone()));
    }
}

/// The files that the graph at `path` keeps its weights in: all inside its own folder.
///
/// # Errors
/// When the file cannot be read, is too large or no ONNX graph, names a file outside its folder, or has operators
/// that read files of their own.
pub(super) fn external_files(path: &Path) -> Result<Vec<PathBuf>, OnnxError> {
    let unreadable =
        |error: std::io::Error| OnnxError::Unreadable { path: path.to_owned(), reason: error.to_string() };
    let broken = |reason: String| OnnxError::NotAGraph { path: path.to_owned(), reason };
    let bytes = fs::metadata(path).map_err(unreadable)?.len();
    if bytes >= LARGEST {
        return Err(OnnxError::TooLarge { path: path.to_owned(), bytes });
    }
    let content = fs::read(path).map_err(unreadable)?;
    let model = Model::decode(content.as_slice()).map_err(|error| broken(error.to_string()))?;
    drop(content);
    let Some(graph) = &model.graph else { return Err(broken("it holds no graph".to_owned())) };
    let mut found = References::default();
    found.graph(graph);
    for training in &model.training {
        training.initialization.iter().chain(&training.algorithm).for_each(|graph| found.graph(graph));
    }
    for function in &model.functions {
        function.nodes.iter().for_each(|node| found.node(node));
        function.defaults.iter().for_each(|attribute| found.attribute(attribute));
    }
    if let Some(operator) = found.forbidden {
        return Err(broken(format!("the operator {operator} reads files of its own")));
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    found.locations.iter().map(|name| inside(folder, path, name)).collect()
}
