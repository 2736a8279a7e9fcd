//! What the window remembers between starts, and where it offers it.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

mod support;

use std::{
    fs,
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use agenticfocus::engine::{Engine, Event, Request};
use agenticfocus_ui::{
    action::Action,
    app::{Dialogs, OperatorApp, Purpose, window_file},
    canvas::Canvas,
    panels::Shell,
    state::{BeforeAfter, PlaySpeed},
    theme::{ThemeChoice, Tokens},
};
use egui::vec2;
use egui_kittest::{Harness, SnapshotResults, kittest::Queryable as _};
use support::Bench;

/// Opens nothing: what is asked for cannot be opened.
#[derive(Clone, Default)]
struct Refusing(Arc<Mutex<Vec<Event>>>);

impl Engine for Refusing {
    fn send(&self, request: Request) {
        if let Request::Open(path) = request {
            let message = "no such file".to_owned();
            self.0.lock().unwrap().push(Event::NotOpened { path, message });
        }
    }

    fn poll(&self) -> Option<Event> {
        self.0.lock().unwrap().pop()
    }
}

struct NoDialogs;

impl Dialogs for NoDialogs {
    fn ask(&mut self, _purpose: Purpose, _start: Option<&Path>) {}

    fn answer(&mut self) -> Option<(Purpose, PathBuf)> {
        None
    }
}

fn window(file: &Path) -> Harness<'static, OperatorApp> {
    let engine = Box::new(Refusing::default());
    let app = OperatorApp::new(engine, Box::new(NoDialogs)).remembering(file.to_owned());
    Harness::builder()
        .with_size(vec2(1200.0, 700.0))
        .build_ui_state(|ui, app: &mut OperatorApp| app.show(ui), app)
}

#[test]
fn the_next_start_looks_like_the_last_one() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("config").join("window.json");
    let mut first = window(&file);
    let options = first.state_mut().options_mut();
    options.theme = ThemeChoice::Light;
    options.zoom = 1.25;
    options.queue_open = false;
    options.brush_radius = 31.5;
    options.mask_opacity = 0.6;
    options.grow_by = 7;
    options.speed = PlaySpeed::Half;
    options.before_after = BeforeAfter::Wipe(0.25);
    let wanted = options.clone();
    // Folders are queues, which are surveyed and not opened.
    for at in 0..12 {
        let clips = folder.path().join(format!("clips{at}"));
        fs::create_dir(&clips).unwrap();
        first.state_mut().open(clips);
    }
    first.state_mut().options_mut().queue_open = false;
    first.run_steps(2);
    drop(first);

    let second = window(&file);
    assert_eq!(*second.state().options(), wanted);
    let recent: Vec<PathBuf> = (2..12).rev().map(|at| folder.path().join(format!("clips{at}"))).collect();
    assert_eq!(second.state().recent(), recent);
    assert!(second.state().messages().is_empty());
}

#[test]
fn a_change_is_written_once_it_rests_without_waiting_for_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("window.json");
    let mut window = window(&file);
    window.run_steps(2);
    window.state_mut().options_mut().grow_by = 9;
    window.run_steps(2);
    assert!(!file.exists());
    let end = Instant::now() + Duration::from_secs(20);
    while !file.exists() && Instant::now() < end {
        std::thread::sleep(Duration::from_millis(100));
        window.run_steps(1);
    }
    let kept: serde_json::Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    assert_eq!((&kept["version"], &kept["grow_by"]), (&1.into(), &9.into()));
}

#[test]
fn a_damaged_file_is_mentioned_and_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("window.json");
    for damaged in ["", "{\"version\": 1, \"zoom\": ", "[]", "{\"version\": 1, \"theme\": \"plaid\"}"] {
        fs::write(&file, damaged).unwrap();
        let mut window = window(&file);
        assert!(window.state().messages()[0].text.contains("window.json"), "{damaged}");
        window.state_mut().options_mut().grow_by = 9;
        window.run_steps(1);
        drop(window);
        assert!(fs::read_to_string(&file).unwrap().contains("\"grow_by\": 9"));
    }
}

#[test]
fn a_newer_file_is_mentioned_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("window.json");
    let newer = "{\"version\": 2, \"panels\": []}";
    fs::write(&file, newer).unwrap();
    let mut window = window(&file);
    assert!(window.state().messages()[0].text.contains("newer"));
    window.state_mut().options_mut().grow_by = 9;
    window.run_steps(1);
    drop(window);
    assert_eq!(fs::read_to_string(&file).unwrap(), newer);
}

