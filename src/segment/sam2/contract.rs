//! The contract `sam2-video/1`: SAM 2.1 in four graphs with every learned constant inside.
//!
//! Names of wp133716/samurai-onnx, `scripts/export_onnx.py`.

use crate::onnx::{
    Contract,
    Dim::{self, Any, Exactly as E, Of, Part, Tokens},
    ElementType::{Bool, F32, I32, I64},
    GraphSpec, TensorSpec as T,
};

const FEATURES: &[Dim] = &[Tokens("S", 16), E(1), E(256)];
const MAP: &[Dim] = &[E(1), E(256), Part("S", 16), Part("S", 16)];
const HIGH_0: &[Dim] = &[E(1), E(32), Part("S", 4), Part("S", 4)];
const HIGH_1: &[Dim] = &[E(1), E(64), Part("S", 8), Part("S", 8)];
const MEMORY: &[Dim] = &[Tokens("S", 16), E(1), E(64)];
/// Several memories: the frames' tokens one frame after the other, only shaped as if they were interleaved.
const MEMORIES: &[Dim] = &[Tokens("S", 16), Any("n"), E(1), E(64)];

const fn graph(name: &'static str, inputs: &'static [T], outputs: &'static [T]) -> GraphSpec {
    GraphSpec { name, inputs, outputs, optional: false }
}

/// Pictures are RGB from 0 to 255, rows then columns then channels; points are pixels of the S × S picture.
pub const SAM2_VIDEO: Contract = Contract {
    id: "sam2-video/1",
    graphs: &[
        graph(
            "image_encoder",
            &[T::floats("image", &[&[E(1), Of("S"), Of("S"), E(3)]])],
            &[
                T::floats("high_res_features0", &[HIGH_0]).or_named(&["high_res_features_0"]),
                T::floats("high_res_features1", &[HIGH_1]).or_named(&["high_res_features_1"]),
                T::floats("low_res_features", &[FEATURES]),
                T::floats("vision_pos_embeds", &[FEATURES]),
                T::floats("pix_feat_with_mem", &[MAP]),
            ],
        ),
        graph(
            "memory_attention",
            &[
                T::floats("current_vision_feats", &[FEATURES]),
                T::floats("current_vision_pos_embeds", &[FEATURES]),
                T::floats("maskmem_feats", &[MEMORIES]),
                T::floats("memory_pos_embed", &[MEMORIES]),
                T::floats("obj_ptrs", &[&[Any("m"), E(1), E(256)]]),
                T::of("obj_pos", &[I32, I64], &[&[Any("m")]]),
            ],
            &[T::floats("pix_feat_with_mem", &[MAP])],
        ),
        graph(
            "mask_decoder",
            &[
                T::floats("point_coords", &[&[E(1), E(2), E(2)]]),
                T::of("point_labels", &[I32, I64, F32], &[&[E(1), E(2)]]),
                T::floats("pix_feat_with_mem", &[MAP]),
                T::floats("high_res_features_0", &[HIGH_0]).or_named(&["high_res_features0"]),
                T::floats("high_res_features_1", &[HIGH_1]).or_named(&["high_res_features1"]),
            ],
            &[
                T::floats("low_res_multimasks", &[&[E(1), E(3), Part("S", 4), Part("S", 4)]]),
                T::floats("ious", &[&[E(1), E(3)]]),
                T::floats("obj_ptr", &[&[E(1), E(3), E(256)]]),
                T::floats("object_score_logits", &[&[E(1), E(1)]]),
                T::floats("maskmem_tpos_enc", &[&[E(7), E(1), E(1), E(64)]]),
            ],
        ),
        graph(
            "memory_encoder",
            &[
                T::floats("pix_feat", &[FEATURES]),
                T::floats("mask_for_mem", &[&[E(1), E(1), Of("S"), Of("S")]]),
                T::floats("object_score_logits", &[&[E(1), E(1)]]),
                T::of("is_mask_from_pts", &[Bool], &[&[], &[E(1)]]),
            ],
            &[T::floats("maskmem_features", &[MEMORY]), T::floats("maskmem_pos_enc", &[MEMORY])],
        ),
    ],
};
