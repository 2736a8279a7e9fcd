//! The contract `video-inpaint/1`: E2FGVI-HQ and networks like it.

use serde::{Deserialize, Serialize};

use crate::onnx::{Contract, Dim, GraphSpec, TensorSpec};

/// Local frames first, then reference frames; what is taken out is 0, the rest RGB from -1 to 1.
pub const VIDEO_INPAINT: Contract = Contract {
    id: "video-inpaint/1",
    graphs: &[GraphSpec {
        name: "video_inpaint",
        inputs: &[TensorSpec::floats(
            "masked_frames",
            &[&[Dim::Exactly(1), Dim::Of("T"), Dim::Exactly(3), Dim::Of("H"), Dim::Of("W")]],
        )],
        outputs: &[TensorSpec::floats(
            "pred_frames",
            &[&[Dim::Any("T or L"), Dim::Exactly(3), Dim::Of("H"), Dim::Of("W")]],
        )],
        optional: false,
    }],
};

/// What the contract lets a model choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VideoParameters {
    /// Frames from one window's centre to the next (default 5).
    pub neighbor_stride: usize,
    /// Reference frames are the multiples of this (default 10).
    pub ref_step: usize,
}

impl Default for VideoParameters {
    fn default() -> Self {
        Self { neighbor_stride: 5, ref_step: 10 }
    }
}
