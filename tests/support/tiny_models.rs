//! Tiny models that honour a contract: what they compute is so simple that the right answer is known.
#![allow(dead_code, clippy::unwrap_used, reason = "each test file uses its own part")]

use std::{fs, path::Path};

use super::graph_writer::{Element, GraphWriter, Value};

/// A model folder below `root`: a description and one file a graph.
pub fn write_model(root: &Path, name: &str, description: &str, graphs: &[(&str, Vec<u8>)]) {
    let folder = root.join(name);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("model.toml"), description).unwrap();
    for (file, bytes) in graphs {
        fs::write(folder.join(file), bytes).unwrap();
    }
}

/// `video-inpaint/1`: every picture becomes the mean, over the frames fed, of what is not taken out there.
pub fn mean_of_unmasked(frames: i64, local: i64, height: i64, width: i64) -> Vec<u8> {
    let all = [frames, 3, height, width];
    GraphWriter::new()
        .input("masked_frames", Element::F32, &[1, frames, 3, height, width])
        .integers("first", &[1], &[0])
        .integers("shape", &[4], &[local, 3, height, width])
        .floats("zero", &[1], &[0.0])
        .floats("least", &[1], &[1e-6])
        .node("Squeeze", &["masked_frames", "first"], "frames", &[])
        .node("Abs", &["frames"], "size", &[])
        .node("Greater", &["size", "zero"], "there", &[])
        .node("Cast", &["there"], "count_each", &[("to", Value::Integer(1))])
        .node("ReduceSum", &["frames", "first"], "sum", &[])
        .node("ReduceSum", &["count_each", "first"], "count", &[])
        .node("Max", &["count", "least"], "some", &[])
        .node("Div", &["sum", "some"], "mean", &[])
        .node("Expand", &["mean", "shape"], "pred_frames", &[])
        .output("pred_frames", Element::F32, &[local, all[1], all[2], all[3]])
        .bytes()
}

/// `sam2-video/1` with S = 64: what is red is the object, but only near where memories say it was.
pub fn red_things() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("image_encoder.onnx", red_encoder()),
        ("memory_attention.onnx", where_it_was()),
        ("mask_decoder.onnx", red_and_near()),
        ("memory_encoder.onnx", coarse_mask()),
    ]
}

const F: Element = Element::F32;

/// Nothing of a tensor, as one number: an input that is used without changing anything.
fn unused(writer: GraphWriter, name: &str) -> GraphWriter {
    let (float, sum, none) = (format!("{name}_float"), format!("{name}_sum"), format!("{name}_none"));
    writer
        .node("Cast", &[name], &float, &[("to", Value::Integer(1))])
        .node("ReduceSum", &[&float], &sum, &[("keepdims", Value::Integer(0))])
        .node("Mul", &[&sum, "zero"], &none, &[])
}

fn red_encoder() -> Vec<u8> {
    let pool = |writer: GraphWriter, size: i64, to: &str| {
        let attributes =
            [("kernel_shape", Value::Integers(&[size, size])), ("strides", Value::Integers(&[size, size]))];
        writer.node("AveragePool", &["red"], to, &attributes)
    };
    let mut writer = GraphWriter::new()
        .input("image", F, &[1, 64, 64, 3])
        .floats("weights", &[1, 3, 1, 1], &[1.0 / 255.0, -0.5 / 255.0, -0.5 / 255.0])
        .floats("one", &[1], &[1.0])
        .integers("shape0", &[4], &[1, 32, 16, 16])
        .integers("shape1", &[4], &[1, 64, 8, 8])
        .integers("tokens", &[3], &[16, 1, 1])
        .integers("low_shape", &[3], &[16, 1, 256])
        .integers("map_shape", &[4], &[1, 256, 4, 4])
        .node("Transpose", &["image"], "planes", &[("perm", Value::Integers(&[0, 3, 1, 2]))])
        .node("Conv", &["planes", "weights"], "red", &[]);
    writer = pool(writer, 4, "red4");
    writer = pool(writer, 8, "red8");
    writer = pool(writer, 16, "red16");
    writer
        .node("Expand", &["red4", "shape0"], "high_res_features0", &[])
        .node("Expand", &["red8", "shape1"], "high_res_features1", &[])
        .node("Reshape", &["red16", "tokens"], "red_tokens", &[])
        .node("Expand", &["red_tokens", "low_shape"], "low_res_features", &[])
        .node("Identity", &["low_res_features"], "vision_pos_embeds", &[])
        // Without a memory the object may be anywhere.
        .node("Expand", &["one", "map_shape"], "pix_feat_with_mem", &[])
        .output("high_res_features0", F, &[1, 32, 16, 16])
        .output("high_res_features1", F, &[1, 64, 8, 8])
        .output("low_res_features", F, &[16, 1, 256])
        .output("vision_pos_embeds", F, &[16, 1, 256])
        .output("pix_feat_with_mem", F, &[1, 256, 4, 4])
        .bytes()
}

