//! What learned back ends cost beside their graphs: graphs that compute nothing, of the real models' shapes, are run over a
//! clip of 640×480, and time and memory are printed.
//!
//! ```sh
//! cargo run --release --example host_overhead -- 2000
//! ```
#![allow(clippy::unwrap_used, reason = "a failing unwrap ends the measurement")]

#[path = "../tests/support/graph_writer.rs"]
mod graph_writer;

use std::{
    path::{Path, PathBuf},
    sync::Mutex,
};

use agenticfocus::{
    clip::{FrameError, FrameIndex, FrameSource},
    geometry::{Pinhole, PixelBox, Side, Size},
    hands::network::{HAND_POSE, HandNetwork},
    image::{Mask, Rgb8},
    inpaint::{
        InpaintParams,
        video::{Blend, VIDEO_INPAINT, VideoNetwork, clean_by_network},
    },
    onnx::{
        CheckedModel, Contract, Graph, GraphSpec, ModelFolder, Registry, Runtime, RuntimeOptions, Sizes,
        Trust, Value,
    },
    progress::Watch,
    segment::{
        MaskAuthor, MaskFrame, MaskTrack, RleMask,
        object::{ObjectPrompt, PromptKind},
        sam2::{SAM2_VIDEO, VideoSegmenter, track_object},
    },
    vision::single_threaded,
};
use graph_writer::{Element, GraphWriter};

const SIZE: Size = Size { width: 640, height: 480 };
/// Frames until everything that is kept was allocated.
const WARM: usize = 200;
/// Side of SAM 2's picture.
const S: i64 = 512;
const F: Element = Element::F32;

/// A few pictures, over and over.
struct Loop {
    pictures: Vec<Rgb8>,
    frames: usize,
}

impl Loop {
    fn new(frames: usize) -> Self {
        let picture = |shift: u32| {
            let mut picture = Rgb8::new(SIZE);
            for (at, byte) in picture.data_mut().iter_mut().enumerate() {
                *byte = (at as u32 * 31 / 7 + shift * 40) as u8;
            }
            picture
        };
        Self { pictures: (0..5).map(picture).collect(), frames }
    }

    fn masks(&self, inside: impl Fn(u32, u32) -> bool) -> MaskTrack {
        let mask = RleMask::encode(&Mask::from_fn(SIZE, inside));
        let frame = MaskFrame { mask, author: MaskAuthor::Seeded, score: 1.0, flags: Vec::new() };
        MaskTrack { size: SIZE, frames: vec![frame; self.frames], backend: "bench".to_owned() }
    }
}

impl FrameSource for Loop {
    fn frame_count(&self) -> usize {
        self.frames
    }

    fn size(&self) -> Size {
        SIZE
    }

    fn frame(&self, index: FrameIndex) -> Result<Rgb8, FrameError> {
        Ok(self.pictures[index.as_usize() % self.pictures.len()].clone())
    }
}

/// Notes when the warm-up is over, what processor time this thread had used and how much memory there was. Processor time,
/// because other programs may run.
#[derive(Default)]
struct Meter {
    warm: Mutex<Option<(usize, f64, f64)>>,
}

impl Watch for Meter {
    fn advance(&self, done: usize, _total: usize) {
        if done >= WARM {
            self.warm.lock().unwrap().get_or_insert_with(|| (done, processor_ms(), resident_mib()));
        }
    }

    fn is_cancelled(&self) -> bool {
        false
    }
}

impl Meter {
    /// `graphs_ms` is what the graphs alone take a frame: copying what they return, mostly.
    fn print(&self, what: &str, frames: usize, graphs_ms: f64, limit_ms: Option<f64>) {
        let now = resident_mib();
        let Some((from, start, before)) = *self.warm.lock().unwrap() else {
            println!("{what}: too few frames");
            return;
        };
        let each = (processor_ms() - start) / (frames - from).max(1) as f64;
        let limit = limit_ms.map_or(String::new(), |limit| format!(", at most {limit} wanted"));
        let host = each - graphs_ms;
        println!(
            "{what:<30} {host:5.2} ms a frame ({each:.2} with idle graphs{limit}), memory {before:.0} MiB after {from} frames, \
             {now:.0} MiB after {frames}"
        );
    }
}

