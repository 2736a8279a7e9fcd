//! The contract `image-inpaint/1`.

use crate::onnx::{Contract, Dim, GraphSpec, TensorSpec};

const ONE: Dim = Dim::Exactly(1);
const THREE: Dim = Dim::Exactly(3);
const SIDE: Dim = Dim::Of("S");

/// A picture, RGB from 0 to 1 with 0 in the hole, and the hole as ones come in; RGB from 0 to 255 comes out.
pub const IMAGE_INPAINT: Contract = Contract {
    id: "image-inpaint/1",
    graphs: &[GraphSpec {
        name: "image_inpaint",
        inputs: &[
            TensorSpec::floats("image", &[&[ONE, THREE, SIDE, SIDE]]),
            TensorSpec::floats("mask", &[&[ONE, ONE, SIDE, SIDE]]),
        ],
        outputs: &[TensorSpec::floats("output", &[&[ONE, THREE, SIDE, SIDE]])],
        optional: false,
    }],
};
