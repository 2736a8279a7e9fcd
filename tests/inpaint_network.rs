//! A background network with windows, references, padding and blending, run by the real ONNX Runtime.
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
        InpaintError, InpaintParams,
        video::{Blend, NetworkFrame, VIDEO_INPAINT, VideoNetwork, clean_by_network},
    },
    onnx::{ModelFolder, OnnxError, Registry, Runtime, Trust},
    progress::Unwatched,
    segment::{MaskAuthor, MaskFrame, MaskTrack, RleMask},
};
use onnx_runtime::runtime;
use tiny_models::{mean_of_unmasked, write_model};

const SIZE: Size = Size { width: 108, height: 60 };
const COUNT: usize = 23;
const LOCAL: i64 = 11;
const REFERENCES: i64 = 6;

fn description(more: &str) -> String {
    format!("contract = \"video-inpaint/1\"\nname = \"Mean\"\nlicence = \"MIT\"\n{more}")
}

fn open(runtime: &Runtime, root: &Path) -> Result<VideoNetwork, OnnxError> {
    let found = ModelFolder::find(&[PathBuf::from(root)]).remove(0)?;
    let registry = Registry::default();
    let checked = found.checked(VIDEO_INPAINT.graphs, Trust { registry: &registry, unlisted: true })?;
    VideoNetwork::open(runtime, &checked)
}

fn network(runtime: &Runtime) -> VideoNetwork {
    let root = tempfile::tempdir().unwrap();
    let graph = mean_of_unmasked(LOCAL + REFERENCES, LOCAL, 60, 108);
    let sizes = description(&format!("[sizes]\nL = {LOCAL}\nR = {REFERENCES}\n"));
    write_model(root.path(), "mean", &sizes, &[("video_inpaint.onnx", graph)]);
    open(runtime, root.path()).unwrap()
}

/// A still scene with a bar that moves across it.
struct Scene {
    size: Size,
}

impl Scene {
    fn ground(&self, x: u32, y: u32) -> [u8; 3] {
        // No channel is mid grey, which to the network is what is taken out.
        [(40 + x % 60) as u8, (150 + y % 90) as u8, (200 + (x + y) % 40) as u8]
    }

    fn bar(&self, frame: usize, x: u32) -> bool {
        let left = (frame as u32 * 4) % self.size.width;
        (left..left + self.size.width / 9).contains(&x)
    }

    fn mask(&self, frame: usize) -> Mask {
        Mask::from_fn(self.size, |x, _| self.bar(frame, x))
    }

    fn track(&self, mask: impl Fn(usize) -> Mask) -> MaskTrack {
        let frame = |frame| MaskFrame {
            mask: RleMask::encode(&mask(frame)),
            author: MaskAuthor::Seeded,
            score: 1.0,
            flags: Vec::new(),
        };
        MaskTrack { size: self.size, frames: (0..COUNT).map(frame).collect(), backend: "test".to_owned() }
    }
}

impl FrameSource for Scene {
    fn size(&self) -> Size {
        self.size
    }

    fn frame_count(&self) -> usize {
        COUNT
    }

    fn frame(&self, index: FrameIndex) -> Result<Rgb8, FrameError> {
        let mut picture = Rgb8::new(self.size);
        for y in 0..self.size.height {
            for x in 0..self.size.width {
                let bar = self.bar(index.as_usize(), x);
                picture.set_pixel(x, y, if bar { [250, 10, 10] } else { self.ground(x, y) });
            }
        }
        Ok(picture)
    }
}

#[test]
fn a_still_scene_behind_something_that_moves_is_restored_exactly() {
    let Some(runtime) = runtime() else { return };
    let mut network = network(&runtime);
    let scene = Scene { size: SIZE };
    let frames: Vec<NetworkFrame> = (0..17)
        .map(|frame| NetworkFrame {
            picture: scene.frame(FrameIndex(frame)).unwrap().to_mat().unwrap(),
            hole: scene.mask(frame as usize).to_mat().unwrap(),
        })
        .collect();
    let restored = network.restore(&frames.iter().collect::<Vec<_>>(), 11).unwrap();
    let plane = 108 * 60;
    let mut worst = 0.0_f32;
    for (at, value) in restored.iter().enumerate() {
        let (channel, pixel) = (at / plane % 3, at % plane);
        let truth = scene.ground((pixel % 108) as u32, (pixel / 108) as u32)[channel];
        worst = worst.max((value - (f32::from(truth) / 255.0 * 2.0 - 1.0)).abs());
    }
    assert!(worst < 1e-6, "off by {worst}");
}

