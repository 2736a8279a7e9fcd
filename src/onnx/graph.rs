//! A loaded graph whose tensors were found to be those of its contract.

use std::{borrow::Cow, collections::BTreeMap, path::Path};

use ort::session::{Session, SessionInputValue};

use super::{
    Declared, GraphSpec, OnnxError, Runtime, Sizes, Value,
    probe::{Binding, bind},
    value::declared,
};

/// A loaded graph.
pub struct Graph {
    name: &'static str,
    session: Session,
    binding: Binding,
}

impl std::fmt::Debug for Graph {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Graph")
            .field("name", &self.name)
            .field("binding", &self.binding)
            .finish_non_exhaustive()
    }
}

/// What a graph returned, by the contract's names.
#[derive(Debug)]
pub struct Outputs {
    graph: &'static str,
    values: BTreeMap<&'static str, Value>,
}

impl Outputs {
    /// Takes an output away.
    ///
    /// # Errors
    /// When the graph has no such output.
    pub fn take(&mut self, name: &'static str) -> Result<Value, OnnxError> {
        self.values
            .remove(name)
            .ok_or_else(|| OnnxError::Run { graph: self.graph, reason: format!("returned no `{name}`") })
    }

    /// The floats of an output.
    ///
    /// # Errors
    /// When the graph has no such output, or it holds something else.
    pub fn floats(&self, name: &'static str) -> Result<&[f32], OnnxError> {
        let missing = || OnnxError::Run { graph: self.graph, reason: format!("returned no `{name}`") };
        let value = self.values.get(name).ok_or_else(missing)?;
        value
            .as_floats()
            .map_err(|error| OnnxError::Run { graph: self.graph, reason: format!("`{name}`: {error}") })
    }

    /// The shape of an output; `None` where the graph has none of that name.
    pub fn shape(&self, name: &str) -> Option<Vec<usize>> {
        self.values.get(name).map(Value::shape)
    }
}

impl Graph {
    /// Loads a graph and finds the part of each of its tensors; `sizes` collects what a model's graphs agree on.
    ///
    /// # Errors
    /// When it does not load, or a tensor is not as the contract asks.
    pub fn open(
        runtime: &Runtime,
        path: &Path,
        spec: &GraphSpec,
        sizes: &mut Sizes,
    ) -> Result<Self, OnnxError> {
        let session = runtime.open(path)?;
        let inputs: Vec<Declared> = session.inputs().iter().map(declared).collect();
        let outputs: Vec<Declared> = session.outputs().iter().map(declared).collect();
        let binding = bind(spec, &inputs, &outputs, sizes)
            .map_err(|mismatch| OnnxError::Signature { path: path.to_owned(), mismatch })?;
        Ok(Self { name: spec.name, session, binding })
    }

    /// Whether the graph is fed an input that its contract lets it do without.
    pub fn takes(&self, name: &str) -> bool {
        self.binding.inputs.iter().any(|bound| bound.name == name)
    }

    /// Whether the graph returns an output that its contract lets it do without.
    pub fn gives(&self, name: &str) -> bool {
        self.binding.outputs.iter().any(|bound| bound.name == name)
    }

    /// The shape that the graph declares for an input of that part, -1 where symbolic.
    pub fn declared(&self, name: &str) -> Option<&[i64]> {
        let bound = self.binding.inputs.iter().find(|bound| bound.name == name);
        bound.map(|bound| bound.declared.shape.as_slice())
    }

    /// Runs the graph on `inputs`, by the contract's names; what it does without is left out.
    ///
    /// # Errors
    /// When an input is missing or of another shape than the graph takes, or the graph fails.
    pub fn run(&mut self, inputs: &[(&'static str, &Value)]) -> Result<Outputs, OnnxError> {
        let graph = self.name;
        let failed = |reason: String| OnnxError::Run { graph, reason };
        let mut converted = Vec::new();
        for bound in &self.binding.inputs {
            let (_, value) = inputs
                .iter()
                .find(|(name, _)| *name == bound.name)
                .ok_or_else(|| failed(format!("is not fed `{}`", bound.name)))?;
            let made =
                value.as_declared(bound).map_err(|error| failed(format!("`{}`: {error}", bound.name)))?;
            converted.push((bound, *value, made));
        }
        let fed: Vec<(Cow<'_, str>, SessionInputValue<'_>)> = converted
            .iter()
            .map(|(bound, value, made)| {
                let value = made.as_ref().unwrap_or(value);
                (Cow::Borrowed(bound.declared.name.as_str()), SessionInputValue::from(&value.0))
            })
            .collect();
        let mut returned = self.session.run(fed).map_err(|error| failed(error.to_string()))?;
        let mut values = BTreeMap::new();
        for bound in &self.binding.outputs {
            if let Some(value) = returned.remove(&bound.declared.name) {
                values.insert(bound.name, Value(value));
            }
        }
        Ok(Outputs { graph, values })
    }
}