#[test]
fn numbers_that_no_control_allows_are_brought_into_range() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("window.json");
    let text =
        r#"{"version": 1, "zoom": 1e30, "brush_radius": -4, "grow_by": 0, "recent": ["relative.mp4"]}"#;
    fs::write(&file, text).unwrap();
    let mut window = window(&file);
    window.run_steps(2);
    let options = window.state().options();
    assert_eq!((options.zoom, options.brush_radius, options.grow_by), (2.5, 0.5, 1));
    assert!(window.state().recent().is_empty());
}

#[test]
fn what_could_not_be_opened_is_forgotten() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(&folder.path().join("window.json"));
    window.state_mut().open(folder.path().join("gone.mp4"));
    assert_eq!(window.state().recent().len(), 1);
    window.run_steps(2);
    assert!(window.state().recent().is_empty());
    assert!(window.state().messages()[0].text.contains("gone.mp4"));
}

#[test]
fn a_place_that_cannot_be_written_is_mentioned() {
    let folder = tempfile::tempdir().unwrap();
    let blocking = folder.path().join("blocking");
    fs::write(&blocking, "a file where a folder is needed").unwrap();
    let mut window = window(&blocking.join("window.json"));
    window.state_mut().options_mut().grow_by = 9;
    let end = Instant::now() + Duration::from_secs(20);
    while Instant::now() < end
        && !window.state().messages().iter().any(|message| message.text.contains("not kept"))
    {
        std::thread::sleep(Duration::from_millis(100));
        window.run_steps(1);
    }
    assert!(Instant::now() < end);
}

#[test]
fn the_file_lies_in_the_operators_configuration() {
    let of =
        |config: Option<&str>, home: Option<&str>| window_file(config.map(Into::into), home.map(Into::into));
    let file = |folder: &str| Some(Path::new(folder).join("agenticfocus/window.json"));
    assert_eq!(of(Some("/config"), Some("/home/op")), file("/config"));
    assert_eq!(of(Some("relative"), Some("/home/op")), file("/home/op/.config"));
    assert_eq!(of(None, Some("/home/op")), file("/home/op/.config"));
    assert_eq!(of(None, None), None);
}

fn with_recent(tokens: Tokens) -> Bench {
    let mut bench = Bench::empty(tokens);
    bench.recent =
        ["kitchen/pour_water.mp4", "kitchen/fold_towel.afs", "a_rather_long_name_of_a_folder/clips.toml"]
            .map(|path| Path::new("/clips").join(path))
            .into();
    bench.demo = Some("/out/demo/episode.afs".into());
    bench
}

fn start(bench: Bench, size: [f32; 2]) -> Harness<'static, Bench> {
    let (mut shell, mut canvas) = (Shell::default(), Canvas::default());
    support::harness(bench, size, move |ui, bench| {
        shell.show(ui, &mut bench.context(), |ui, cx| canvas.show(ui, cx), |_, _| {});
    })
}

fn opens(harness: &Harness<'_, Bench>, wanted: &str) -> bool {
    harness
        .state()
        .actions
        .iter()
        .any(|action| matches!(action, Action::Open(path) if path == Path::new(wanted)))
}

#[test]
fn an_empty_window_offers_what_was_open_and_the_demo() {
    let mut results = SnapshotResults::new();
    for (tokens, size, name) in [
        (Tokens::dark(), [1440.0, 900.0], "start_dark"),
        (Tokens::light(), [1024.0, 700.0], "start_light"),
        (Tokens::dark(), [900.0, 600.0], "start_tiny"),
    ] {
        let mut harness = start(with_recent(tokens), size);
        harness.run();
        harness.snapshot(name);
        harness.get_by_label("Open fold_towel.afs").click();
        harness.get_by_label("Try the demo episode").click();
        harness.run();
        assert!(opens(&harness, "/clips/kitchen/fold_towel.afs"));
        assert!(opens(&harness, "/out/demo/episode.afs"));
        results.extend_harness(&mut harness);
    }
}

#[test]
fn without_a_demo_nothing_is_said_of_one() {
    let mut harness = start(Bench { demo: None, ..with_recent(Tokens::dark()) }, [1024.0, 700.0]);
    harness.run();
    assert!(harness.query_by_label("Try the demo episode").is_none());
    assert!(harness.query_by_label_contains("demo").is_none());
}

#[test]
fn the_menu_opens_what_was_open() {
    let mut harness = start(with_recent(Tokens::dark()), [1024.0, 700.0]);
    harness.run();
    harness.get_by_label("Menu").click();
    harness.run();
    harness.get_by_label("Open recent").click();
    harness.run();
    harness.snapshot("menu_recent");
    let rows: Vec<_> = harness.get_all_by_label("Open pour_water.mp4").collect();
    // The canvas offers it too.
    assert_eq!(rows.len(), 2);
    rows[1].click();
    harness.run();
    assert!(opens(&harness, "/clips/kitchen/pour_water.mp4"));
}
