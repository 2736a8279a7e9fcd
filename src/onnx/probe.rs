//! Compares what a graph declares with what its contract asks for.

use std::{collections::BTreeMap, fmt};

use super::signature::{Dim, ElementType, GraphSpec, TensorSpec};

/// A tensor as a graph declares it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Declared {
    /// Its name.
    pub name: String,
    /// Its element type; `Err` carries the name of one that no contract uses.
    pub element: Result<ElementType, String>,
    /// Its shape; -1 where symbolic.
    pub shape: Vec<i64>,
}

impl fmt::Display for Declared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let dims: Vec<String> =
            self.shape.iter().map(|dim| if *dim < 0 { "?".to_owned() } else { dim.to_string() }).collect();
        match &self.element {
            Ok(element) => write!(f, "`{}` {element} [{}]", self.name, dims.join(", ")),
            Err(other) => write!(f, "`{}` {other} [{}]", self.name, dims.join(", ")),
        }
    }
}

/// A tensor that is not as its contract asks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Mismatch {
    /// The graph has no such tensor.
    #[error("has no {kind} {expected}; it has {found}")]
    Missing {
        /// `input` or `output`.
        kind: &'static str,
        /// The contract's tensor.
        expected: String,
        /// Names of those that are there.
        found: String,
    },
    /// Another element type.
    #[error("{kind} {expected} expected, found {found}: another element type")]
    Type {
        /// `input` or `output`.
        kind: &'static str,
        /// The contract's tensor.
        expected: String,
        /// The graph's.
        found: String,
    },
    /// Another shape, or one that contradicts another tensor.
    #[error("{kind} {expected} expected, found {found}: another shape{known}")]
    Shape {
        /// `input` or `output`.
        kind: &'static str,
        /// The contract's tensor.
        expected: String,
        /// The graph's.
        found: String,
        /// What other tensors settled, for example ` (S = 512)`.
        known: String,
    },
    /// The graph wants something that the contract does not give.
    #[error("wants the input {found}, which {graph} of this contract is not given")]
    Unexpected {
        /// The graph's name in the contract.
        graph: &'static str,
        /// The graph's tensor.
        found: String,
    },
    /// A size that no tensor declares and `model.toml` does not say.
    #[error("leaves the size {symbol} open in every tensor; say it in model.toml under [sizes]")]
    Open {
        /// The contract's name of it.
        symbol: &'static str,
    },
}

/// Sizes that a model's tensors have in common, by their names in the contract.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sizes(BTreeMap<&'static str, i64>);

impl Sizes {
    /// The size called so.
    ///
    /// # Errors
    /// When neither a tensor nor the model's description says it.
    pub fn get(&self, symbol: &'static str) -> Result<usize, Mismatch> {
        let size = self.0.get(symbol).and_then(|size| usize::try_from(*size).ok());
        size.ok_or(Mismatch::Open { symbol })
    }

    /// Takes a size as given, where no tensor has settled it.
    pub fn suppose(&mut self, symbol: &'static str, size: usize) {
        self.0.entry(symbol).or_insert(size as i64);
    }

    /// Settles `symbol`; `false` where it is settled otherwise.
    fn settle(&mut self, symbol: &'static str, size: Option<i64>) -> bool {
        match size {
            Some(size) if size > 0 => *self.0.entry(symbol).or_insert(size) == size,
            _ => false,
        }
    }

    fn fits(&mut self, dim: Dim, declared: i64) -> bool {
        match dim {
            _ if declared < 0 => true,
            Dim::Exactly(size) => declared == size,
            Dim::Any(_) => true,
            Dim::Of(symbol) => self.settle(symbol, Some(declared)),
            Dim::Part(symbol, part) => self.settle(symbol, declared.checked_mul(part)),
            Dim::Tokens(symbol, part) => {
                let root = (declared as f64).sqrt().round() as i64;
                root.checked_mul(root) == Some(declared) && self.settle(symbol, root.checked_mul(part))
            }
        }
    }

    fn known(&self) -> String {
        let all: Vec<String> = self.0.iter().map(|(symbol, size)| format!("{symbol} = {size}")).collect();
        if all.is_empty() { String::new() } else { format!(" ({})", all.join(", ")) }
    }
}

/// A contract's tensor and the graph's that plays its part.
#[derive(Clone, Debug)]
pub struct Bound {
    /// The contract's name.
    pub name: &'static str,
    /// The graph's declaration.
    pub declared: Declared,
    /// Its element type.
    pub element: ElementType,
}

/// Which of a graph's tensors play which part.
#[derive(Clone, Debug, Default)]
pub struct Binding {
    /// What the graph is fed; parts that it does without are left out.
    pub inputs: Vec<Bound>,
    /// What is read of it.
    pub outputs: Vec<Bound>,
}

/// Finds the part of every tensor of a graph; `sizes` collects what the model's graphs agree on.
///
/// # Errors
/// The first tensor that does not fit, as expected and as found.
pub fn bind(
    spec: &GraphSpec,
    inputs: &[Declared],
    outputs: &[Declared],
    sizes: &mut Sizes,
) -> Result<Binding, Mismatch> {
    if let Some(stray) =
        inputs.iter().find(|found| !spec.inputs.iter().any(|part| part.is_named(&found.name)))
    {
        // A renamed tensor is better reported as the one that is missing.
        let missing = spec.inputs.iter().find(|part| !part.optional && find(part, inputs).is_none());
        return Err(match missing {
            Some(part) => absent("input", part, inputs),
            None => Mismatch::Unexpected { graph: spec.name, found: stray.to_string() },
        });
    }
    Ok(Binding {
        inputs: bind_all("input", spec.inputs, inputs, sizes)?,
        outputs: bind_all("output", spec.outputs, outputs, sizes)?,
    })
}