fn where_it_was() -> Vec<u8> {
    let inputs =
        ["current_vision_feats", "current_vision_pos_embeds", "memory_pos_embed", "obj_ptrs", "obj_pos"];
    let mut writer = GraphWriter::new()
        .input("current_vision_feats", F, &[16, 1, 256])
        .input("current_vision_pos_embeds", F, &[16, 1, 256])
        .input("maskmem_feats", F, &[16, -1, 1, 64])
        .input("memory_pos_embed", F, &[16, -1, 1, 64])
        .input("obj_ptrs", F, &[-1, 1, 256])
        .input("obj_pos", Element::I32, &[-1])
        .floats("zero", &[1], &[0.0])
        .integers("frames_first", &[3], &[-1, 16, 64])
        .integers("grid", &[4], &[1, 1, 4, 4])
        .integers("map_shape", &[4], &[1, 256, 4, 4])
        // Frame after frame, whatever the declared shape says.
        .node("Reshape", &["maskmem_feats", "frames_first"], "frames", &[])
        .node(
            "ReduceMax",
            &["frames"],
            "ever",
            &[("axes", Value::Integers(&[0, 2])), ("keepdims", Value::Integer(0))],
        )
        .node("Reshape", &["ever", "grid"], "there", &[])
        .node(
            "MaxPool",
            &["there"],
            "near",
            &[
                ("kernel_shape", Value::Integers(&[3, 3])),
                ("pads", Value::Integers(&[1, 1, 1, 1])),
                ("strides", Value::Integers(&[1, 1])),
            ],
        );
    for input in inputs {
        writer = unused(writer, input);
    }
    let sum: Vec<String> = inputs.iter().map(|input| format!("{input}_none")).collect();
    let mut sum: Vec<&str> = sum.iter().map(String::as_str).collect();
    sum.push("near");
    writer
        .node("Sum", &sum, "kept", &[])
        .node("Expand", &["kept", "map_shape"], "pix_feat_with_mem", &[])
        .output("pix_feat_with_mem", F, &[1, 256, 4, 4])
        .bytes()
}

fn red_and_near() -> Vec<u8> {
    let times: Vec<f32> = (0..7).flat_map(|row| [row as f32; 64]).collect();
    let mut writer = GraphWriter::new()
        .input("point_coords", F, &[1, 2, 2])
        .input("point_labels", Element::I32, &[1, 2])
        .input("pix_feat_with_mem", F, &[1, 256, 4, 4])
        .input("high_res_features_0", F, &[1, 32, 16, 16])
        .input("high_res_features_1", F, &[1, 64, 8, 8])
        .floats("zero", &[1], &[0.0])
        .floats("half", &[1], &[0.5])
        .floats("forty", &[1], &[40.0])
        .floats("twenty", &[1], &[20.0])
        .floats("slots", &[1, 3, 1, 1], &[-1.0, 1.0, -1.0])
        .floats("ious_are", &[1, 3], &[0.1, 0.9, 0.3])
        .floats("times", &[7, 1, 1, 64], &times)
        .floats("no_pointer", &[1, 3, 256], &[0.0; 3 * 256])
        .integers("from", &[1], &[0])
        .integers("to", &[1], &[1])
        .integers("channel", &[1], &[1])
        .integers("cells", &[6], &[1, 1, 4, 1, 4, 1])
        .integers("pixels", &[6], &[1, 1, 4, 4, 4, 4])
        .integers("square", &[4], &[1, 1, 16, 16])
        .integers("score_shape", &[2], &[1, 1])
        .node("Slice", &["pix_feat_with_mem", "from", "to", "channel"], "near", &[])
        .node("Reshape", &["near", "cells"], "near_cells", &[])
        .node("Expand", &["near_cells", "pixels"], "near_pixels", &[])
        .node("Reshape", &["near_pixels", "square"], "near_square", &[])
        .node("Greater", &["near_square", "half"], "is_near", &[])
        .node("Cast", &["is_near"], "gate", &[("to", Value::Integer(1))])
        .node("Slice", &["high_res_features_0", "from", "to", "channel"], "red", &[])
        .node("Mul", &["red", "gate"], "red_near", &[])
        .node("Mul", &["red_near", "forty"], "strong", &[])
        .node("Sub", &["strong", "twenty"], "logits", &[])
        .node("Mul", &["logits", "slots"], "three", &[])
        .node("ReduceMax", &["logits"], "most", &[("keepdims", Value::Integer(0))])
        .node("Reshape", &["most", "score_shape"], "score", &[]);
    for input in ["point_coords", "point_labels", "high_res_features_1"] {
        writer = unused(writer, input);
    }
    writer
        .node(
            "Sum",
            &["score", "point_coords_none", "point_labels_none", "high_res_features_1_none"],
            "object_score_logits",
            &[],
        )
        .node("Identity", &["three"], "low_res_multimasks", &[])
        .node("Identity", &["ious_are"], "ious", &[])
        .node("Identity", &["times"], "maskmem_tpos_enc", &[])
        .node("Identity", &["no_pointer"], "obj_ptr", &[])
        .output("low_res_multimasks", F, &[1, 3, 16, 16])
        .output("ious", F, &[1, 3])
        .output("obj_ptr", F, &[1, 3, 256])
        .output("object_score_logits", F, &[1, 1])
        .output("maskmem_tpos_enc", F, &[7, 1, 1, 64])
        .bytes()
}

