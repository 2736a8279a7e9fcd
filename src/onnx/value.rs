//! Tensors on their way into and out of a graph.

use ort::{
    memory::Allocator,
    value::{DynValue, Tensor, TensorElementType},
};

use super::{Declared, ElementType, OnnxError, probe::Bound};

/// A tensor. What a graph returned can be fed to another without being copied.
#[derive(Debug)]
pub struct Value(pub(super) DynValue);

/// What the runtime says about a tensor.
fn wrong(error: ort::Error) -> OnnxError {
    OnnxError::Tensor { reason: error.to_string() }
}

impl Value {
    /// Floats in C order.
    ///
    /// # Errors
    /// When `data` is not as long as `shape` says.
    pub fn floats(shape: &[usize], data: Vec<f32>) -> Result<Self, OnnxError> {
        Ok(Self(Tensor::from_array((shape.to_vec(), data)).map_err(wrong)?.into_dyn()))
    }

    /// 64-bit integers in C order; narrowed where a graph wants other elements.
    ///
    /// # Errors
    /// When `data` is not as long as `shape` says.
    pub fn integers(shape: &[usize], data: Vec<i64>) -> Result<Self, OnnxError> {
        Ok(Self(Tensor::from_array((shape.to_vec(), data)).map_err(wrong)?.into_dyn()))
    }

    /// A float tensor without a number in it: one of its sizes is 0.
    ///
    /// # Errors
    /// When the runtime cannot make a tensor.
    pub fn no_floats(shape: &[usize]) -> Result<Self, OnnxError> {
        Ok(Self(Tensor::<f32>::new(&Allocator::default(), shape.to_vec()).map_err(wrong)?.into_dyn()))
    }

    /// One boolean, of the rank a graph wants.
    ///
    /// # Errors
    /// When the runtime cannot make a tensor.
    pub fn flag(flag: bool) -> Result<Self, OnnxError> {
        Ok(Self(Tensor::from_array(([1_usize], vec![flag])).map_err(wrong)?.into_dyn()))
    }

    /// Its shape.
    pub fn shape(&self) -> Vec<usize> {
        let shape = self.0.dtype().tensor_shape();
        shape.map(|shape| shape.iter().map(|size| (*size).max(0) as usize).collect()).unwrap_or_default()
    }

    /// Its floats in C order.
    ///
    /// # Errors
    /// When it holds something else.
    pub fn as_floats(&self) -> Result<&[f32], OnnxError> {
        Ok(self.0.try_extract_tensor::<f32>().map_err(wrong)?.1)
    }

    /// The same numbers as the elements and rank that `bound` declares; `None` where they are already.
    pub(super) fn as_declared(&self, bound: &Bound) -> Result<Option<Self>, OnnxError> {
        let own = self.0.dtype().tensor_type().and_then(element_type);
        let (shape, wanted) = (self.shape(), bound.declared.shape.len());
        if own == Some(bound.element) && shape.len() == wanted {
            return Ok(None);
        }
        // Sizes of 1 in front are what exporters disagree about.
        let ones = shape.iter().take_while(|size| **size == 1).count();
        let surplus = shape.len().saturating_sub(wanted).min(ones);
        let missing = wanted.saturating_sub(shape.len());
        let shape: Vec<usize> =
            std::iter::repeat_n(1, missing).chain(shape[surplus..].iter().copied()).collect();
        let numbers = self.numbers(own)?;
        let made = match bound.element {
            ElementType::F32 => {
                Tensor::from_array((shape, numbers.iter().map(|n| *n as f32).collect::<Vec<_>>()))
                    .map_err(wrong)?
                    .into_dyn()
            }
            ElementType::I32 => {
                Tensor::from_array((shape, numbers.iter().map(|n| *n as i32).collect::<Vec<_>>()))
                    .map_err(wrong)?
                    .into_dyn()
            }
            ElementType::I64 => {
                Tensor::from_array((shape, numbers.iter().map(|n| *n as i64).collect::<Vec<_>>()))
                    .map_err(wrong)?
                    .into_dyn()
            }
            ElementType::Bool => {
                Tensor::from_array((shape, numbers.iter().map(|n| *n != 0.0).collect::<Vec<_>>()))
                    .map_err(wrong)?
                    .into_dyn()
            }
        };
        Ok(Some(Self(made)))
    }

    /// Small tensors alone are converted: labels, flags, frame distances.
    fn numbers(&self, own: Option<ElementType>) -> Result<Vec<f64>, OnnxError> {
        Ok(match own {
            Some(ElementType::F32) => {
                self.0.try_extract_tensor::<f32>().map_err(wrong)?.1.iter().map(|n| f64::from(*n)).collect()
            }
            Some(ElementType::I32) => {
                self.0.try_extract_tensor::<i32>().map_err(wrong)?.1.iter().map(|n| f64::from(*n)).collect()
            }
            Some(ElementType::I64) => {
                self.0.try_extract_tensor::<i64>().map_err(wrong)?.1.iter().map(|n| *n as f64).collect()
            }
            Some(ElementType::Bool) => self
                .0
                .try_extract_tensor::<bool>()
                .map_err(wrong)?
                .1
                .iter()
                .map(|n| f64::from(u8::from(*n)))
                .collect(),
            None => {
                return Err(OnnxError::Tensor {
                    reason: "it holds elements of a type that no contract uses".to_owned(),
                });
            }
        })
    }
}

/// The type as contracts name it.
pub(super) fn element_type(found: TensorElementType) -> Option<ElementType> {
    match found {
        TensorElementType::Float32 => Some(ElementType::F32),
        TensorElementType::Int32 => Some(ElementType::I32),
        TensorElementType::Int64 => Some(ElementType::I64),
        TensorElementType::Bool => Some(ElementType::Bool),
        _ => None,
    }
}

/// A graph's declaration of one tensor.
pub(super) fn declared(outlet: &ort::value::Outlet) -> Declared {
    let kind = outlet.dtype();
    let element = match kind.tensor_type() {
        Some(found) => element_type(found).ok_or_else(|| found.to_string()),
        None => Err("not a tensor".to_owned()),
    };
    let shape = kind.tensor_shape().map(|shape| shape.to_vec()).unwrap_or_default();
    Declared { name: outlet.name().to_owned(), element, shape }
}
