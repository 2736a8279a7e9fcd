//! The script for a user's own WiLoR or HaMeR speaks the estimator's protocol: with packages of the same shape that stand
//! in for them.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

use std::{
    fs,
    path::{Path, PathBuf},
};

use agenticfocus::{
    clip::{FrameError, FrameIndex, FrameSource},
    geometry::Size,
    hands::{EstimateParams, Estimation, EstimatorCommand, HandsError, estimate},
    image::Rgb8,
    progress::Unwatched,
};

/// What the script uses of PyTorch and Ultralytics: devices, loaders, and a detector that finds two hands.
const TORCH: &str = "
import contextlib, types
float16, float32 = 'float16', 'float32'
cuda = types.SimpleNamespace(is_available=lambda: False)
def device(name): return name
def no_grad(): return contextlib.nullcontext()
def DataLoader(dataset, batch_size, shuffle, num_workers): return [dataset.batch]
utils = types.SimpleNamespace(data=types.SimpleNamespace(DataLoader=DataLoader))
";
const ULTRALYTICS: &str = "
import types, numpy
class YOLO:
    def __init__(self, path): pass
    def __call__(self, image, conf, verbose):
        print('a stray line on standard output')
        assert image.shape == (120, 160, 3) and image[0, 0].tolist() == [30, 20, 10], image[0, 0]
        xyxy = numpy.array([[90.0, 40.0, 130.0, 80.0], [20.0, 40.0, 60.0, 80.0]])
        boxes = types.SimpleNamespace(xyxy=xyxy, conf=numpy.array([0.9, 0.8]), cls=numpy.array([1.0, 0.0]))
        return [types.SimpleNamespace(boxes=boxes)]
";
const WILOR: &str = "
import numpy
from ultralytics import YOLO
class WiLorHandPose3dEstimationPipeline:
    def __init__(self, device, dtype, verbose, wilor_pretrained_dir):
        assert (device, dtype, verbose) == ('cpu', 'float16', False)
        self.hand_detector = YOLO('detector.pt')
    def predict_with_bboxes(self, image, bboxes, is_rights, rescale_factor):
        assert rescale_factor == 2.5
        hands = []
        for box, right in zip(bboxes, is_rights):
            x, y = numpy.linspace(box[0], box[2], 21), numpy.linspace(box[3], box[1], 21)
            joints = numpy.stack([x / 1000, y / 1000, 0 * x], axis=1)
            preds = {'pred_keypoints_2d': numpy.stack([x, y], axis=1)[None], 'pred_keypoints_3d': joints[None]}
            hands.append({'hand_bbox': box, 'is_right': right, 'wilor_preds': preds})
        return hands
";
const HAMER_MODELS: &str = "
import types, numpy
DEFAULT_CHECKPOINT = '/nowhere/hamer.ckpt'
class Model:
    def to(self, device): return self
    def eval(self): pass
    def __call__(self, batch):
        joints = numpy.zeros((2, 21, 3))
        joints[:, :, 0] = numpy.linspace(0.0, 0.1, 21)
        return {'pred_cam': numpy.array([[5.0, 0.0, 0.0], [5.0, 0.0, 0.0]]), 'pred_keypoints_3d': joints}
def load_hamer(checkpoint):
    config = types.SimpleNamespace(
        EXTRA=types.SimpleNamespace(FOCAL_LENGTH=5000), MODEL=types.SimpleNamespace(IMAGE_SIZE=256))
    return Model(), config
";
const HAMER_DATASET: &str = "
class ViTDetDataset:
    def __init__(self, config, image, boxes, right, rescale_factor):
        assert rescale_factor == 2.0
        centre = (boxes[:, :2] + boxes[:, 2:]) / 2
        self.batch = {'box_center': centre, 'box_size': 2 * (boxes[:, 2] - boxes[:, 0]) * 4 / 3, 'right': right}
";

struct Plain;

impl FrameSource for Plain {
    fn size(&self) -> Size {
        Size::new(160, 120)
    }

    fn frame_count(&self) -> usize {
        8
    }

    fn frame(&self, index: FrameIndex) -> Result<Rgb8, FrameError> {
        let mut picture = Rgb8::new(self.size());
        picture.data_mut().chunks_exact_mut(3).for_each(|pixel| pixel.copy_from_slice(&[10, 20, 30]));
        // No two frames are the same picture: each is sent.
        picture.set_pixel(1 + index.0, 1, [255; 3]);
        Ok(picture)
    }
}

/// The Python of `make setup`, which has NumPy.
fn python() -> Option<PathBuf> {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join(".deps/venv/bin/python");
    if !python.exists() {
        println!("skipped: no Python at {}", python.display());
        return None;
    }
    Some(python)
}

