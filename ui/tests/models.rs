//! The window with learned models: who made what, and what is done where a model breaks down.
#![cfg(feature = "engine")]
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "../../tests/support/mod.rs"]
mod episode;
#[path = "../../tests/support/graph_writer.rs"]
mod graph_writer;
mod real;
#[path = "../../tests/support/tiny_models.rs"]
mod tiny_models;

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use agenticfocus::{
    clip::FrameIndex,
    image::Mask,
    pipeline::{Installation, ModelOptions},
    session::Step,
};
use agenticfocus_ui::state::Tool;
use egui::{Key, Modifiers, Pos2};
use egui_kittest::kittest::Queryable as _;
use real::{Window, is_idle, press, wait, window};
use tiny_models::{mean_of_unmasked, red_picture, red_things, write_model};

/// The red square that is drawn onto the episode: left, top and side, pixels.
const SQUARE: [u32; 3] = [16, 16, 96];

/// The episode with a red square in it, which its manifest names as the object.
fn clip_with_a_red_square(folder: &Path) -> PathBuf {
    let truth = episode::episode(folder);
    let [left, top, side] = SQUARE;
    let filter = format!("drawbox=x={left}:y={top}:w={side}:h={side}:color=red:t=fill");
    let drawn = Command::new("ffmpeg")
        .args(["-nostdin", "-v", "error", "-i"])
        .arg(folder.join("clip.mp4"))
        .args(["-vf", &filter, "-crf", "12", "-pix_fmt", "yuv444p"])
        .arg(folder.join("red.mp4"))
        .status();
    assert!(drawn.unwrap().success());
    fs::write(folder.join("hands.json"), episode::hand_track(&truth).to_string()).unwrap();
    let path = folder.join("manifest.toml");
    let (right, bottom) = (left + side, top + side);
    let text = format!(
        "[[clip]]\nid = \"red\"\npath = \"red.mp4\"\nhands = {{ track = \"hands.json\" }}\n\
         object = {{ frame = 0, box = [{left}, {top}, {right}, {bottom}] }}\n"
    );
    fs::write(&path, text).unwrap();
    path
}

/// The window on the clip with the models in `folder`, everything found out.
fn opened(manifest: &Path, models: &Path, out: &Path) -> Window {
    let folders = vec![models.to_owned()];
    let models = ModelOptions { folders, allow_unlisted: true, ..ModelOptions::default() };
    let mut window = window(out, Installation { models, ..Installation::locate() });
    window.state_mut().open(manifest.to_owned());
    wait(&mut window, "the queue", |app| !app.queue().items.is_empty());
    press(&mut window, Modifiers::COMMAND, Key::Enter);
    wait(&mut window, "everything found out", is_idle);
    window
}

/// Who made the object's masks and the background.
fn backends(window: &Window) -> [String; 2] {
    let found = &window.state().workspace().unwrap().found;
    [found.object.as_ref().unwrap().backend.clone(), found.background.as_ref().unwrap().backend.clone()]
}

fn says(window: &Window, words: &str) -> bool {
    window.query_all_by_label_contains(words).next().is_some()
}

/// What the engine makes of a click in the middle of the picture.
fn clicked(window: &mut Window) -> (Mask, String) {
    window.state_mut().look_at(FrameIndex(3), Step::Masks);
    wait(window, "the picture", |app| app.has_source(FrameIndex(3)));
    window.state_mut().options_mut().tool = Tool::Points;
    window.run_steps(2);
    let middle: Pos2 = window.get_by_label("Canvas").rect().center();
    window.drag_at(middle);
    window.run_steps(1);
    window.drop_at(middle);
    window.run_steps(2);
    wait(window, "the mask of the click", |app| {
        let draft = app.workspace().unwrap().draft.as_ref();
        draft.is_some_and(|draft| draft.mask.is_some() || draft.fault.is_some())
    });
    let draft = window.state().workspace().unwrap().draft.clone().unwrap();
    (draft.mask.unwrap_or_else(|| panic!("{:?}", draft.fault)).decode(), draft.backend)
}

/// Whether it is the red square, but for what the model's coarse picture rounds.
fn is_the_square(mask: &Mask) -> bool {
    let [left, top, side] = SQUARE;
    let range = |from: u32| from..from + side;
    let square = Mask::from_fn(mask.size(), |x, y| range(left).contains(&x) && range(top).contains(&y));
    mask.iou(&square) > 0.6
}

fn describe(contract: &str, name: &str, more: &str) -> String {
    format!("contract = \"{contract}\"\nname = \"{name}\"\nlicence = \"MIT\"\n{more}")
}

const SIZES: &str = "[sizes]\nL = 11\nR = 6\n";

#[test]
fn models_make_masks_and_background_in_the_window_and_a_broken_one_is_named_and_done_without() {
    if !Path::new(env!("CARGO_MANIFEST_DIR")).join("../.deps/onnxruntime").is_dir() {
        println!("skipped: no ONNX Runtime");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let manifest = clip_with_a_red_square(folder.path());
    let clicks = describe("sam2-image/1", "Tiny clicks", "");
    let red = describe("sam2-video/1", "Tiny red", "");
    let mean = describe("video-inpaint/1", "Tiny mean", SIZES);

    let whole = folder.path().join("whole");
    write_model(&whole, "clicks", &clicks, &red_picture(false));
    write_model(&whole, "red", &red, &red_things());
    write_model(&whole, "mean", &mean, &[("video_inpaint.onnx", mean_of_unmasked(17, 11, 60, 108))]);
    let mut window = opened(&manifest, &whole, &folder.path().join("out"));
    assert_eq!(backends(&window), ["Tiny red", "Tiny mean"]);
    press(&mut window, Modifiers::ALT, Key::Num6);
    assert!(says(&window, "Tiny mean"));
    // The click lies far from the square: only this model answers with it.
    let (mask, backend) = clicked(&mut window);
    assert_eq!(backend, "Tiny clicks");
    assert!(is_the_square(&mask), "{:?}", mask.bounding_box());
    assert!(says(&window, "Tiny red") && says(&window, "Tiny clicks"));
    assert!(window.state().workspace().unwrap().found.model_faults.is_empty());
    drop(window);

    let broken = folder.path().join("broken");
    // Returns fewer pictures than asked: fails only when it is run. The other is no graph at all.
    write_model(&broken, "mean", &mean, &[("video_inpaint.onnx", mean_of_unmasked(17, 4, 60, 108))]);
    write_model(
        &broken,
        "clicks",
        &clicks,
        &[("encoder.onnx", b"no graph".to_vec()), ("decoder.onnx", vec![])],
    );
    let mut window = opened(&manifest, &broken, &folder.path().join("again"));
    assert_eq!(backends(&window), ["classical", "temporal-plate"]);
    press(&mut window, Modifiers::ALT, Key::Num6);
    assert!(says(&window, "plates of other frames") && says(&window, "instead: background from plates"));
    let (mask, backend) = clicked(&mut window);
    assert_eq!(backend, "classical");
    assert!(!mask.is_empty() && !is_the_square(&mask));
    assert!(says(&window, "flow, colours and cuts") && says(&window, "prompt's mask without a network"));
}
