//! The frame of the window.

mod support;

use agenticfocus_ui::{panels::Shell, theme::Tokens};
use egui_kittest::Harness;
use support::{Bench, FRAMES, SIZE, long_workspace};

/// The whole window, with nothing on the canvas and in the inspector.
fn window(bench: Bench, size: [f32; 2]) -> Harness<'static, Bench> {
    let mut shell = Shell::default();
    support::harness(bench, size, move |ui, bench| {
        shell.show(ui, &mut bench.context(), |_, _| {}, |_, _| {});
    })
}

const WIDE: [f32; 2] = [1440.0, 900.0];
const NARROW: [f32; 2] = [1024.0, 700.0];

#[test]
fn the_sample_has_something_of_everything() {
    let bench = Bench::new(Tokens::dark());
    let workspace = bench.workspace.as_ref().unwrap();
    assert_eq!((workspace.frame_count(), workspace.size()), (FRAMES as usize, Some(SIZE)));
    assert!(!workspace.problems().is_empty());
    assert_eq!(long_workspace(9_000).frame_count(), 9_000);
}

#[test]
fn the_window_in_both_themes_and_narrow() {
    for (tokens, size, name) in [
        (Tokens::dark(), WIDE, "shell_dark"),
        (Tokens::light(), WIDE, "shell_light"),
        (Tokens::dark(), NARROW, "shell_narrow"),
    ] {
        let mut harness = window(Bench::new(tokens), size);
        harness.run();
        harness.snapshot(name);
    }
}

#[test]
fn a_window_without_a_clip_says_what_to_do() {
    let mut harness = window(Bench::empty(Tokens::dark()), WIDE);
    harness.run();
    harness.snapshot("shell_empty");
}
