//! A hand network with its detector, crops, decoding and sides, run by the real ONNX Runtime.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "support/graph_writer.rs"]
mod graph_writer;
#[path = "support/onnx_runtime.rs"]
mod onnx_runtime;
#[path = "support/tiny_models.rs"]
mod tiny_models;

use std::path::{Path, PathBuf};

use agenticfocus::{
    clip::{FrameError, FrameIndex, FrameSource},
    geometry::{Pinhole, Pixel, Side, Size},
    hands::network::{Crop, HAND_POSE, HandNetwork, track_hands},
    image::Rgb8,
    onnx::{ModelFolder, OnnxError, Registry, Runtime, Trust},
    progress::Unwatched,
};
use onnx_runtime::runtime;
use tiny_models::{brighter_side_regressor, flat_hand, red_hand_detector, same_hands_detector, write_model};

const SIZE: Size = Size { width: 640, height: 480 };

fn description(more: &str) -> String {
    format!("contract = \"hand-pose/1\"\nname = \"Tiny hands\"\nlicence = \"MIT\"\n{more}")
}

fn open(runtime: &Runtime, root: &Path) -> Result<HandNetwork, OnnxError> {
    let found = ModelFolder::find(&[PathBuf::from(root)]).remove(0)?;
    let registry = Registry::default();
    let checked = found.checked(HAND_POSE.graphs, Trust { registry: &registry, unlisted: true })?;
    HandNetwork::open(runtime, &checked)
}

fn network(
    runtime: &Runtime,
    more: &str,
    detector: Vec<u8>,
    regressor: Vec<u8>,
) -> Result<HandNetwork, OnnxError> {
    let root = tempfile::tempdir().unwrap();
    let graphs = [("hand_detector.onnx", detector), ("hand_regressor.onnx", regressor)];
    write_model(root.path(), "hands", &description(more), &graphs);
    open(runtime, root.path())
}

/// A ramp of brightness with a red square that moves along.
struct Scene {
    frames: usize,
}

impl Scene {
    fn middle(&self, frame: usize) -> Pixel {
        Pixel::new(200.0 + 4.0 * frame as f64, 260.0)
    }

    fn picture(&self, frame: usize, mirrored: bool) -> Rgb8 {
        let middle = self.middle(frame);
        let mut picture = Rgb8::new(SIZE);
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                let at = if mirrored { SIZE.width - 1 - x } else { x };
                let near =
                    (f64::from(at) - middle.x).abs() <= 20.0 && (f64::from(y) - middle.y).abs() <= 20.0;
                let grey = (at / 4) as u8;
                picture.set_pixel(x, y, if near { [255, 0, 0] } else { [grey; 3] });
            }
        }
        picture
    }
}

impl FrameSource for Scene {
    fn size(&self) -> Size {
        SIZE
    }

    fn frame_count(&self) -> usize {
        self.frames
    }

    fn frame(&self, index: FrameIndex) -> Result<Rgb8, FrameError> {
        Ok(self.picture(index.as_usize(), false))
    }
}

fn camera() -> Pinhole {
    Pinhole { fx: 600.0, fy: 600.0, cx: 310.0, cy: 250.0, size: SIZE }
}

#[test]
fn a_horizontal_flip_negates_the_shift_and_a_left_hand_is_seen_in_the_mirror() {
    let Some(runtime) = runtime() else { return };
    let regressor = brighter_side_regressor(5.0, &flat_hand(), false);
    let mut network = network(&runtime, "", same_hands_detector(64, &[]), regressor).unwrap();
    let scene = Scene { frames: 1 };
    let picture = scene.picture(0, false).to_mat().unwrap();
    let mirrored = scene.picture(0, true).to_mat().unwrap();
    let right = Crop { centre: Pixel::new(300.0, 200.0), side: 240.0, hand: Side::Right };
    let flipped = Crop { centre: Pixel::new(640.0 - 300.0 - 1.0, 200.0), ..right };
    let seen = network.regress(&picture, &right).unwrap();
    let turned = network.regress(&mirrored, &flipped).unwrap();
    assert!(seen.camera[1] > 0.1, "{:?}", seen.camera);
    // The two halves of 256 columns about a pixel's centre are not quite each other's mirror image.
    assert!((seen.camera[1] + turned.camera[1]).abs() < 0.02 * seen.camera[1], "{turned:?}");
    // The same crop called a left hand's shows the network the mirror image, and the answer is mirrored back.
    let left = Crop { hand: Side::Left, ..right };
    let other = network.regress(&picture, &left).unwrap();
    assert!((other.camera[1] - turned.camera[1]).abs() < 1e-3);
    let (a, b) = (seen.placed(&right, &camera()).unwrap(), other.placed(&left, &camera()).unwrap());
    let aside =
        |at: &agenticfocus::hands::network::PlacedHand, k: usize| at.joints[k].xyz.x - at.joints[0].xyz.x;
    assert!((a.joints[0].xyz - b.joints[0].xyz).norm() < 0.02);
    assert!(aside(&a, 4) < -0.03 && (aside(&a, 4) + aside(&b, 4)).abs() < 1e-3);
}

