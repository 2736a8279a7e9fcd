//! The two loaded graphs.

use nalgebra::Vector3;
use opencv::core::{Mat, MatTraitConst};

use super::{
    boxes::{HandBox, hands_in, without_doubles},
    contract::{HAND_POSE, HandParameters},
    crop::{Crop, CropPixels},
    letterbox::Letterbox,
    place::HandPrediction,
    rotation::rotations,
};
use crate::{
    geometry::{PixelBox, Side, Size},
    hands::HandsError,
    onnx::{
        ChannelOrder, CheckedModel, Graph, Layout, Normalisation, OnnxError, Outputs, Runtime, Sizes, Value,
    },
};

/// Side of the detector's picture where neither graph nor description says it.
const USUAL_SIDE: usize = 640;
/// Largest side that a description may ask for.
const LARGEST_SIDE: usize = 4096;

/// A network that finds hands and their poses.
#[derive(Debug)]
pub struct HandNetwork {
    detector: Graph,
    regressor: Graph,
    side: usize,
    pixels: CropPixels,
    parameters: HandParameters,
    name: String,
}

impl HandNetwork {
    /// Loads the graphs of `model`.
    ///
    /// # Errors
    /// When they are not such graphs, or the description contradicts them.
    pub fn open(runtime: &Runtime, model: &CheckedModel) -> Result<Self, OnnxError> {
        let parameters: HandParameters = model.parameters()?;
        if let Some(fault) = parameters.fault() {
            return Err(model.wrong(fault));
        }
        let mut sizes = Sizes::default();
        let mut open = |at: usize| {
            let spec = &HAND_POSE.graphs[at];
            Graph::open(runtime, model.file(spec.name)?, spec, &mut sizes)
        };
        let (detector, regressor) = (open(0)?, open(1)?);
        let side = model.size(&sizes, "N").unwrap_or(USUAL_SIDE);
        if !(32..=LARGEST_SIDE).contains(&side) {
            return Err(model.wrong(format!("N = {side}: 32 to {LARGEST_SIDE} expected")));
        }
        let said = model.description().picture;
        let declared = regressor.declared("img").and_then(layout_of);
        if let (Some(said), Some(declared)) = (said.layout, declared)
            && said != declared
        {
            return Err(
                model.wrong(format!("[picture] layout is {said:?}, the graph's `img` is {declared:?}"))
            );
        }
        let pixels = CropPixels {
            layout: declared.or(said.layout).unwrap_or(Layout::Nchw),
            colour: said.colour.unwrap_or(ChannelOrder::Rgb),
            normalisation: said.normalisation.unwrap_or(Normalisation::ImageNet),
        };
        Ok(Self { detector, regressor, side, pixels, parameters, name: model.description().name.clone() })
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The hands in a picture: CV_8UC3, RGB, any size. The surest first.
    ///
    /// # Errors
    /// When OpenCV or the detector fails.
    pub fn detect(&mut self, picture: &Mat) -> Result<Vec<HandBox>, HandsError> {
        let size = Size::new(picture.cols().max(0) as u32, picture.rows().max(0) as u32);
        let letterbox = Letterbox::new(size, self.side as u32);
        let square = letterbox.draw(picture)?;
        let rgb = CropPixels {
            layout: Layout::Nchw,
            colour: ChannelOrder::Rgb,
            normalisation: Normalisation::Unit,
        };
        let images = Value::floats(&[1, 3, self.side, self.side], rgb.numbers(&square)?)?;
        let out = self.detector.run(&[("images", &images)])?;
        let shape = out.shape("output0").unwrap_or_default();
        let found = hands_in(out.floats("output0")?, &shape, self.parameters.confidence)
            .map_err(|reason| OnnxError::Run { graph: "hand_detector", reason })?;
        let back = |hand: HandBox| HandBox { bounds: letterbox.back(hand.bounds), ..hand };
        let kept = without_doubles(found, self.parameters.overlap);
        Ok(kept.into_iter().map(back).collect())
    }

    /// The square around a hand that the regressor is to see.
    pub fn crop(&self, bounds: &PixelBox, hand: Side) -> Crop {
        Crop::around(bounds, hand, self.parameters.box_rule, self.parameters.rescale())
    }

    /// What is said of the hand in `crop` of a picture: CV_8UC3, RGB.
    ///
    /// # Errors
    /// When OpenCV or the regressor fails.
    pub fn regress(&mut self, picture: &Mat, crop: &Crop) -> Result<HandPrediction, HandsError> {
        let numbers = self.pixels.numbers(&crop.draw(picture)?)?;
        let img = Value::floats(&self.pixels.shape(), numbers)?;
        let out = self.regressor.run(&[("img", &img)])?;
        Ok(self.prediction(&out)?)
    }

    fn prediction(&self, out: &Outputs) -> Result<HandPrediction, OnnxError> {
        let few =
            |name: &str| OnnxError::Run { graph: "hand_regressor", reason: format!("`{name}` is too short") };
        let camera = out.floats("pred_cam")?.first_chunk::<3>().ok_or_else(|| few("pred_cam"))?;
        let given =
            out.floats("pred_keypoints_3d")?.first_chunk::<63>().ok_or_else(|| few("pred_keypoints_3d"))?;
        let place = |at: usize| {
            let [x, y, z] = [given[3 * at], given[3 * at + 1], given[3 * at + 2]].map(f64::from);
            Vector3::new(x, y, z)
        };
        let of = |name: &'static str| {
            if out.shape(name).is_some() { out.floats(name).map(Some) } else { Ok(None) }
        };
        let kind = self.parameters.rotations;
        let orientation = of("global_orient")?.and_then(|numbers| rotations(numbers, 1, kind));
        let fingers = of("hand_pose")?.and_then(|numbers| rotations(numbers, 15, kind));
        let fingers = fingers.and_then(|fingers| fingers.try_into().ok());
        let shape = of("betas")?.and_then(|numbers| numbers.first_chunk::<10>());
        Ok(HandPrediction {
            camera: camera.map(f64::from),
            joints: self.parameters.joints.places().map(place),
            rotations: orientation.and_then(|found| found.first().copied()).zip(fingers),
            shape: shape.map(|shape| shape.map(f64::from)),
        })
    }
}

/// The order of axes that a declared shape says; `None` where it is open.
fn layout_of(shape: &[i64]) -> Option<Layout> {
    match shape {
        [_, 3, _, _] => Some(Layout::Nchw),
        [_, _, _, 3] => Some(Layout::Nhwc),
        _ => None,
    }
}