fn find<'a>(part: &TensorSpec, declared: &'a [Declared]) -> Option<&'a Declared> {
    let by = |name: &str| declared.iter().find(|found| found.name == name);
    by(part.name).or_else(|| part.aliases.iter().find_map(|alias| by(alias)))
}

fn absent(kind: &'static str, part: &TensorSpec, declared: &[Declared]) -> Mismatch {
    let found: Vec<String> = declared.iter().map(Declared::to_string).collect();
    Mismatch::Missing { kind, expected: part.to_string(), found: found.join(", ") }
}

fn bind_all(
    kind: &'static str,
    parts: &[TensorSpec],
    declared: &[Declared],
    sizes: &mut Sizes,
) -> Result<Vec<Bound>, Mismatch> {
    let mut bound = Vec::new();
    for part in parts {
        let Some(found) = find(part, declared) else {
            if part.optional {
                continue;
            }
            return Err(absent(kind, part, declared));
        };
        let element = match found.element {
            Ok(element) if part.types.contains(&element) => element,
            _ => return Err(Mismatch::Type { kind, expected: part.to_string(), found: found.to_string() }),
        };
        let mut settled = None;
        for shape in part.shapes {
            let mut trial = sizes.clone();
            if shape.len() == found.shape.len()
                && shape.iter().zip(&found.shape).all(|(dim, size)| trial.fits(*dim, *size))
            {
                settled = Some(trial);
                break;
            }
        }
        let Some(settled) = settled else {
            let (expected, found) = (part.to_string(), found.to_string());
            return Err(Mismatch::Shape { kind, expected, found, known: sizes.known() });
        };
        *sizes = settled;
        bound.push(Bound { name: part.name, declared: found.clone(), element });
    }
    Ok(bound)
}

#[cfg(test)]
mod tests {
    use super::*;
    use Dim::{Exactly as E, Part, Tokens};

    const SPEC: GraphSpec = GraphSpec {
        name: "encoder",
        inputs: &[TensorSpec::floats("image", &[&[E(1), E(3), Dim::Of("S"), Dim::Of("S")]])
            .or_named(&["pixel_values"])],
        outputs: &[
            TensorSpec::floats("features", &[&[E(1), E(32), Part("S", 4), Part("S", 4)]]),
            TensorSpec::floats("tokens", &[&[Tokens("S", 16), E(1), E(256)]]).if_there(),
        ],
        optional: false,
    };

    fn tensor(name: &str, shape: &[i64]) -> Declared {
        Declared { name: name.to_owned(), element: Ok(ElementType::F32), shape: shape.to_vec() }
    }

    fn probe(inputs: &[Declared], outputs: &[Declared]) -> Result<Sizes, Mismatch> {
        let mut sizes = Sizes::default();
        bind(&SPEC, inputs, outputs, &mut sizes).map(|_| sizes)
    }

    #[test]
    fn a_side_is_read_from_whatever_tensor_declares_it() {
        let open = [tensor("image", &[-1, 3, -1, -1])];
        let found = probe(&open, &[tensor("features", &[1, 32, 128, 128])]).map(|sizes| sizes.get("S"));
        assert_eq!(found, Ok(Ok(512)));
        let tokens = [tensor("features", &[1, 32, -1, -1]), tensor("tokens", &[4096, 1, 256])];
        assert_eq!(probe(&open, &tokens).map(|sizes| sizes.get("S")), Ok(Ok(1024)));
        let nothing = probe(&open, &[tensor("features", &[1, 32, -1, -1])]).map(|sizes| sizes.get("S"));
        assert_eq!(nothing, Ok(Err(Mismatch::Open { symbol: "S" })));
    }

    #[test]
    fn each_kind_of_mismatch_names_what_was_expected() {
        let image = [tensor("image", &[1, 3, 512, 512])];
        let features = tensor("features", &[1, 32, 128, 128]);
        let contradicting = probe(&image, &[tensor("features", &[1, 32, 64, 64])]);
        assert!(matches!(&contradicting, Err(Mismatch::Shape { known, .. }) if known == " (S = 512)"));
        let renamed = probe(&[tensor("picture", &[1, 3, 512, 512])], std::slice::from_ref(&features));
        let Err(error) = renamed else { panic!("a renamed input was taken") };
        assert!(error.to_string().contains("`image` f32 [1, 3, S, S]"), "{error}");
        let more = [image[0].clone(), tensor("extra", &[1])];
        let unexpected = probe(&more, std::slice::from_ref(&features));
        assert!(matches!(unexpected, Err(Mismatch::Unexpected { .. })));
        let double = Declared { element: Err("f64".to_owned()), ..image[0].clone() };
        assert!(matches!(probe(&[double], &[features]), Err(Mismatch::Type { .. })));
        assert!(matches!(probe(&image, &[]), Err(Mismatch::Missing { kind: "output", .. })));
    }

    #[test]
    fn an_alias_plays_the_part() {
        let hf = [tensor("pixel_values", &[-1, 3, 1024, 1024])];
        assert!(probe(&hf, &[tensor("features", &[1, 32, 256, 256])]).is_ok());
    }
}
