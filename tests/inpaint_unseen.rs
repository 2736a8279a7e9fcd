//! What no frame saw, made up by a network that sees one picture, run by the real ONNX Runtime.
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
    geometry::Size,
    image::{Mask, Rgb8},
    inpaint::{
        InpaintError, InpaintParams, clean_with,
        network::{IMAGE_INPAINT, ImageNetwork},
    },
    onnx::{ModelFolder, OnnxError, Registry, Runtime, Trust},
    progress::Unwatched,
    segment::{MaskAuthor, MaskFrame, MaskTrack, RleMask},
};
use onnx_runtime::runtime;
use tiny_models::{mean_of_surroundings, write_model};

const SIZE: Size = Size { width: 320, height: 240 };
const COUNT: usize = 12;
const GROUND: [u8; 3] = [93, 121, 158];

fn open(runtime: &Runtime, root: &Path) -> Result<ImageNetwork, OnnxError> {
    let found = ModelFolder::find(&[PathBuf::from(root)]).remove(0)?;
    let registry = Registry::default();
    let checked = found.checked(IMAGE_INPAINT.graphs, Trust { registry: &registry, unlisted: true })?;
    ImageNetwork::open(runtime, &checked)
}

fn network(runtime: &Runtime, graph: Vec<u8>, more: &str) -> Result<ImageNetwork, OnnxError> {
    let root = tempfile::tempdir().unwrap();
    let description =
        format!("contract = \"image-inpaint/1\"\nname = \"Mean around\"\nlicence = \"MIT\"\n{more}");
    write_model(root.path(), "mean", &description, &[("image_inpaint.onnx", graph)]);
    open(runtime, root.path())
}

/// Even ground behind an arm that never moves, with an object that it holds.
struct Still;

fn arm(x: u32, y: u32) -> bool {
    (100..180).contains(&x) && y >= 90
}

fn object(x: u32, y: u32) -> bool {
    (150..210).contains(&x) && (100..150).contains(&y)
}

impl FrameSource for Still {
    fn size(&self) -> Size {
        SIZE
    }

    fn frame_count(&self) -> usize {
        COUNT
    }

    fn frame(&self, _: FrameIndex) -> Result<Rgb8, FrameError> {
        let mut picture = Rgb8::new(SIZE);
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                let colour = if object(x, y) {
                    [30, 200, 40]
                } else if arm(x, y) {
                    [220, 150, 120]
                } else {
                    GROUND
                };
                picture.set_pixel(x, y, colour);
            }
        }
        Ok(picture)
    }
}

fn track(inside: impl Fn(u32, u32) -> bool) -> MaskTrack {
    let mask = RleMask::encode(&Mask::from_fn(SIZE, inside));
    let frame = MaskFrame { mask, author: MaskAuthor::Seeded, score: 1.0, flags: Vec::new() };
    MaskTrack { size: SIZE, frames: vec![frame; COUNT], backend: "test".to_owned() }
}

#[test]
fn an_even_ground_comes_back_exactly_and_neither_object_nor_surroundings_are_touched() {
    let Some(runtime) = runtime() else { return };
    // One picture of the network's size, and one that is shrunk to it.
    for side in [240, 64] {
        let mut network = network(&runtime, mean_of_surroundings(side), "").unwrap();
        let (arms, held) = (track(|x, y| arm(x, y) && !object(x, y)), track(object));
        let source = Still.frame(FrameIndex(0)).unwrap();
        let mut frames = 0;
        let mut sink = |index: FrameIndex, picture: &Rgb8| {
            frames += 1;
            for y in 0..SIZE.height {
                for x in 0..SIZE.width {
                    let own = object(x, y) || !arm(x, y);
                    let expected = if own { source.pixel(x, y) } else { GROUND };
                    // The object's rim, which may carry the hand's colours, is taken out with the hand.
                    let near = |d: u32| [d.saturating_sub(3), d, d + 3];
                    let edge =
                        near(x).iter().any(|x2| near(y).iter().any(|y2| object(*x2, *y2) != object(x, y)));
                    if !edge {
                        assert_eq!(picture.pixel(x, y), expected, "{index} at {x}, {y}, side {side}");
                    }
                }
            }
            Ok(())
        };
        let params = InpaintParams::default();
        let report =
            clean_with(&Still, (&arms, &held), None, &params, Some(&mut network), &mut sink, &Unwatched)
                .unwrap();
        assert_eq!((frames, report.backend.as_str()), (COUNT, "temporal-plate, unseen by Mean around"));
        assert!(report.coverage.iter().all(|frame| frame.synthesised > 0.5), "{:?}", report.coverage[0]);
    }
}

#[test]
fn pictures_of_any_shape_are_fed_and_come_back_at_their_size() {
    let Some(runtime) = runtime() else { return };
    let mut network = network(&runtime, mean_of_surroundings(64), "").unwrap();
    for (width, height) in [(64, 64), (40, 64), (9, 5), (200, 130)] {
        let size = Size::new(width, height);
        let mut picture = Rgb8::new(size);
        picture.data_mut().chunks_exact_mut(3).for_each(|pixel| pixel.copy_from_slice(&GROUND));
        let hole = Mask::from_fn(size, |x, y| x > width / 3 && y > height / 3 && x < 2 * width / 3);
        let restored = network.restored(&picture.to_mat().unwrap(), &hole.to_mat().unwrap()).unwrap();
        let restored = Rgb8::from_mat(&restored).unwrap();
        assert_eq!(restored.size(), size);
        for y in 0..height {
            for x in (0..width).filter(|x| hole.get(*x, y)) {
                let inside = width < 65 || (hole.get(x.saturating_sub(4), y) && hole.get(x + 4, y));
                assert!(!inside || y < height / 3 + 5 || restored.pixel(x, y) == GROUND, "{size}: {x}, {y}");
            }
        }
    }
}

#[test]
fn a_network_of_another_shape_is_refused_by_name() {
    let Some(runtime) = runtime() else { return };
    let odd = network(&runtime, mean_of_surroundings(60), "").unwrap_err().to_string();
    assert!(odd.contains("S = 60") && odd.contains("multiple of 8"), "{odd}");
    let other = network(&runtime, b"no graph".to_vec(), "").unwrap_err();
    assert!(matches!(other, OnnxError::NotAGraph { .. }), "{other}");
}

#[test]
fn a_fault_of_the_network_is_told_from_one_of_the_stage() {
    let fault = InpaintError::Network(OnnxError::Run { graph: "image_inpaint", reason: "broke".to_owned() });
    assert!(fault.of_model().is_some_and(|fault| fault.to_string().contains("broke")));
}