#[test]
fn joints_come_in_our_order_and_rotations_are_kept() {
    let Some(runtime) = runtime() else { return };
    let mut numbered = [[0.0; 3]; 21];
    for (k, joint) in numbered.iter_mut().enumerate() {
        joint[0] = k as f32;
    }
    let picture = Scene { frames: 1 }.picture(0, false).to_mat().unwrap();
    let crop = Crop { centre: Pixel::new(300.0, 200.0), side: 240.0, hand: Side::Right };
    let said = |more: &str, rotations: bool| {
        let regressor = brighter_side_regressor(5.0, &numbered, rotations);
        let mut network = network(&runtime, more, same_hands_detector(64, &[]), regressor).unwrap();
        network.regress(&picture, &crop).unwrap()
    };
    let order =
        |said: &agenticfocus::hands::network::HandPrediction| said.joints.map(|joint| joint.x as usize);
    let plain = said("", false);
    assert_eq!(order(&plain), std::array::from_fn(|k| k));
    assert!(plain.rotations.is_none() && plain.shape.is_none());
    let mano = said("[parameters]\njoints = \"mano\"\n", true);
    assert_eq!(order(&mano), [0, 13, 14, 15, 16, 1, 2, 3, 17, 4, 5, 6, 18, 10, 11, 12, 19, 7, 8, 9, 20]);
    let (orientation, fingers) = mano.rotations.unwrap();
    let quarter = nalgebra::UnitQuaternion::from_euler_angles(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
    assert!(orientation.angle_to(&quarter) < 1e-6 && fingers[14].angle_to(&quarter) < 1e-6);
    assert_eq!(mano.shape, Some([0.5; 10]));
}

#[test]
fn boxes_come_back_in_pixels_of_the_picture_and_doubles_are_dropped() {
    let Some(runtime) = runtime() else { return };
    // In a square of 64, a picture of 640×480 lies ten times smaller, eight rows down.
    let hands = [
        [20.0, 28.0, 10.0, 12.0, 0.05, 0.9],
        [20.5, 28.0, 10.0, 12.0, 0.05, 0.8],
        [50.0, 40.0, 8.0, 8.0, 0.7, 0.1],
        [10.0, 50.0, 8.0, 8.0, 0.1, 0.2],
    ];
    let regressor = brighter_side_regressor(5.0, &flat_hand(), false);
    let mut network = network(&runtime, "", same_hands_detector(64, &hands), regressor).unwrap();
    let picture = Scene { frames: 1 }.picture(0, false).to_mat().unwrap();
    let found = network.detect(&picture).unwrap();
    assert_eq!(found.iter().map(|hand| hand.side).collect::<Vec<_>>(), [Side::Right, Side::Left]);
    let first = found[0].bounds;
    assert!(
        (first.x0 - 150.0).abs() < 1e-3 && (first.y0 - 140.0).abs() < 1e-3 && (first.y1 - 260.0).abs() < 1e-3
    );
    assert!((network.crop(&first, Side::Right).side - 2.0 * 400.0 / 3.0).abs() < 1e-2);
}

#[test]
fn a_moving_hand_is_followed_in_metres_and_pixels() {
    let Some(runtime) = runtime() else { return };
    let (detector, regressor) =
        (red_hand_detector(320, 50.0), brighter_side_regressor(6.0, &flat_hand(), true));
    let more = "[picture]\nnormalisation = \"0-1\"\n";
    let mut network = network(&runtime, more, detector, regressor).unwrap();
    let scene = Scene { frames: 40 };
    let track = track_hands(&scene, &mut network, &camera(), &Unwatched).unwrap();
    assert_eq!((track.backend.as_str(), track.frame_count()), ("Tiny hands", 40));
    assert!(track.hands.left.iter().all(|hand| !hand.is_valid()));
    assert!((track.hand_length.right.unwrap() - 0.18).abs() < 1e-6);
    // A box of 100 pixels, enlarged to 4/3 and doubled, at scale 6.
    let side = 2.0 * 400.0 / 3.0;
    let depth = 2.0 * 600.0 / (side * 6.0);
    for (frame, hand) in track.hands.right.iter().enumerate() {
        assert!(hand.is_valid() && hand.mano.is_some());
        let (wrist, middle) = (hand.wrist().xyz, scene.middle(frame));
        assert!((wrist.z - depth).abs() < 1e-6, "frame {frame}: {wrist}");
        // The network shifts the hand to the brighter side, by the same all the way.
        let seen = camera().project(&hand.wrist()).unwrap();
        assert!((seen.x - middle.x).abs() < 130.0 && (seen.y - middle.y).abs() < 3.0, "{seen:?} {middle:?}");
        assert!(seen.distance(hand.keypoints[0]) < 3.0);
    }
    let moved = track.hands.right[39].wrist().xyz.x - track.hands.right[0].wrist().xyz.x;
    assert!((moved - 39.0 * 4.0 / 600.0 * depth).abs() < 0.01, "{moved}");
}

#[test]
fn a_description_that_contradicts_its_graphs_is_refused_by_name() {
    let Some(runtime) = runtime() else { return };
    let try_with = |more: &str| {
        let regressor = brighter_side_regressor(5.0, &flat_hand(), false);
        network(&runtime, more, same_hands_detector(64, &[]), regressor).map(drop)
    };
    assert!(try_with("[picture]\ncolour = \"bgr\"\n[parameters]\nbox_rule = \"square\"\n").is_ok());
    for (more, expected) in [
        ("[picture]\nlayout = \"nhwc\"\n", "layout"),
        ("[parameters]\nrescale = 0.0\n", "rescale"),
        ("[parameters]\nbox_rule = \"round\"\n", "aspect_3_4"),
        ("[parameters]\nfocal = 5000\n", "focal"),
    ] {
        let error = try_with(more).expect_err(more).to_string();
        assert!(error.contains("model.toml") && error.contains(expected), "{error}");
    }
}