fn coarse_mask() -> Vec<u8> {
    let mut writer = GraphWriter::new()
        .input("pix_feat", F, &[16, 1, 256])
        .input("mask_for_mem", F, &[1, 1, 64, 64])
        .input("object_score_logits", F, &[1, 1])
        .input("is_mask_from_pts", Element::Bool, &[])
        .floats("zero", &[1], &[0.0])
        .integers("tokens", &[3], &[16, 1, 1])
        .integers("memory", &[3], &[16, 1, 64])
        .node("Sigmoid", &["mask_for_mem"], "soft", &[])
        .node(
            "MaxPool",
            &["soft"],
            "coarse",
            &[("kernel_shape", Value::Integers(&[16, 16])), ("strides", Value::Integers(&[16, 16]))],
        )
        .node("Reshape", &["coarse", "tokens"], "each", &[]);
    for input in ["pix_feat", "object_score_logits", "is_mask_from_pts"] {
        writer = unused(writer, input);
    }
    let sum = ["each", "pix_feat_none", "object_score_logits_none", "is_mask_from_pts_none"];
    writer
        .node("Sum", &sum, "kept", &[])
        .node("Expand", &["kept", "memory"], "maskmem_features", &[])
        .node("Identity", &["maskmem_features"], "maskmem_pos_enc", &[])
        .output("maskmem_features", F, &[16, 1, 64])
        .output("maskmem_pos_enc", F, &[16, 1, 64])
        .bytes()
}

/// `sam2-image/1` with S = 64: what is red is the object, wherever somebody clicks. Names and ranks of samexporter, or
/// of Hugging Face's exporter.
pub fn red_picture(hugging_face: bool) -> Vec<(&'static str, Vec<u8>)> {
    let names = if hugging_face {
        ["pixel_values", "image_embeddings.0", "image_embeddings.1", "image_embeddings.2"]
    } else {
        ["image", "high_res_feats_0", "high_res_feats_1", "image_embed"]
    };
    vec![
        ("encoder.onnx", red_picture_encoder(names)),
        ("decoder.onnx", red_picture_decoder([names[3], names[1], names[2]], hugging_face)),
    ]
}

fn red_picture_encoder(names: [&str; 4]) -> Vec<u8> {
    let [image, high_0, high_1, embedding] = names;
    let mut writer = GraphWriter::new()
        .input(image, F, &[-1, 3, 64, 64])
        // Of normalised colours: about 4 where it is red, about 0 where it is grey.
        .floats("weights", &[1, 3, 1, 1], &[1.0, -0.5, -0.5])
        .node("Conv", &[image, "weights"], "red", &[]);
    for (size, channels, to) in [(4, 32, high_0), (8, 64, high_1), (16, 256, embedding)] {
        let (pooled, shape) = (format!("red{size}"), format!("shape{size}"));
        let attributes =
            [("kernel_shape", Value::Integers(&[size, size])), ("strides", Value::Integers(&[size, size]))];
        writer = writer
            .integers(&shape, &[4], &[1, channels, 64 / size, 64 / size])
            .node("AveragePool", &["red"], &pooled, &attributes)
            .node("Expand", &[&pooled, &shape], to, &[])
            .output(to, F, &[1, channels, 64 / size, 64 / size]);
    }
    writer.bytes()
}

