//! The contract `sam2-image/1`: SAM 2 or 2.1 on one picture.
//!
//! Names of vietanhdev/samexporter, `export_sam2.py`; aliases of ONNX Runtime's own exporter and of Hugging Face's.

use crate::onnx::{
    Contract,
    Dim::{self, Any, Exactly as E, Of, Part},
    ElementType::{F32, I32, I64},
    GraphSpec, TensorSpec as T,
};

const HIGH_0: &[Dim] = &[E(1), E(32), Part("S", 4), Part("S", 4)];
const HIGH_1: &[Dim] = &[E(1), E(64), Part("S", 8), Part("S", 8)];
const EMBEDDING: &[Dim] = &[E(1), E(256), Part("S", 16), Part("S", 16)];
const ALIAS_0: &[&str] = &["image_features_0", "image_embeddings.0"];
const ALIAS_1: &[&str] = &["image_features_1", "image_embeddings.1"];
const ALIAS_2: &[&str] = &["image_embeddings", "image_embeddings.2"];
const LOW: &[Dim] = &[Any("L"), E(1), Part("S", 4), Part("S", 4)];
const MASKS: &[Dim] = &[Any("L"), Any("masks"), Part("S", 4), Part("S", 4)];
const MASKS_OF_POINTS: &[Dim] = &[Any("B"), Any("L"), Any("masks"), Part("S", 4), Part("S", 4)];

/// The picture is RGB, 0 to 1, normalised as ImageNet's; points are pixels of the S × S picture.
pub const SAM2_IMAGE: Contract = Contract {
    id: "sam2-image/1",
    graphs: &[
        GraphSpec {
            name: "encoder",
            inputs: &[T::floats("image", &[&[E(1), E(3), Of("S"), Of("S")]]).or_named(&["pixel_values"])],
            outputs: &[
                T::floats("high_res_feats_0", &[HIGH_0]).or_named(ALIAS_0),
                T::floats("high_res_feats_1", &[HIGH_1]).or_named(ALIAS_1),
                T::floats("image_embed", &[EMBEDDING]).or_named(ALIAS_2),
            ],
            optional: false,
        },
        GraphSpec {
            name: "decoder",
            inputs: &[
                T::floats("image_embed", &[EMBEDDING]).or_named(ALIAS_2),
                T::floats("high_res_feats_0", &[HIGH_0]).or_named(ALIAS_0),
                T::floats("high_res_feats_1", &[HIGH_1]).or_named(ALIAS_1),
                T::floats(
                    "point_coords",
                    &[&[Any("L"), Any("P"), E(2)], &[Any("B"), Any("L"), Any("P"), E(2)]],
                )
                .or_named(&["input_points"]),
                T::of(
                    "point_labels",
                    &[F32, I32, I64],
                    &[&[Any("L"), Any("P")], &[Any("B"), Any("L"), Any("P")]],
                )
                .or_named(&["input_labels"]),
                T::floats("mask_input", &[LOW]).or_named(&["input_masks"]).if_there(),
                T::floats("has_mask_input", &[&[E(1)], &[Any("L")]])
                    .or_named(&["has_input_masks"])
                    .if_there(),
                T::of("original_image_size", &[I32, I64], &[&[E(2)]]).if_there(),
                T::floats("input_boxes", &[&[Any("B"), Any("boxes"), E(4)]]).if_there(),
            ],
            outputs: &[
                // ONNX Runtime's exporter calls the enlarged masks `masks`.
                T::floats("low_res_masks", &[MASKS, MASKS_OF_POINTS]).or_named(&["masks", "pred_masks"]),
                T::floats(
                    "iou_predictions",
                    &[&[Any("L"), Any("masks")], &[Any("B"), Any("L"), Any("masks")]],
                )
                .or_named(&["iou_scores"]),
            ],
            optional: false,
        },
    ],
};
