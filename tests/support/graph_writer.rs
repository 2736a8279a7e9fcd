//! Writes small ONNX graphs, so that tests need neither Python nor committed models.
//!
//! Messages and field numbers of `onnx.proto3` (ONNX 1.16), as far as the operators used here go.
#![allow(dead_code, reason = "each test file uses its own part")]

use prost::Message;

#[derive(Clone, PartialEq, Message)]
struct Model {
    #[prost(int64, tag = "1")]
    ir_version: i64,
    #[prost(message, optional, tag = "7")]
    graph: Option<GraphProto>,
    #[prost(message, repeated, tag = "8")]
    opset: Vec<Opset>,
}

#[derive(Clone, PartialEq, Message)]
struct Opset {
    #[prost(string, tag = "1")]
    domain: String,
    #[prost(int64, tag = "2")]
    version: i64,
}

#[derive(Clone, PartialEq, Message)]
struct GraphProto {
    #[prost(message, repeated, tag = "1")]
    nodes: Vec<Node>,
    #[prost(string, tag = "2")]
    name: String,
    #[prost(message, repeated, tag = "5")]
    initializers: Vec<Tensor>,
    #[prost(message, repeated, tag = "11")]
    inputs: Vec<Outlet>,
    #[prost(message, repeated, tag = "12")]
    outputs: Vec<Outlet>,
}

#[derive(Clone, PartialEq, Message)]
struct Node {
    #[prost(string, repeated, tag = "1")]
    inputs: Vec<String>,
    #[prost(string, repeated, tag = "2")]
    outputs: Vec<String>,
    #[prost(string, tag = "4")]
    operator: String,
    #[prost(message, repeated, tag = "5")]
    attributes: Vec<Attribute>,
}

#[derive(Clone, PartialEq, Message)]
struct Attribute {
    #[prost(string, tag = "1")]
    name: String,
    #[prost(float, tag = "2")]
    float: f32,
    #[prost(int64, tag = "3")]
    integer: i64,
    #[prost(bytes = "vec", tag = "4")]
    text: Vec<u8>,
    #[prost(int64, repeated, tag = "8")]
    integers: Vec<i64>,
    #[prost(int32, tag = "20")]
    kind: i32,
}

#[derive(Clone, PartialEq, Message)]
struct Tensor {
    #[prost(int64, repeated, tag = "1")]
    dims: Vec<i64>,
    #[prost(int32, tag = "2")]
    element: i32,
    #[prost(float, repeated, tag = "4")]
    floats: Vec<f32>,
    #[prost(int64, repeated, tag = "7")]
    integers: Vec<i64>,
    #[prost(string, tag = "8")]
    name: String,
    #[prost(message, repeated, tag = "13")]
    external: Vec<Entry>,
    #[prost(int32, tag = "14")]
    location: i32,
}

#[derive(Clone, PartialEq, Message)]
struct Entry {
    #[prost(string, tag = "1")]
    key: String,
    #[prost(string, tag = "2")]
    value: String,
}

#[derive(Clone, PartialEq, Message)]
struct Outlet {
    #[prost(string, tag = "1")]
    name: String,
    #[prost(message, optional, tag = "2")]
    kind: Option<Kind>,
}

#[derive(Clone, PartialEq, Message)]
struct Kind {
    #[prost(message, optional, tag = "1")]
    tensor: Option<TensorKind>,
}

#[derive(Clone, PartialEq, Message)]
struct TensorKind {
    #[prost(int32, tag = "1")]
    element: i32,
    #[prost(message, optional, tag = "2")]
    shape: Option<Shape>,
}

#[derive(Clone, PartialEq, Message)]
struct Shape {
    #[prost(message, repeated, tag = "1")]
    dims: Vec<Dimension>,
}

#[derive(Clone, PartialEq, Message)]
struct Dimension {
    #[prost(int64, optional, tag = "1")]
    size: Option<i64>,
    #[prost(string, optional, tag = "2")]
    symbol: Option<String>,
}

/// Element types by their numbers in `TensorProto.DataType`.
#[derive(Clone, Copy, Debug)]
pub enum Element {
    F32 = 1,
    I32 = 6,
    I64 = 7,
    Bool = 9,
}