fn write(folder: &Path, files: &[(&str, &str)]) {
    for (name, text) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
}

fn run(python: &Path, packages: &Path, arguments: &[&str]) -> Result<Estimation, HandsError> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/estimators/wilor_hamer_hands.py");
    let path = format!("PYTHONPATH={}", packages.display());
    let words = [path, "PYTHONDONTWRITEBYTECODE=1".to_owned()];
    let words = words.into_iter().chain([python, &script].map(|path| path.to_string_lossy().into_owned()));
    let words = words.chain(arguments.iter().map(|argument| (*argument).to_owned()));
    let command = EstimatorCommand::new("/usr/bin/env", words);
    estimate(&Plain, &command, &EstimateParams::default(), &Unwatched)
}

#[test]
fn an_installed_wilor_speaks_the_protocol() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let module = "wilor_mini/pipelines/wilor_hand_pose3d_estimation_pipeline.py";
    write(folder.path(), &[("torch.py", TORCH), ("ultralytics.py", ULTRALYTICS), (module, WILOR)]);
    write(
        folder.path(),
        &[("wilor_mini/__init__.py", "__version__ = '1.2'"), ("wilor_mini/pipelines/__init__.py", "")],
    );
    let weights = ["wilor_final.ckpt", "detector.pt", "MANO_RIGHT.pkl", "mano_mean_params.npz"];
    for file in weights {
        write(folder.path(), &[(&format!("wilor_mini/pretrained_models/{file}"), "")]);
    }
    let seen = run(&python, folder.path(), &["--half"]).unwrap();
    assert_eq!((seen.backend.as_str(), seen.landmarks.len()), ("wilor", 8));
    for hands in &seen.landmarks {
        let (left, right) = (hands.left.as_ref().unwrap(), hands.right.as_ref().unwrap());
        assert!((right.keypoints[0].x - 90.0).abs() < 1e-3 && (left.keypoints[20].x - 60.0).abs() < 1e-3);
        assert!((right.confidence - 0.9).abs() < 1e-6 && right.world.is_some());
    }
    fs::remove_file(folder.path().join("wilor_mini/pretrained_models/detector.pt")).unwrap();
    let error = run(&python, folder.path(), &["--half"]).unwrap_err().to_string();
    assert!(error.contains("WiLoR's detector.pt is not at") && error.contains("--weights"), "{error}");
}

#[test]
fn an_installed_hamer_speaks_the_protocol() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let identity = "def recursive_to(batch, device): return batch\n";
    write(
        folder.path(),
        &[
            ("torch.py", TORCH),
            ("ultralytics.py", ULTRALYTICS),
            ("hamer/__init__.py", ""),
            ("hamer/models/__init__.py", HAMER_MODELS),
            ("hamer/utils/__init__.py", identity),
            ("hamer/datasets/__init__.py", ""),
            ("hamer/datasets/vitdet_dataset.py", HAMER_DATASET),
            ("hamer.ckpt", ""),
            ("detector.pt", ""),
        ],
    );
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (checkpoint, detector) = (file("hamer.ckpt"), file("detector.pt"));
    let arguments = ["--model", "hamer", "--weights", &checkpoint, "--detector", &detector];
    let seen = run(&python, folder.path(), &arguments).unwrap();
    assert_eq!(seen.backend, "hamer");
    for hands in &seen.landmarks {
        // At scale 5 a crop of 106.7 pixels shows 0.4 m: a tip 0.1 m aside is 26.7 pixels away, outwards on both sides.
        let (left, right) = (hands.left.as_ref().unwrap(), hands.right.as_ref().unwrap());
        assert!((right.keypoints[0].x - 110.0).abs() < 1e-2 && (right.keypoints[20].x - 136.667).abs() < 0.1);
        assert!((left.keypoints[0].x - 40.0).abs() < 1e-2 && (left.keypoints[20].x - 13.333).abs() < 0.1);
    }
    let error = run(&python, folder.path(), &["--model", "hamer", "--weights", &checkpoint]).unwrap_err();
    assert!(error.to_string().contains("--detector"), "{error}");
}

#[test]
fn a_package_that_is_not_installed_is_named_with_what_to_do() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let without_torch = run(&python, folder.path(), &[]).unwrap_err().to_string();
    assert!(without_torch.contains("torch") && without_torch.contains("install PyTorch"), "{without_torch}");
    write(folder.path(), &[("torch.py", TORCH)]);
    for (model, package) in [("wilor", "WiLoR-mini"), ("hamer", "HaMeR")] {
        let error = run(&python, folder.path(), &["--model", model]).unwrap_err().to_string();
        assert!(error.contains("cannot be imported") && error.contains(package), "{error}");
        assert!(!error.contains("Traceback"), "{error}");
    }
}
