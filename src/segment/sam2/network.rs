//! The four graphs of a video segmenter, one call each.

use opencv::core::{Mat, MatTraitConstManual};

use super::{
    contract::SAM2_VIDEO,
    logits::enlarged,
    picture::{side_of, squared},
};
use crate::{
    onnx::{CheckedModel, Graph, OnnxError, Runtime, Sizes, Value},
    segment::SegmentError,
};

/// Width of an object pointer.
const POINTER: usize = 256;
/// Width of a memory token.
const TOKEN: usize = 64;

/// A picture as the network sees it.
#[derive(Debug)]
pub struct Encoded {
    high: [Value; 2],
    low: Value,
    positions: Value,
    alone: Value,
}

/// A mask as the decoder gives it.
#[derive(Debug)]
pub struct Decoded {
    /// CV_32FC1 logits, S/4 × S/4.
    pub logits: Mat,
    /// How well the mask fits, by the decoder's own word, 0 to 1.
    pub fit: f32,
    /// Above zero where the object is there.
    pub presence: f32,
    pub(super) pointer: Vec<f32>,
    pub(super) times: Vec<f32>,
}

/// What is remembered of a frame.
#[derive(Debug)]
pub struct Memory {
    tokens: Vec<f32>,
    positions: Vec<f32>,
    pointer: Vec<f32>,
    times: Vec<f32>,
}

/// A prompt in pixels of the network's picture: two points with labels 1 on the object, 0 beside it, 2 and 3 a box's
/// corners, -1 none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoPoints {
    /// x and y of each.
    pub points: [[f32; 2]; 2],
    /// What each means.
    pub labels: [i64; 2],
}

impl TwoPoints {
    /// Nothing is pointed at.
    pub const NONE: Self = Self { points: [[0.0; 2]; 2], labels: [-1; 2] };
}

/// The loaded graphs.
#[derive(Debug)]
pub struct VideoSegmenter {
    encoder: Graph,
    attention: Graph,
    decoder: Graph,
    memory_encoder: Graph,
    side: usize,
    name: String,
}

impl VideoSegmenter {
    /// Loads the graphs of `model`.
    ///
    /// # Errors
    /// When they are not such graphs, or their sizes contradict each other.
    pub fn open(runtime: &Runtime, model: &CheckedModel) -> Result<Self, OnnxError> {
        let mut sizes = Sizes::default();
        let mut open = |at: usize| {
            let spec = &SAM2_VIDEO.graphs[at];
            Graph::open(runtime, model.file(spec.name)?, spec, &mut sizes)
        };
        let (encoder, attention, decoder, memory_encoder) = (open(0)?, open(1)?, open(2)?, open(3)?);
        let side = side_of(model, &sizes)?;
        let name = model.description().name.clone();
        Ok(Self { encoder, attention, decoder, memory_encoder, side, name })
    }

