//! What a contract asks of a graph: names, element types and shapes of its tensors.

use std::fmt;

/// Types of tensor elements that contracts use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementType {
    /// 32-bit float.
    F32,
    /// 32-bit integer.
    I32,
    /// 64-bit integer.
    I64,
    /// Boolean.
    Bool,
}

impl fmt::Display for ElementType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::I32 => "i32",
            Self::I64 => "i64",
            Self::Bool => "bool",
        })
    }
}

/// One dimension of a tensor. A graph may leave any of them symbolic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dim {
    /// That size.
    Exactly(i64),
    /// Any size, called so in messages; need not be the same elsewhere.
    Any(&'static str),
    /// The quantity of that name, the same throughout a model.
    Of(&'static str),
    /// That quantity divided, for example a side of the picture by the stride of a feature map.
    Part(&'static str, i64),
    /// The square of such a part: tokens of a square feature map.
    Tokens(&'static str, i64),
}

impl fmt::Display for Dim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exactly(size) => write!(f, "{size}"),
            Self::Any(name) | Self::Of(name) => f.write_str(name),
            Self::Part(name, part) => write!(f, "{name}/{part}"),
            Self::Tokens(name, part) => write!(f, "({name}/{part})²"),
        }
    }
}

/// One tensor of a contract.
#[derive(Clone, Copy, Debug)]
pub struct TensorSpec {
    /// Its name in the contract.
    pub name: &'static str,
    /// Names that other exporters give it.
    pub aliases: &'static [&'static str],
    /// Accepted element types; the first is the contract's own.
    pub types: &'static [ElementType],
    /// Accepted shapes; the first is the contract's own.
    pub shapes: &'static [&'static [Dim]],
    /// Whether a graph may do without it.
    pub optional: bool,
}

impl TensorSpec {
    /// A float tensor of one shape under one name.
    pub const fn floats(name: &'static str, shapes: &'static [&'static [Dim]]) -> Self {
        Self { name, aliases: &[], types: &[ElementType::F32], shapes, optional: false }
    }

    /// As [`Self::floats`] of other element types.
    pub const fn of(
        name: &'static str,
        types: &'static [ElementType],
        shapes: &'static [&'static [Dim]],
    ) -> Self {
        Self { name, aliases: &[], types, shapes, optional: false }
    }

    /// Also known under these names.
    pub const fn or_named(self, aliases: &'static [&'static str]) -> Self {
        Self { aliases, ..self }
    }

    /// A graph may do without it.
    pub const fn if_there(self) -> Self {
        Self { optional: true, ..self }
    }

    /// Whether a graph's tensor of that name is this one.
    pub fn is_named(&self, name: &str) -> bool {
        self.name == name || self.aliases.contains(&name)
    }
}

impl fmt::Display for TensorSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}`", self.name)?;
        for (at, kind) in self.types.iter().enumerate() {
            write!(f, "{}{kind}", if at == 0 { " " } else { " or " })?;
        }
        for (at, shape) in self.shapes.iter().enumerate() {
            let dims: Vec<String> = shape.iter().map(Dim::to_string).collect();
            write!(f, "{}[{}]", if at == 0 { " " } else { " or " }, dims.join(", "))?;
        }
        Ok(())
    }
}

/// One graph of a contract.
#[derive(Clone, Copy, Debug)]
pub struct GraphSpec {
    /// Its name: the key in `model.toml`, and the file's name without `.onnx` where that is silent.
    pub name: &'static str,
    /// What it is fed.
    pub inputs: &'static [TensorSpec],
    /// What is read of it; other outputs are ignored.
    pub outputs: &'static [TensorSpec],
    /// Whether a model may do without it.
    pub optional: bool,
}