/// An attribute of a node.
#[derive(Clone, Debug)]
pub enum Value<'a> {
    Float(f32),
    Integer(i64),
    Integers(&'a [i64]),
    Text(&'a str),
}

/// A graph being written. Sizes below zero are symbolic.
#[derive(Clone, Default, Debug)]
pub struct GraphWriter {
    graph: GraphProto,
}

impl GraphWriter {
    pub fn new() -> Self {
        Self { graph: GraphProto { name: "tiny".to_owned(), ..GraphProto::default() } }
    }

    pub fn input(mut self, name: &str, element: Element, dims: &[i64]) -> Self {
        self.graph.inputs.push(outlet(name, element, dims));
        self
    }

    pub fn output(mut self, name: &str, element: Element, dims: &[i64]) -> Self {
        self.graph.outputs.push(outlet(name, element, dims));
        self
    }

    pub fn floats(mut self, name: &str, dims: &[i64], floats: &[f32]) -> Self {
        let tensor = Tensor { dims: dims.to_vec(), element: 1, floats: floats.to_vec(), ..named(name) };
        self.graph.initializers.push(tensor);
        self
    }

    pub fn integers(mut self, name: &str, dims: &[i64], integers: &[i64]) -> Self {
        let tensor = Tensor { dims: dims.to_vec(), element: 7, integers: integers.to_vec(), ..named(name) };
        self.graph.initializers.push(tensor);
        self
    }

    /// A float constant whose numbers lie in another file.
    pub fn external(mut self, name: &str, dims: &[i64], file: &str) -> Self {
        let external = vec![Entry { key: "location".to_owned(), value: file.to_owned() }];
        let tensor = Tensor { dims: dims.to_vec(), element: 1, external, location: 1, ..named(name) };
        self.graph.initializers.push(tensor);
        self
    }

    pub fn node(
        self,
        operator: &str,
        inputs: &[&str],
        output: &str,
        attributes: &[(&str, Value<'_>)],
    ) -> Self {
        self.node_of(operator, inputs, &[output], attributes)
    }

    pub fn node_of(
        mut self,
        operator: &str,
        inputs: &[&str],
        outputs: &[&str],
        attributes: &[(&str, Value<'_>)],
    ) -> Self {
        let strings = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        self.graph.nodes.push(Node {
            inputs: strings(inputs),
            outputs: strings(outputs),
            operator: operator.to_owned(),
            attributes: attributes.iter().map(|(name, value)| attribute(name, value)).collect(),
        });
        self
    }

    /// The file's bytes, operators of set 17.
    pub fn bytes(&self) -> Vec<u8> {
        self.bytes_of_set(17)
    }

    pub fn bytes_of_set(&self, version: i64) -> Vec<u8> {
        let opset = vec![Opset { domain: String::new(), version }];
        Model { ir_version: 8, graph: Some(self.graph.clone()), opset }.encode_to_vec()
    }
}

fn named(name: &str) -> Tensor {
    Tensor { name: name.to_owned(), ..Tensor::default() }
}

fn outlet(name: &str, element: Element, dims: &[i64]) -> Outlet {
    let dimension = |(at, size): (usize, &i64)| match size {
        0.. => Dimension { size: Some(*size), symbol: None },
        _ => Dimension { size: None, symbol: Some(format!("{name}_{at}")) },
    };
    let shape = Some(Shape { dims: dims.iter().enumerate().map(dimension).collect() });
    let tensor = Some(TensorKind { element: element as i32, shape });
    Outlet { name: name.to_owned(), kind: Some(Kind { tensor }) }
}

fn attribute(name: &str, value: &Value<'_>) -> Attribute {
    let base = Attribute { name: name.to_owned(), ..Attribute::default() };
    match value {
        Value::Float(float) => Attribute { float: *float, kind: 1, ..base },
        Value::Integer(integer) => Attribute { integer: *integer, kind: 2, ..base },
        Value::Text(text) => Attribute { text: text.as_bytes().to_vec(), kind: 3, ..base },
        Value::Integers(integers) => Attribute { integers: integers.to_vec(), kind: 7, ..base },
    }
}