fn red_picture_decoder(features: [&str; 3], hugging_face: bool) -> Vec<u8> {
    let [embedding, high_0, high_1] = features;
    let mut writer = GraphWriter::new()
        .input(embedding, F, &[1, 256, 4, 4])
        .input(high_0, F, &[1, 32, 16, 16])
        .input(high_1, F, &[1, 64, 8, 8])
        .floats("zero", &[1], &[0.0])
        .floats("ten", &[1], &[10.0])
        .floats("twenty", &[1], &[20.0])
        .floats("slots", &[1, 3, 1, 1], &[-1.0, 1.0, -1.0])
        .integers("from", &[1], &[0])
        .integers("to", &[1], &[1])
        .integers("channel", &[1], &[1]);
    let more: &[(&str, Element, &[i64])] = if hugging_face {
        &[
            ("input_points", F, &[-1, -1, -1, 2]),
            ("input_labels", Element::I64, &[-1, -1, -1]),
            ("input_boxes", F, &[-1, -1, 4]),
        ]
    } else {
        &[
            ("point_coords", F, &[-1, -1, 2]),
            ("point_labels", F, &[-1, -1]),
            ("mask_input", F, &[-1, 1, 16, 16]),
            ("has_mask_input", F, &[1]),
        ]
    };
    let mut sum = vec!["three".to_owned()];
    for (name, element, shape) in more {
        writer = unused(writer.input(name, *element, shape), name);
        sum.push(format!("{name}_none"));
    }
    let sum: Vec<&str> = sum.iter().map(String::as_str).collect();
    let (masks, fits, rank) = if hugging_face {
        ("pred_masks", "iou_scores", vec![1, 1])
    } else {
        ("masks", "iou_predictions", vec![1])
    };
    let shape = |end: &[i64]| [rank.as_slice(), end].concat();
    let (mask_shape, fit_shape) = (shape(&[3, 16, 16]), shape(&[3]));
    writer
        .integers("mask_shape", &[mask_shape.len() as i64], &mask_shape)
        .floats("fits", &fit_shape, &[0.1, 0.9, 0.3])
        .node("Slice", &[high_0, "from", "to", "channel"], "red", &[])
        .node("Mul", &["red", "ten"], "strong", &[])
        .node("Sub", &["strong", "twenty"], "logits", &[])
        .node("Mul", &["logits", "slots"], "three", &[])
        .node("Sum", &sum, "kept", &[])
        .node("Reshape", &["kept", "mask_shape"], masks, &[])
        .node("Identity", &["fits"], fits, &[])
        .output(masks, F, &mask_shape)
        .output(fits, F, &fit_shape)
        .bytes()
}

/// `hand-pose/1`, detector: what is red is a right hand, in a square box of a given side about its middle.
pub fn red_hand_detector(side: i64, boxed: f32) -> Vec<u8> {
    let across: Vec<f32> = (0..side * side).map(|at| (at % side) as f32).collect();
    let down: Vec<f32> = (0..side * side).map(|at| (at / side) as f32).collect();
    let mut writer = GraphWriter::new()
        .input("images", F, &[1, 3, side, side])
        .floats("weights", &[1, 3, 1, 1], &[1.0, -0.5, -0.5])
        .floats("across", &[1, 1, side, side], &across)
        .floats("down", &[1, 1, side, side], &down)
        .floats("half", &[1], &[0.5])
        .floats("least", &[1], &[1e-3])
        .floats("rest", &[1, 4, 1], &[boxed, boxed, 0.1, 0.9])
        .integers("cell", &[3], &[1, 1, 1])
        .node("Conv", &["images", "weights"], "redness", &[])
        .node("Greater", &["redness", "half"], "is_red", &[])
        .node("Cast", &["is_red"], "red", &[("to", Value::Integer(1))])
        .node("ReduceSum", &["red"], "area", &[("keepdims", Value::Integer(0))])
        .node("Max", &["area", "least"], "some", &[]);
    for axis in ["across", "down"] {
        let (times, sum, mean) = (format!("{axis}_times"), format!("{axis}_sum"), format!("{axis}_mean"));
        writer = writer
            .node("Mul", &["red", axis], &times, &[])
            .node("ReduceSum", &[&times], &sum, &[("keepdims", Value::Integer(0))])
            .node("Div", &[&sum, "some"], &mean, &[])
            .node("Reshape", &[&mean, "cell"], &format!("{axis}_cell"), &[]);
    }
    writer
        .node("Concat", &["across_cell", "down_cell", "rest"], "output0", &[("axis", Value::Integer(1))])
        .output("output0", F, &[1, 6, 1])
        .bytes()
}

