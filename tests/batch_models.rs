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
use tiny_models::{mean_of_unmasked, red_things, write_model};

const DESCRIPTION: &str = "contract = \"video-inpaint/1\"\nname = \"Tiny mean\"\nlicence = \"MIT\"\n\
                           [sizes]\nL = 11\nR = 6\n";

/// Who made the object's masks and the background.
fn backends(out: &Path) -> [String; 2] {
    let record = fs::read(out.join("a/record.json")).unwrap();
    let record: serde_json::Value = serde_json::from_slice(&record).unwrap();
    ["object_masks", "background"].map(|part| record["backends"][part].as_str().unwrap().to_owned())
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
