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
