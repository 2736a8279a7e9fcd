//! A batch does every clip it can, says what it cannot, and gives the same bytes however it was disturbed.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "support/program.rs"]
mod program;
mod support;

use std::{collections::BTreeMap, fs, path::Path, process::Command, time::Duration};

use agenticfocus::{
    clip::FrameIndex,
    session::{Author, Command as SessionCommand, MaskEdit, MaskLayer, Session},
};
use program::batch;
use support::{episode, manifest};

/// Bytes of the record and the masks, by file.
fn essence(folder: &Path) -> BTreeMap<String, blake3::Hash> {
    let mut files = vec![folder.join("record.npz"), folder.join("record.json")];
    for kind in ["object", "hand"] {
        files.extend(
            fs::read_dir(folder.join("masks").join(kind)).unwrap().map(|entry| entry.unwrap().path()),
        );
    }
    let name = |path: &Path| path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
    files.iter().map(|path| (name(path), blake3::hash(&fs::read(path).unwrap()))).collect()
}

#[test]
fn bytes_do_not_depend_on_jobs_or_on_being_killed_and_a_session_is_obeyed() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("source");
    let episode = episode(&source);
    let path = manifest(&source, &["a", "b"], "");
    let (one, two) = (folder.path().join("one"), folder.path().join("two"));
    let undisturbed = batch(&[&path], &one, &["--jobs", "1"]);
    assert!(undisturbed.status.success(), "{}", String::from_utf8_lossy(&undisturbed.stderr));

    // Kill a run of two at a time in the middle of both clips, then start it again.
    let program = env!("CARGO_BIN_EXE_agenticfocus");
    let mut child = Command::new(program)
        .env("XDG_DATA_HOME", two.join("no-data"))
        .arg("--batch")
        .arg(&path)
        .arg("--out")
        .arg(&two)
        .args(["--jobs", "2"])
        .spawn()
        .unwrap();
    while !two.join("a.afs/cache").exists() {
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(700));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!two.join("a/done.json").exists(), "the kill came too late to test anything");
    let resumed = batch(&[&path], &two, &["--jobs", "2"]);
    assert!(resumed.status.success(), "{}", String::from_utf8_lossy(&resumed.stderr));
    for id in ["a", "b"] {
        assert_eq!(essence(&one.join(id)), essence(&two.join(id)), "{id}");
    }
    let leftovers = fs::read_dir(&two).unwrap().map(|entry| entry.unwrap().file_name());
    assert_eq!(leftovers.filter(|name| name.to_string_lossy().contains("tmp")).count(), 0);

    // Done is not done again.
    let before = fs::metadata(one.join("a/record.npz")).unwrap().modified().unwrap();
    assert!(batch(&[&path], &one, &[]).status.success());
    assert_eq!(fs::metadata(one.join("a/record.npz")).unwrap().modified().unwrap(), before);

    // A person says the object is absent on one frame and draws it on another: both stand.
    let (mut session, _) = Session::open(&one.join("a.afs")).unwrap();
    let drawn = agenticfocus::segment::RleMask::encode(&episode.object_visible(FrameIndex(4)).unwrap());
    let id = session.masks().put(&drawn).unwrap();
    for (frame, edit) in [(FrameIndex(4), MaskEdit::Mask(id)), (FrameIndex(15), MaskEdit::Absent)] {
        let edit = Some(edit);
        session
            .apply(Author::Human, SessionCommand::SetMask { layer: MaskLayer::Object, frame, edit })
            .unwrap();
    }
    drop(session);
    let edited = folder.path().join("edited");
    assert!(batch(&[&one.join("a.afs")], &edited, &[]).status.success());
    let mask = |frame: u32| {
        let path = edited.join(format!("a/masks/object/{frame:06}.png"));
        opencv::imgcodecs::imread(path.to_str().unwrap(), opencv::imgcodecs::IMREAD_GRAYSCALE).unwrap()
    };
    use opencv::core::count_non_zero;
    assert_eq!(count_non_zero(&mask(4)).unwrap() as u64, drawn.area());
    assert_eq!(count_non_zero(&mask(15)).unwrap(), 0);
}

#[test]
fn one_bad_clip_fails_alone_and_decides_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("source");
    episode(&source);
    fs::write(source.join("text.mp4"), "this is no video\n").unwrap();
    let more = "[[clip]]\npath = \"text.mp4\"\n[[clip]]\npath = \"missing.mp4\"\n";
    let path = manifest(&source, &["good"], more);
    let out = folder.path().join("out");
    let output = batch(&[&path], &out, &["--json"]);
    assert_eq!(output.status.code(), Some(65), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["exit"], "bad_input");
    for file in [
        "composite.mp4",
        "record.npz",
        "record.json",
        "report.json",
        "template.png",
        "done.json",
        "masks/object/000000.png",
        "masks/hand/000019.png",
        "debug/masks.mp4",
        "debug/inpaint.mp4",
        "debug/layers.mp4",
    ] {
        assert!(out.join("good").join(file).is_file(), "{file}");
    }
    for id in ["text", "missing"] {
        let text = fs::read_to_string(out.join(id).join("failed.json")).unwrap();
        let failed: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(failed["exit"], "bad_input", "{id}");
        assert_eq!(failed["stage"], "clip", "{id}");
        let message = failed["message"].as_str().unwrap();
        assert!(message.contains(&format!("{id}.mp4")) && !message.contains('\n'), "{message}");
    }
    let program = env!("CARGO_BIN_EXE_agenticfocus");
    let status = Command::new(program).arg("status").arg(&out).output().unwrap();
    let table = String::from_utf8_lossy(&status.stdout).into_owned();
    assert!(table.contains("good") && table.contains("bad input"), "{table}");
}

#[test]
fn wrong_usage_is_exit_2_and_names_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.toml");
    fs::write(&path, "[[clip]]\npath = \"a.mp4\"\nspeed = 3\n").unwrap();
    let output = batch(&[&path], &folder.path().join("out"), &[]);
    assert_eq!(output.status.code(), Some(2));
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(error.contains(":3:") && error.contains("speed"), "{error}");
}
