//! A mask on one picture from any number of points, or a box.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual};

use super::{
    image_contract::SAM2_IMAGE,
    logits::{mask_of, square, without_specks},
    picture::{side_of, squared},
};
use crate::{
    clip::FrameSource,
    geometry::{Pixel, Size},
    onnx::{CheckedModel, Graph, OnnxError, Runtime, Sizes, Value},
    segment::{
        RleMask, SegmentError,
        object::{ObjectPrompt, PromptKind},
    },
};

/// ImageNet's mean and deviation of red, green and blue, from 0 to 1.
const MEAN: [f32; 3] = [0.485, 0.456, 0.406];
const DEVIATION: [f32; 3] = [0.229, 0.224, 0.225];

/// A picture as the network sees it.
#[derive(Debug)]
pub struct EncodedPicture {
    features: [Value; 3],
    size: Size,
}

/// The loaded graphs.
#[derive(Debug)]
pub struct ImageSegmenter {
    encoder: Graph,
    decoder: Graph,
    side: usize,
    name: String,
}

/// What a point means to the decoder.
const ON: i64 = 1;
const BESIDE: i64 = 0;
const CORNERS: [i64; 2] = [2, 3];

impl ImageSegmenter {
    /// Loads the graphs of `model`.
    ///
    /// # Errors
    /// When they are not such graphs, or their sizes contradict each other.
    pub fn open(runtime: &Runtime, model: &CheckedModel) -> Result<Self, OnnxError> {
        let mut sizes = Sizes::default();
        let mut open = |at: usize| {
            let spec = &SAM2_IMAGE.graphs[at];
            Graph::open(runtime, model.file(spec.name)?, spec, &mut sizes)
        };
        let (encoder, decoder) = (open(0)?, open(1)?);
        let side = side_of(model, &sizes)?;
        Ok(Self { encoder, decoder, side, name: model.description().name.clone() })
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Encodes a picture: CV_8UC3, RGB, any size; its aspect is not kept.
    ///
    /// # Errors
    /// When OpenCV or the graph fails.
    pub fn encode(&mut self, picture: &Mat) -> Result<EncodedPicture, SegmentError> {
        let small = squared(picture, self.side)?;
        let pixels = small.data_bytes()?;
        let mut planes = Vec::with_capacity(pixels.len());
        for channel in 0..3 {
            let values = pixels.iter().skip(channel).step_by(3);
            planes
                .extend(values.map(|value| (f32::from(*value) / 255.0 - MEAN[channel]) / DEVIATION[channel]));
        }
        let image = Value::floats(&[1, 3, self.side, self.side], planes)?;
        let mut out = self.encoder.run(&[("image", &image)])?;
        let features =
            [out.take("image_embed")?, out.take("high_res_feats_0")?, out.take("high_res_feats_1")?];
        let size = Size::new(picture.cols().max(0) as u32, picture.rows().max(0) as u32);
        Ok(EncodedPicture { features, size })
    }

    /// The mask of what `kind` points at.
    ///
    /// # Errors
    /// When `kind` points at nothing, or OpenCV or the graph fails.
    pub fn mask(&mut self, seen: &EncodedPicture, prompt: &ObjectPrompt) -> Result<RleMask, SegmentError> {
        let (points, labels) = self.points(seen.size, &prompt.kind);
        if labels.is_empty() {
            let reason = "it points at nothing".to_owned();
            return Err(SegmentError::Prompt { frame: prompt.frame, reason });
        }
        let low = self.side / 4;
        let points = Value::floats(&[1, labels.len(), 2], points)?;
        let labels = Value::integers(&[1, labels.len()], labels)?;
        let before = Value::floats(&[1, 1, low, low], vec![0.0; low * low])?;
        let no_mask = Value::floats(&[1], vec![0.0])?;
        let size = [seen.size.height, seen.size.width].map(i64::from).to_vec();
        let size = Value::integers(&[2], size)?;
        let no_boxes = Value::no_floats(&[1, 0, 4])?;
        let [embedding, high_0, high_1] = &seen.features;
        let out = self.decoder.run(&[
            ("image_embed", embedding),
            ("high_res_feats_0", high_0),
            ("high_res_feats_1", high_1),
            ("point_coords", &points),
            ("point_labels", &labels),
            ("mask_input", &before),
            ("has_mask_input", &no_mask),
            ("original_image_size", &size),
            ("input_boxes", &no_boxes),
        ])?;
        let fits = out.floats("iou_predictions")?;
        let best = (0..fits.len()).max_by(|a, b| fits[*a].total_cmp(&fits[*b])).unwrap_or(0);
        let logits = out.floats("low_res_masks")?.get(best * low * low..(best + 1) * low * low);
        let logits = logits.ok_or_else(|| OnnxError::Run {
            graph: "decoder",
            reason: format!("returned {} fits but fewer masks", fits.len()),
        })?;
        let cleaned = without_specks(&square(logits, low)?)?;
        Ok(RleMask::encode(&mask_of(&cleaned, seen.size)?))
    }

    /// Points in pixels of the network's picture, and what each means.
    fn points(&self, size: Size, kind: &PromptKind) -> (Vec<f32>, Vec<i64>) {
        let marked: Vec<(Pixel, i64)> = match kind {
            PromptKind::Box(bounds) => {
                let corners = [Pixel::new(bounds.x0, bounds.y0), Pixel::new(bounds.x1, bounds.y1)];
                corners.into_iter().zip(CORNERS).collect()
            }
            PromptKind::Points { positive, negative } => {
                let marked = |points: &[Pixel], label| points.iter().map(|p| (*p, label)).collect::<Vec<_>>();
                [marked(positive, ON), marked(negative, BESIDE)].concat()
            }
            PromptKind::Mask { .. } => Vec::new(),
        };
        let side = self.side as f64;
        let (x, y) = (side / f64::from(size.width.max(1)), side / f64::from(size.height.max(1)));
        let pixels = marked.iter().flat_map(|(pixel, _)| [(pixel.x * x) as f32, (pixel.y * y) as f32]);
        (pixels.collect(), marked.iter().map(|(_, label)| *label).collect())
    }
}

/// The mask that a prompt means on its own frame.
///
/// # Errors
/// When the frame cannot be read, the prompt points at nothing, or the network fails.
pub fn segment_frame(
    frames: &dyn FrameSource,
    prompt: &ObjectPrompt,
    network: &mut ImageSegmenter,
) -> Result<RleMask, SegmentError> {
    let seen = network.encode(&frames.frame(prompt.frame)?.to_mat()?)?;
    network.mask(&seen, prompt)
}
