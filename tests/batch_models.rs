//! A batch uses a learned model where there is one, says so, and goes on without it where it fails.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "support/graph_writer.rs"]
mod graph_writer;
#[path = "support/program.rs"]
mod program;
mod support;
#[path = "support/tiny_models.rs"]
mod tiny_models;

use std::{fs, path::Path};

use program::batch;
use support::{episode, manifest};
use tiny_models::{
    brighter_side_regressor, flat_hand, mean_of_surroundings, mean_of_unmasked, red_things,
    same_hands_detector, write_model,
};

const DESCRIPTION: &str = "contract = \"video-inpaint/1\"\nname = \"Tiny mean\"\nlicence = \"MIT\"\n\
                           [sizes]\nL = 11\nR = 6\n";

/// Who made the object's masks and the background.
fn backends(out: &Path) -> [String; 2] {
    makers(out, ["object_masks", "background"])
}

fn makers(out: &Path, parts: [&str; 2]) -> [String; 2] {
    let record = fs::read(out.join("a/record.json")).unwrap();
    let record: serde_json::Value = serde_json::from_slice(&record).unwrap();
    parts.map(|part| record["backends"][part].as_str().unwrap().to_owned())
}

#[test]
fn networks_are_taken_named_in_the_record_and_done_without_when_they_fail() {
    if !Path::new(env!("CARGO_MANIFEST_DIR")).join(".deps/onnxruntime").is_dir() {
        println!("skipped: no ONNX Runtime");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("source");
    episode(&source);
    let manifest = manifest(&source, &["a"], "");
    let run = |name: &str, graph: Vec<u8>, more: &[&str]| {
        let (models, out) = (folder.path().join(format!("{name}.models")), folder.path().join(name));
        write_model(&models, "mean", DESCRIPTION, &[("video_inpaint.onnx", graph)]);
        if name == "taken" {
            let red = "contract = \"sam2-video/1\"\nname = \"Tiny red\"\nlicence = \"MIT\"\n";
            write_model(&models, "red", red, &red_things());
        }
        let models = models.to_string_lossy().into_owned();
        let arguments: Vec<&str> = ["--models", &models].into_iter().chain(more.iter().copied()).collect();
        let done = batch(&[&manifest], &out, &arguments);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success(), "{said}");
        (out, said)
    };
    let whole = || mean_of_unmasked(17, 11, 60, 108);
    let (taken, _) = run("taken", whole(), &["--allow-unlisted-model"]);
    assert_eq!(backends(&taken), ["Tiny red", "Tiny mean"]);

    let (unlisted, said) = run("unlisted", whole(), &[]);
    assert!(said.contains("--allow-unlisted-model") && said.contains("background from plates"), "{said}");
    // Returns fewer pictures than asked: fails only when it is run.
    let (failed, said) = run("failed", mean_of_unmasked(17, 4, 60, 108), &["--allow-unlisted-model"]);
    assert!(said.contains("background from plates"), "{said}");
    for out in [&unlisted, &failed] {
        assert_eq!(backends(out), ["classical", "temporal-plate"]);
    }
    let composite = |out: &Path| fs::read(out.join("a/composite.mp4")).unwrap();
    assert_eq!(composite(&unlisted), composite(&failed));
    assert_ne!(composite(&unlisted), composite(&taken));
}

#[test]
fn hands_and_what_no_frame_saw_come_from_networks_or_else_from_the_estimator_and_a_smooth_fill() {
    let dependencies = Path::new(env!("CARGO_MANIFEST_DIR")).join(".deps");
    if !dependencies.join("onnxruntime").is_dir() || !dependencies.join("venv/bin/python").exists() {
        println!("skipped: no ONNX Runtime or no hand estimator");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("source");
    let camera = episode(&source).truth.pinhole;
    let manifest = manifest(&source, &["a"], "");
    let text = fs::read_to_string(&manifest).unwrap();
    let without_track: Vec<&str> = text.lines().filter(|line| !line.starts_with("hands")).collect();
    fs::write(&manifest, without_track.join("\n")).unwrap();
    // Boxes of 60 pixels in a picture of 320×240, five times smaller in the detector's square and eight rows down.
    let hands = [[20.0, 38.0, 12.0, 12.0, 0.9, 0.0], [40.0, 38.0, 12.0, 12.0, 0.0, 0.9]];
    let scale = (2.0 * camera.fx / (160.0 * 0.4)) as f32;
    let run = |name: &str, joints: &[[f32; 3]], fill: Vec<u8>| {
        let (models, out) = (folder.path().join(format!("{name}.models")), folder.path().join(name));
        let describe = |contract: &str, name: &str| {
            format!("contract = \"{contract}\"\nname = \"{name}\"\nlicence = \"MIT\"\n[sizes]\nS = 64\n")
        };
        let graphs = [
            ("hand_detector.onnx", same_hands_detector(64, &hands)),
            ("hand_regressor.onnx", brighter_side_regressor(scale, joints, true)),
        ];
        write_model(&models, "hands", &describe("hand-pose/1", "Tiny hands"), &graphs);
        let fill = [("image_inpaint.onnx", fill)];
        write_model(&models, "fill", &describe("image-inpaint/1", "Tiny fill"), &fill);
        let models = models.to_string_lossy().into_owned();
        let done = batch(&[&manifest], &out, &["--models", &models, "--allow-unlisted-model"]);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success(), "{said}");
        (makers(&out, ["hands", "background"]), said)
    };
    let (made_by, said) = run("taken", &flat_hand(), mean_of_surroundings(64));
    assert_eq!(made_by, ["Tiny hands", "temporal-plate, unseen by Tiny fill"], "{said}");
    assert!(!said.contains("instead:"), "{said}");
    // One joint too few, which shows only when the graph is run; and a file that is no graph at all.
    let (made_by, said) = run("failed", &flat_hand()[..20], b"no graph".to_vec());
    assert_eq!(made_by, ["mediapipe", "temporal-plate"], "{said}");
    let lines = |of: &str| said.lines().filter(|line| line.contains(of)).count();
    for instead in ["hands from the estimator", "unseen background filled smoothly"] {
        assert_eq!(lines(instead), 1, "{said}");
    }
}