    /// Side of the network's picture, pixels.
    pub fn side(&self) -> usize {
        self.side
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Encodes a picture: CV_8UC3, RGB, any size; its aspect is not kept.
    ///
    /// # Errors
    /// When OpenCV or the graph fails.
    pub fn encode(&mut self, picture: &Mat) -> Result<Encoded, SegmentError> {
        let square = squared(picture, self.side)?;
        let values = square.data_bytes()?.iter().map(|value| f32::from(*value)).collect();
        let image = Value::floats(&[1, self.side, self.side, 3], values)?;
        let mut out = self.encoder.run(&[("image", &image)])?;
        Ok(Encoded {
            high: [out.take("high_res_features0")?, out.take("high_res_features1")?],
            low: out.take("low_res_features")?,
            positions: out.take("vision_pos_embeds")?,
            alone: out.take("pix_feat_with_mem")?,
        })
    }

    /// The mask that a prompt means, without any memory.
    ///
    /// # Errors
    /// When a graph fails.
    pub fn decode_prompt(&mut self, seen: &Encoded, prompt: TwoPoints) -> Result<Decoded, SegmentError> {
        decode(&mut self.decoder, self.side, seen, &seen.alone, prompt)
    }

    /// The mask that memories mean: each with the row of the time encoding, pointers with their distance in frames.
    ///
    /// # Errors
    /// When a graph fails.
    pub fn decode_remembered(
        &mut self,
        seen: &Encoded,
        masks: &[(&Memory, usize)],
        pointers: &[(&Memory, usize)],
    ) -> Result<Decoded, SegmentError> {
        let tokens = (self.side / 16).pow(2);
        let (mut features, mut positions) = (Vec::new(), Vec::new());
        for (memory, row) in masks {
            features.extend_from_slice(&memory.tokens);
            let time = memory.times.get(row * TOKEN..(row + 1) * TOKEN).unwrap_or(&[0.0; TOKEN]);
            for token in memory.positions.chunks(TOKEN) {
                positions.extend(token.iter().zip(time).map(|(at, time)| at + time));
            }
        }
        let shape = [tokens, masks.len(), 1, TOKEN];
        let objects = pointers.iter().flat_map(|(memory, _)| memory.pointer.iter().copied()).collect();
        let distances = pointers.iter().map(|(_, steps)| *steps as i64).collect();
        let (features, positions) = (Value::floats(&shape, features)?, Value::floats(&shape, positions)?);
        let objects = Value::floats(&[pointers.len(), 1, POINTER], objects)?;
        let distances = Value::integers(&[pointers.len()], distances)?;
        let mut out = self.attention.run(&[
            ("current_vision_feats", &seen.low),
            ("current_vision_pos_embeds", &seen.positions),
            ("maskmem_feats", &features),
            ("memory_pos_embed", &positions),
            ("obj_ptrs", &objects),
            ("obj_pos", &distances),
        ])?;
        let map = out.take("pix_feat_with_mem")?;
        decode(&mut self.decoder, self.side, seen, &map, TwoPoints::NONE)
    }

    /// Remembers a frame by `logits` (any size, square); `prompted` where they came from points or a box.
    ///
    /// # Errors
    /// When OpenCV or a graph fails.
    pub fn remember(
        &mut self,
        seen: &Encoded,
        decoded: &Decoded,
        logits: &Mat,
        prompted: bool,
    ) -> Result<Memory, SegmentError> {
        let full = enlarged(logits, self.side, self.side)?;
        let mask = Value::floats(&[1, 1, self.side, self.side], full.data_typed::<f32>()?.to_vec())?;
        let presence = Value::floats(&[1, 1], vec![decoded.presence])?;
        let flag = Value::flag(prompted)?;
        let out = self.memory_encoder.run(&[
            ("pix_feat", &seen.low),
            ("mask_for_mem", &mask),
            ("object_score_logits", &presence),
            ("is_mask_from_pts", &flag),
        ])?;
        Ok(Memory {
            tokens: out.floats("maskmem_features")?.to_vec(),
            positions: out.floats("maskmem_pos_enc")?.to_vec(),
            pointer: decoded.pointer.clone(),
            times: decoded.times.clone(),
        })
    }
}

fn decode(
    decoder: &mut Graph,
    side: usize,
    seen: &Encoded,
    map: &Value,
    prompt: TwoPoints,
) -> Result<Decoded, SegmentError> {
    let points = Value::floats(&[1, 2, 2], prompt.points.as_flattened().to_vec())?;
    let labels = Value::integers(&[1, 2], prompt.labels.to_vec())?;
    let out = decoder.run(&[
        ("point_coords", &points),
        ("point_labels", &labels),
        ("pix_feat_with_mem", map),
        ("high_res_features_0", &seen.high[0]),
        ("high_res_features_1", &seen.high[1]),
    ])?;
    let fits = out.floats("ious")?;
    let best = (0..fits.len()).max_by(|a, b| fits[*a].total_cmp(&fits[*b])).unwrap_or(0);
    let low = side / 4;
    let part = |name: &'static str, size: usize| -> Result<&[f32], OnnxError> {
        out.floats(name)?.get(best * size..(best + 1) * size).ok_or_else(|| OnnxError::Run {
            graph: "mask_decoder",
            reason: format!("`{name}` holds fewer than {} numbers", (best + 1) * size),
        })
    };
    Ok(Decoded {
        logits: super::logits::square(part("low_res_multimasks", low * low)?, low)?,
        fit: fits.get(best).copied().unwrap_or(0.0),
        presence: out.floats("object_score_logits")?.first().copied().unwrap_or(0.0),
        pointer: part("obj_ptr", POINTER)?.to_vec(),
        times: out.floats("maskmem_tpos_enc")?.to_vec(),
    })
}