/// `hand-pose/1`, detector: the same candidates on every picture; each a box's centre and size, trust in a left and in a
/// right hand.
pub fn same_hands_detector(side: i64, hands: &[[f32; 6]]) -> Vec<u8> {
    let count = hands.len() as i64;
    let row = |row: usize| hands.iter().map(move |hand| if row < 6 { hand[row] } else { 0.0 });
    let values: Vec<f32> = (0..69).flat_map(row).collect();
    GraphWriter::new()
        .input("images", F, &[1, 3, side, side])
        .floats("same", &[1, 69, count], &values)
        .node("Identity", &["same"], "output0", &[])
        .output("output0", F, &[1, 69, count])
        .bytes()
}

/// 21 joints of a flat right hand that points up, palm away, metres: 18 cm from the wrist to the middle finger's tip.
pub fn flat_hand() -> [[f32; 3]; 21] {
    let mut joints = [[0.0; 3]; 21];
    for finger in 0..5 {
        for joint in 0..4 {
            let aside = 0.02 * (finger as f32 - 2.0);
            joints[1 + 4 * finger + joint] = [aside, -0.09 - 0.03 * joint as f32, 0.0];
        }
    }
    joints
}

/// `hand-pose/1`, regressor: the hand `joints` of scale `scale`, shifted to where the crop is brighter; its rotations are
/// quarter turns about x where asked for.
pub fn brighter_side_regressor(scale: f32, joints: &[[f32; 3]], rotations: bool) -> Vec<u8> {
    let count = joints.len() as i64;
    let mut writer = GraphWriter::new()
        .input("img", F, &[-1, 3, 256, 256])
        .floats("scale", &[1, 1], &[scale])
        .floats("none", &[1, 1], &[0.0])
        .floats("joints", &[1, count, 3], joints.as_flattened())
        .integers("start", &[1], &[0])
        .integers("middle", &[1], &[128])
        .integers("end", &[1], &[256])
        .integers("columns", &[1], &[3])
        .integers("one", &[2], &[1, 1])
        .node("Slice", &["img", "start", "middle", "columns"], "left", &[])
        .node("Slice", &["img", "middle", "end", "columns"], "right", &[]);
    for half in ["left", "right"] {
        let to = format!("{half}_mean");
        writer = writer.node("ReduceMean", &[half], &to, &[("keepdims", Value::Integer(0))]);
    }
    writer = writer
        .node("Sub", &["right_mean", "left_mean"], "difference", &[])
        .node("Reshape", &["difference", "one"], "shift", &[])
        .node("Concat", &["scale", "shift", "none"], "pred_cam", &[("axis", Value::Integer(1))])
        .node("Identity", &["joints"], "pred_keypoints_3d", &[])
        .output("pred_cam", F, &[-1, 3])
        // A wrong count shows only when the graph is run.
        .output("pred_keypoints_3d", F, &[-1, if count == 21 { 21 } else { -1 }, 3]);
    if rotations {
        let turn = [1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0];
        writer = writer
            .floats("turn", &[1, 1, 3, 3], &turn)
            .floats("turns", &[1, 15, 3, 3], &turn.repeat(15))
            .floats("shape", &[1, 10], &[0.5; 10])
            .node("Identity", &["turn"], "global_orient", &[])
            .node("Identity", &["turns"], "hand_pose", &[])
            .node("Identity", &["shape"], "betas", &[])
            .output("global_orient", F, &[-1, 1, 3, 3])
            .output("hand_pose", F, &[-1, 15, 3, 3])
            .output("betas", F, &[-1, 10]);
    }
    writer.bytes()
}

/// `image-inpaint/1`: the hole gets the mean colour of what is around it, and everything else is turned to noise.
pub fn mean_of_surroundings(side: i64) -> Vec<u8> {
    GraphWriter::new()
        .input("image", F, &[-1, 3, side, side])
        .input("mask", F, &[-1, 1, side, side])
        .floats("one", &[1], &[1.0])
        .floats("full", &[1], &[255.0])
        .floats("least", &[1], &[1e-3])
        .integers("space", &[2], &[2, 3])
        .integers("whole", &[4], &[1, 3, side, side])
        .node("ReduceSum", &["image", "space"], "sum", &[])
        .node("Sub", &["one", "mask"], "known", &[])
        .node("ReduceSum", &["known", "space"], "count", &[])
        .node("Max", &["count", "least"], "some", &[])
        .node("Div", &["sum", "some"], "mean", &[])
        .node("Mul", &["mean", "full"], "colour", &[])
        .node("Expand", &["colour", "whole"], "spread", &[])
        // What is known comes back as anything: nobody may look at it.
        .node("Mul", &["known", "full"], "noise", &[])
        .node("Add", &["spread", "noise"], "output", &[])
        .output("output", F, &[-1, 3, side, side])
        .bytes()
}
