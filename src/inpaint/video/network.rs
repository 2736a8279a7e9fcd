//! The loaded network.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual};

use super::{
    contract::{VIDEO_INPAINT, VideoParameters},
    fit::Fit,
    windows::{WindowSize, WindowSteps},
};
use crate::{
    geometry::Size,
    inpaint::InpaintError,
    onnx::{CheckedModel, Graph, OnnxError, Runtime, Sizes, Value},
};

/// Sides of E2FGVI's pictures are multiples of these.
const MULTIPLE: Size = Size { width: 108, height: 60 };
/// Frames of a window where neither graph nor description says: the published neighbourhood, and six references.
const DEFAULT_WINDOW: WindowSize = WindowSize::Fixed { local: 11, references: 6 };

/// A frame as the network takes it.
#[derive(Debug)]
pub struct NetworkFrame {
    /// CV_8UC3, RGB, the network's size.
    pub picture: Mat,
    /// CV_8UC1, the network's size: what is taken out.
    pub hole: Mat,
}

/// A network that restores what is taken out of a few frames at once.
#[derive(Debug)]
pub struct VideoNetwork {
    graph: Graph,
    name: String,
    size: Option<Size>,
    window: WindowSize,
    steps: WindowSteps,
}

impl VideoNetwork {
    /// Loads the network of `model`.
    ///
    /// # Errors
    /// When it is no such network, or its sizes contradict each other.
    pub fn open(runtime: &Runtime, model: &CheckedModel) -> Result<Self, OnnxError> {
        let parameters: VideoParameters = model.parameters()?;
        let spec = &VIDEO_INPAINT.graphs[0];
        let mut sizes = Sizes::default();
        let graph = Graph::open(runtime, model.file(spec.name)?, spec, &mut sizes)?;
        let said = |symbol| model.size(&sizes, symbol).ok();
        let size = match (said("W"), said("H")) {
            (Some(width), Some(height)) => {
                let size = Size::new(width as u32, height as u32);
                if Fit::padded_size(size, MULTIPLE) != size {
                    return Err(model.wrong(format!(
                        "pictures of {size}: width and height must be multiples of {} and {}",
                        MULTIPLE.width, MULTIPLE.height
                    )));
                }
                Some(size)
            }
            _ => None,
        };
        let window = match (said("L"), said("R"), said("T")) {
            (Some(local), Some(references), Some(all)) if local + references != all => {
                return Err(model.wrong(format!(
                    "L = {local} local and R = {references} reference frames, but the graph takes {all}"
                )));
            }
            (Some(local), Some(references), _) => WindowSize::Fixed { local, references },
            (Some(local), None, Some(all)) if all >= local => {
                WindowSize::Fixed { local, references: all - local }
            }
            (None, None, None) => DEFAULT_WINDOW,
            _ => {
                let missing = "say under [sizes] how many local (L) and reference (R) frames the graph takes";
                return Err(model.wrong(missing.to_owned()));
            }
        };
        if matches!(window, WindowSize::Fixed { local: 0, .. }) {
            return Err(model.wrong("L = 0: a window needs a frame".to_owned()));
        }
        let steps =
            WindowSteps { stride: parameters.neighbor_stride.max(1), reference: parameters.ref_step.max(1) };
        Ok(Self { graph, name: model.description().name.clone(), size, window, steps })
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How frames of a clip lie in its pictures.
    pub fn fit(&self, clip: Size) -> Fit {
        Fit::new(clip, self.size.unwrap_or_else(|| Fit::padded_size(clip, MULTIPLE)))
    }

    /// Frames of a window.
    pub fn window(&self) -> WindowSize {
        self.window
    }

    /// Distances between windows and references.
    pub fn steps(&self) -> WindowSteps {
        self.steps
    }

    /// The pictures of `frames`, of which the first `local` count, without their holes: RGB planes, -1 to 1, one
    /// after the other.
    ///
    /// # Errors
    /// When the graph fails or returns too few pictures.
    pub fn restore(&mut self, frames: &[&NetworkFrame], local: usize) -> Result<Vec<f32>, InpaintError> {
        let outer = frames.first().map_or(Size::new(0, 0), |frame| {
            Size::new(frame.picture.cols() as u32, frame.picture.rows() as u32)
        });
        let plane = outer.width as usize * outer.height as usize;
        let mut packed = Vec::with_capacity(frames.len() * 3 * plane);
        for frame in frames {
            pack(frame, &mut packed)?;
        }
        let shape = [1, frames.len(), 3, outer.height as usize, outer.width as usize];
        let masked = Value::floats(&shape, packed)?;
        let outputs = self.graph.run(&[("masked_frames", &masked)])?;
        let restored = outputs.floats("pred_frames")?;
        let wanted = local * 3 * plane;
        match restored.get(..wanted) {
            Some(local) => Ok(local.to_vec()),
            None => Err(OnnxError::Run {
                graph: VIDEO_INPAINT.id,
                reason: format!("returned {} numbers, {local} frames have {wanted}", restored.len()),
            }
            .into()),
        }
    }
}

/// RGB planes from -1 to 1, 0 in the hole.
fn pack(frame: &NetworkFrame, packed: &mut Vec<f32>) -> opencv::Result<()> {
    let (pixels, hole) = (frame.picture.data_bytes()?, frame.hole.data_bytes()?);
    for channel in 0..3 {
        let values = pixels.iter().skip(channel).step_by(3).zip(hole);
        packed.extend(values.map(
            |(value, hole)| {
                if *hole == 0 { f32::from(*value) / 255.0 * 2.0 - 1.0 } else { 0.0 }
            },
        ));
    }
    Ok(())
}