#[test]
fn every_frame_of_a_clip_comes_out_once_in_order_and_clean_whatever_its_size() {
    let Some(runtime) = runtime() else { return };
    let mut network = network(&runtime);
    for size in [SIZE, Size::new(216, 120), Size::new(80, 60), Size::new(64, 20)] {
        let scene = Scene { size };
        let (arms, object) = (scene.track(|frame| scene.mask(frame)), scene.track(|_| Mask::new(size)));
        for blend in Blend::ALL {
            let mut seen = Vec::new();
            let mut worst = 0;
            let mut sink = |index: FrameIndex, picture: &Rgb8| {
                seen.push(index.0);
                // Far from borders, where shrinking and enlarging mix neighbours.
                for (x, y) in [(size.width / 2, size.height / 2), (size.width / 3, size.height / 3)] {
                    for (found, truth) in picture.pixel(x, y).iter().zip(scene.ground(x, y)) {
                        worst = worst.max(found.abs_diff(truth));
                    }
                }
                Ok(())
            };
            let params = InpaintParams::default();
            let pair = (&mut network, blend);
            let report =
                clean_by_network(&scene, (&arms, &object), &params, pair, &mut sink, &Unwatched).unwrap();
            assert_eq!(seen, (0..COUNT as u32).collect::<Vec<_>>(), "{size}");
            assert!(size != SIZE || worst <= 1, "{size}: off by {worst}");
            assert_eq!((report.coverage.len(), report.backend.as_str()), (COUNT, "Mean"));
        }
    }
}

#[test]
fn the_object_and_everything_beside_the_hole_stay_as_they_are() {
    let Some(runtime) = runtime() else { return };
    let mut network = network(&runtime);
    let scene = Scene { size: SIZE };
    let object = Mask::from_fn(SIZE, |x, y| (40..70).contains(&x) && (20..40).contains(&y));
    let (arms, held) = (scene.track(|frame| scene.mask(frame)), scene.track(|_| object.clone()));
    let mut sink = |index: FrameIndex, picture: &Rgb8| {
        let source = scene.frame(index).unwrap();
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                let inside = (43..67).contains(&x) && (23..37).contains(&y);
                let near_bar = (x.saturating_sub(8)..=x + 8).any(|x| scene.bar(index.as_usize(), x));
                if inside || !near_bar {
                    assert_eq!(picture.pixel(x, y), source.pixel(x, y), "{index} at {x}, {y}");
                }
            }
        }
        Ok(())
    };
    let pair = (&mut network, Blend::default());
    clean_by_network(&scene, (&arms, &held), &InpaintParams::default(), pair, &mut sink, &Unwatched).unwrap();
}

#[test]
fn sizes_that_contradict_each_other_are_refused_by_name() {
    let Some(runtime) = runtime() else { return };
    let refused = |graph: Vec<u8>, more: &str| {
        let root = tempfile::tempdir().unwrap();
        write_model(root.path(), "mean", &description(more), &[("video_inpaint.onnx", graph)]);
        open(&runtime, root.path()).unwrap_err().to_string()
    };
    let sum = refused(mean_of_unmasked(17, 11, 60, 108), "[sizes]\nL = 11\nR = 7\n");
    assert!(sum.contains("R = 7") && sum.contains("17"), "{sum}");
    let silent = refused(mean_of_unmasked(17, 11, 60, 108), "");
    assert!(silent.contains("[sizes]"), "{silent}");
    let odd = refused(mean_of_unmasked(17, 11, 64, 108), "[sizes]\nL = 11\nR = 6\n");
    assert!(odd.contains("multiples"), "{odd}");
    let unknown = refused(mean_of_unmasked(17, 11, 60, 108), "[parameters]\nstride = 5\n");
    assert!(unknown.contains("stride"), "{unknown}");
}

#[test]
fn a_network_that_fails_in_mid_clip_says_so_and_no_frame_is_invented() {
    let Some(runtime) = runtime() else { return };
    let root = tempfile::tempdir().unwrap();
    // Returns fewer pictures than the window has.
    let sizes = description("[sizes]\nL = 11\nR = 6\n");
    write_model(root.path(), "mean", &sizes, &[("video_inpaint.onnx", mean_of_unmasked(17, 4, 60, 108))]);
    let mut network = open(&runtime, root.path()).unwrap();
    let scene = Scene { size: SIZE };
    let arms = scene.track(|frame| scene.mask(frame));
    let none = scene.track(|_| Mask::new(SIZE));
    let mut sink = |_: FrameIndex, _: &Rgb8| panic!("a frame was handed on");
    let pair = (&mut network, Blend::default());
    let failed =
        clean_by_network(&scene, (&arms, &none), &InpaintParams::default(), pair, &mut sink, &Unwatched);
    assert!(matches!(failed, Err(InpaintError::Network(OnnxError::Run { .. }))), "{failed:?}");
}