/// Of the calling thread; graphs run on it and on threads of their own.
fn processor_ms() -> f64 {
    let times = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let on_processor: f64 = times.split_whitespace().next().and_then(|time| time.parse().ok()).unwrap_or(0.0);
    on_processor / 1e6
}

/// Processor time of one call of a graph by itself.
fn graph_ms(runtime: &Runtime, model: &CheckedModel, spec: &GraphSpec, fed: &[(&'static str, Value)]) -> f64 {
    let mut graph =
        Graph::open(runtime, model.file(spec.name).unwrap(), spec, &mut Sizes::default()).unwrap();
    let fed: Vec<(&'static str, &Value)> = fed.iter().map(|(name, value)| (*name, value)).collect();
    let (calls, mut start) = (100, 0.0);
    for call in 0..2 * calls {
        if call == calls {
            start = processor_ms();
        }
        graph.run(&fed).unwrap();
    }
    (processor_ms() - start) / f64::from(calls)
}

fn zeros(shape: &[i64]) -> Value {
    let shape: Vec<usize> = shape.iter().map(|size| *size as usize).collect();
    Value::floats(&shape, vec![0.0; shape.iter().product()]).unwrap()
}

fn resident_mib() -> f64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages: f64 = pages.split_whitespace().nth(1).and_then(|pages| pages.parse().ok()).unwrap_or(0.0);
    pages * 4096.0 / f64::from(1 << 20)
}

/// A graph that returns the same whatever it is fed.
fn idle(inputs: &[(&str, Element, &[i64])], outputs: &[(&str, &[i64])]) -> Vec<u8> {
    let mut writer = GraphWriter::new();
    for (name, element, shape) in inputs {
        writer = writer.input(name, *element, shape);
    }
    for (name, shape) in outputs {
        let (same, values) = (format!("{name}_same"), values_of(name, shape));
        writer =
            writer.floats(&same, shape, &values).node("Identity", &[&same], name, &[]).output(name, F, shape);
    }
    writer.bytes()
}

/// An object in the middle of masks, a hand at arm's length, zeros elsewhere.
fn values_of(name: &str, shape: &[i64]) -> Vec<f32> {
    let count: i64 = shape.iter().product();
    let side = shape.last().copied().unwrap_or(1);
    let value = |at: i64| match name {
        "low_res_multimasks" => {
            let (x, y) = (at % side, at / side % side);
            if (x - side / 2).pow(2) + (y - side / 2).pow(2) < (side / 5).pow(2) { 9.0 } else { -9.0 }
        }
        "object_score_logits" | "ious" => 1.0,
        // No turn.
        "global_orient" | "hand_pose" if at % 9 % 4 == 0 => 1.0,
        "pred_cam" => [5.0, 0.0, 0.0][at as usize],
        "pred_keypoints_3d" => 0.002 * (at % 40) as f32,
        _ => 0.0,
    };
    (0..count).map(value).collect()
}

fn model(root: &Path, contract: &Contract, more: &str, graphs: &[(&str, Vec<u8>)]) -> CheckedModel {
    let folder = root.join(contract.id.replace('/', "-"));
    std::fs::create_dir_all(&folder).unwrap();
    let description = format!("contract = \"{}\"\nname = \"idle\"\nlicence = \"MIT\"\n{more}", contract.id);
    std::fs::write(folder.join("model.toml"), description).unwrap();
    for (name, bytes) in graphs {
        std::fs::write(folder.join(format!("{name}.onnx")), bytes).unwrap();
    }
    let registry = Registry::default();
    let found = ModelFolder::find(&[folder]).remove(0).unwrap();
    found.checked(contract.graphs, Trust { registry: &registry, unlisted: true }).unwrap()
}

fn sam2(root: &Path) -> CheckedModel {
    let (q, e, t) = (S / 4, S / 8, S / 16);
    let hw = t * t;
    let map: &[i64] = &[1, 256, t, t];
    let tokens: &[i64] = &[hw, 1, 256];
    let memory: &[i64] = &[hw, -1, 1, 64];
    let high: [&[i64]; 2] = [&[1, 32, q, q], &[1, 64, e, e]];
    let encoder = idle(
        &[("image", F, &[1, S, S, 3])],
        &[
            ("high_res_features0", high[0]),
            ("high_res_features1", high[1]),
            ("low_res_features", tokens),
            ("vision_pos_embeds", tokens),
            ("pix_feat_with_mem", map),
        ],
    );
    let attention = idle(
        &[
            ("current_vision_feats", F, tokens),
            ("current_vision_pos_embeds", F, tokens),
            ("maskmem_feats", F, memory),
            ("memory_pos_embed", F, memory),
            ("obj_ptrs", F, &[-1, 1, 256]),
            ("obj_pos", Element::I32, &[-1]),
        ],
        &[("pix_feat_with_mem", map)],
    );
    let decoder = idle(
        &[
            ("point_coords", F, &[1, 2, 2]),
            ("point_labels", Element::I32, &[1, 2]),
            ("pix_feat_with_mem", F, map),
            ("high_res_features_0", F, high[0]),
            ("high_res_features_1", F, high[1]),
        ],
        &[
            ("low_res_multimasks", &[1, 3, q, q]),
            ("ious", &[1, 3]),
            ("obj_ptr", &[1, 3, 256]),
            ("object_score_logits", &[1, 1]),
            ("maskmem_tpos_enc", &[7, 1, 1, 64]),
        ],
    );
    let memory_encoder = idle(
        &[
            ("pix_feat", F, tokens),
            ("mask_for_mem", F, &[1, 1, S, S]),
            ("object_score_logits", F, &[1, 1]),
            ("is_mask_from_pts", Element::Bool, &[]),
        ],
        &[("maskmem_features", &[hw, 1, 64]), ("maskmem_pos_enc", &[hw, 1, 64])],
    );
    let graphs = [
        ("image_encoder", encoder),
        ("memory_attention", attention),
        ("mask_decoder", decoder),
        ("memory_encoder", memory_encoder),
    ];
    model(root, &SAM2_VIDEO, "", &graphs)
}

fn sam2_graphs_ms(runtime: &Runtime, model: &CheckedModel) -> f64 {
    let (q, e, t) = (S / 4, S / 8, S / 16);
    let (hw, map) = (t * t, [1, 256, t, t]);
    let (tokens, memory) = ([hw, 1, 256], [hw, 7, 1, 64]);
    let numbers =
        |shape: &[usize], number| Value::integers(shape, vec![number; shape.iter().product()]).unwrap();
    let fed = [
        vec![("image", zeros(&[1, S, S, 3]))],
        vec![
            ("current_vision_feats", zeros(&tokens)),
            ("current_vision_pos_embeds", zeros(&tokens)),
            ("maskmem_feats", zeros(&memory)),
            ("memory_pos_embed", zeros(&memory)),
            ("obj_ptrs", zeros(&[16, 1, 256])),
            ("obj_pos", numbers(&[16], 1)),
        ],
        vec![
            ("point_coords", zeros(&[1, 2, 2])),
            ("point_labels", numbers(&[1, 2], -1)),
            ("pix_feat_with_mem", zeros(&map)),
            ("high_res_features_0", zeros(&[1, 32, q, q])),
            ("high_res_features_1", zeros(&[1, 64, e, e])),
        ],
        vec![
            ("pix_feat", zeros(&tokens)),
            ("mask_for_mem", zeros(&[1, 1, S, S])),
            ("object_score_logits", zeros(&[1, 1])),
            ("is_mask_from_pts", Value::flag(false).unwrap()),
        ],
    ];
    SAM2_VIDEO.graphs.iter().zip(&fed).map(|(spec, fed)| graph_ms(runtime, model, spec, fed)).sum()
}

fn measure_sam2(runtime: &Runtime, root: &Path, frames: usize) {
    let checked = sam2(root);
    let mut network = VideoSegmenter::open(runtime, &checked).unwrap();
    let bounds = PixelBox { x0: 200.0, y0: 150.0, x1: 400.0, y1: 330.0 };
    let prompt = ObjectPrompt::new(FrameIndex(0), PromptKind::Box(bounds));
    let meter = Meter::default();
    let mut no_mask = |_: &ObjectPrompt| unreachable!("a box is no mask");
    track_object(&Loop::new(frames), &[prompt], &mut network, &mut no_mask, None, &meter).unwrap();
    meter.print("object masks (SAM 2, S = 512)", frames, sam2_graphs_ms(runtime, &checked), Some(5.0));
}

fn measure_background(runtime: &Runtime, root: &Path, frames: usize) {
    let graph = idle(&[("masked_frames", F, &[1, 17, 3, 240, 432])], &[("pred_frames", &[11, 3, 240, 432])]);
    let checked = model(root, &VIDEO_INPAINT, "[sizes]\nL = 11\nR = 6\n", &[("video_inpaint", graph)]);
    let mut network = VideoNetwork::open(runtime, &checked).unwrap();
    let clip = Loop::new(frames);
    let arms = clip.masks(|x, y| x > 380 && y > 200 && x + y > 700);
    let object = clip.masks(|x, y| (300..420).contains(&x) && (180..300).contains(&y));
    let meter = Meter::default();
    let mut sink = |_: FrameIndex, _: &Rgb8| Ok(());
    let (params, pair) = (InpaintParams::default(), (&mut network, Blend::default()));
    clean_by_network(&clip, (&arms, &object), &params, pair, &mut sink, &meter).unwrap();
    // A window restores five frames more.
    let fed = [("masked_frames", zeros(&[1, 17, 3, 240, 432]))];
    let graph = graph_ms(runtime, &checked, &VIDEO_INPAINT.graphs[0], &fed);
    meter.print("background (432×240)", frames, graph / 5.0, Some(10.0));
}

fn measure_hands(runtime: &Runtime, root: &Path, frames: usize) {
    let detector = idle(&[("images", F, &[1, 3, 640, 640])], &[("output0", &[1, 69, 8400])]);
    let regressor = idle(
        &[("img", F, &[1, 3, 256, 256])],
        &[
            ("pred_cam", &[1, 3]),
            ("pred_keypoints_3d", &[1, 21, 3]),
            ("global_orient", &[1, 1, 3, 3]),
            ("hand_pose", &[1, 15, 3, 3]),
        ],
    );
    let graphs = [("hand_detector", detector), ("hand_regressor", regressor)];
    let checked = model(root, &HAND_POSE, "", &graphs);
    let mut network = HandNetwork::open(runtime, &checked).unwrap();
    let fed = [[("images", zeros(&[1, 3, 640, 640]))], [("img", zeros(&[1, 3, 256, 256]))]];
    let graphs: Vec<f64> =
        (0..2).map(|at| graph_ms(runtime, &checked, &HAND_POSE.graphs[at], &fed[at])).collect();
    let camera = Pinhole::from_horizontal_fov(60.0, SIZE).unwrap();
    let clip = Loop::new(frames);
    let bounds = PixelBox { x0: 250.0, y0: 150.0, x1: 390.0, y1: 330.0 };
    let (crops, boxes) = (Meter::default(), Meter::default());
    let pictures: Vec<_> = clip.pictures.iter().map(|picture| picture.to_mat().unwrap()).collect();
    for frame in 0..frames {
        let side = if frame % 2 == 0 { Side::Left } else { Side::Right };
        let crop = network.crop(&bounds, side);
        let said = network.regress(&pictures[frame % pictures.len()], &crop).unwrap();
        assert!(said.placed(&crop, &camera).is_some());
        crops.advance(frame + 1, frames);
    }
    crops.print("a hand's crop and its place", frames, graphs[1], Some(2.0));
    for frame in 0..frames {
        network.detect(&pictures[frame % pictures.len()]).unwrap();
        boxes.advance(frame + 1, frames);
    }
    boxes.print("a detector's picture and boxes", frames, graphs[0], None);
}

fn main() {
    let frames = std::env::args().nth(1).and_then(|frames| frames.parse().ok()).unwrap_or(2000_usize);
    single_threaded();
    let library =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(".deps/onnxruntime/libonnxruntime.so.1.31.1");
    let runtime = Runtime::load(&library, RuntimeOptions::default()).unwrap();
    let root = tempfile::tempdir().unwrap();
    measure_sam2(&runtime, root.path(), frames);
    measure_background(&runtime, root.path(), frames);
    measure_hands(&runtime, root.path(), frames);
}
