//! A whole clip by keyboard and by accessible labels, from the queue to the export, with the real engine.
#![cfg(feature = "engine")]
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "../../tests/support/mod.rs"]
mod episode;
mod real;

use std::{fs, path::Path, sync::atomic::AtomicBool};

use agenticfocus::{
    clip::FrameIndex,
    pipeline::{Installation, Listener, RunOptions, Stage, jobs_from_inputs, run_clip},
    session::{Author, ReviewState, Session, Step},
};
use agenticfocus_ui::app::OperatorApp;
use egui::{Key, Modifiers, Pos2};
use egui_kittest::kittest::Queryable as _;
use real::{is_idle, press, wait, window};

struct Quiet;

impl Listener for Quiet {
    fn progress(&self, _stage: Stage, _done: usize, _total: usize, _share: f64) {}

    fn note(&self, _text: &str) {}
}

#[test]
fn an_operator_goes_from_the_queue_to_the_export_by_keys_and_labels() {
    let folder = tempfile::tempdir().unwrap();
    episode::episode(folder.path());
    let manifest = episode::manifest(folder.path(), &["clip"], "");
    let out = folder.path().join("window");
    let mut window = window(&out, Installation::locate());
    window.state_mut().open(manifest);
    wait(&mut window, "the queue", |app| app.queue().items.iter().any(|item| item.thumbnail.is_some()));

    press(&mut window, Modifiers::COMMAND, Key::Enter);
    wait(&mut window, "everything found out", is_idle);

    // The object: its box is the manifest's; the operator confirms it.
    assert_eq!(window.state().options().step, Step::Object);
    press(&mut window, Modifiers::NONE, Key::Enter);
    let object = window.state().workspace().unwrap().document().object.clone().unwrap();
    assert_eq!(object.author, Author::Human);
    wait(&mut window, "the confirmed object", is_idle);

    // Masks: a stroke on frame 5, which is then trusted and spread.
    press(&mut window, Modifiers::ALT, Key::Num2);
    for _ in 0..5 {
        press(&mut window, Modifiers::NONE, Key::ArrowRight);
    }
    press(&mut window, Modifiers::NONE, Key::B);
    wait(&mut window, "the picture", |app| app.workspace().unwrap().playhead == FrameIndex(5));
    let canvas = window.get_by_label("Canvas").rect().center();
    window.drag_at(canvas);
    window.run_steps(1);
    window.hover_at(Pos2::new(canvas.x + 30.0, canvas.y));
    window.run_steps(1);
    window.drop_at(Pos2::new(canvas.x + 30.0, canvas.y));
    window.run_steps(3);
    let drawn = |app: &OperatorApp| app.workspace().unwrap().document().object_masks.clone();
    assert_eq!(drawn(window.state()).keys().copied().collect::<Vec<_>>(), [FrameIndex(5)]);
    let mask = drawn(window.state());
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(drawn(window.state()).is_empty());
    press(&mut window, Modifiers::COMMAND, Key::Y);
    assert_eq!(drawn(window.state()), mask);
    press(&mut window, Modifiers::COMMAND, Key::ArrowRight);
    wait(&mut window, "the masks", is_idle);

    // The hole behind the arms, two pixels wider.
    let hole = |app: &OperatorApp| -> u64 {
        let report = app.workspace().unwrap().found.background.clone().unwrap();
        report.coverage.iter().map(|frame| frame.hole).sum()
    };
    let narrow = hole(window.state());
    press(&mut window, Modifiers::ALT, Key::CloseBracket);
    press(&mut window, Modifiers::ALT, Key::CloseBracket);
    wait(&mut window, "the wider hole", is_idle);
    assert_eq!(window.state().workspace().unwrap().document().hole_dilation, Some(5.0 / 320.0));
    assert!(hole(window.state()) > narrow);

    // A frame without the object, a template by hand, an order, a scale: by label and by key.
    press(&mut window, Modifiers::NONE, Key::End);
    press(&mut window, Modifiers::NONE, Key::O);
    press(&mut window, Modifiers::ALT, Key::Num3);
    press(&mut window, Modifiers::NONE, Key::Home);
    press(&mut window, Modifiers::NONE, Key::L);
    press(&mut window, Modifiers::ALT, Key::Num6);
    press(&mut window, Modifiers::NONE, Key::Num2);
    wait(&mut window, "the edits", is_idle);
    let document = window.state().workspace().unwrap().document().clone();
    assert_eq!(document.template.placements.len(), 1);
    assert_eq!(document.layer_orders.len(), 1);

    press(&mut window, Modifiers::ALT, Key::Num7);
    window.get_by_label("Accept").click();
    window.run_steps(3);
    assert_eq!(window.state().workspace().unwrap().document().review, ReviewState::Accepted);
    press(&mut window, Modifiers::COMMAND, Key::E);
    wait(&mut window, "the export", |app| app.workspace().unwrap().exported.is_some());
    let exported = window.state().workspace().unwrap().exported.clone().unwrap().unwrap();
    let session = window.state().workspace().unwrap().folder.clone();
    let shown = window.state().workspace().unwrap().document().clone();
    drop(window);

    // What was shown is what is on disk, and the batch makes the same of it.
    let (kept, _) = Session::open_read_only(&session).unwrap();
    assert_eq!(*kept.document(), shown);
    let batch = folder.path().join("batch");
    let job = jobs_from_inputs(&[session]).unwrap().remove(0);
    run_clip(&job, &batch, &Installation::locate(), RunOptions::default(), &Quiet, &AtomicBool::new(false))
        .unwrap();
    let names = episode::files(&exported);
    assert_eq!(names, episode::files(&batch.join("clip")));
    for name in names.iter().filter(|name| *name != Path::new("report.json")) {
        let same = fs::read(exported.join(name)).unwrap() == fs::read(batch.join("clip").join(name)).unwrap();
        assert!(same, "{} differs", name.display());
    }
}
