//! The whole window in every step: shell, canvas and inspector together, in both themes, wide and narrow.

mod support;

use agenticfocus::session::Step;
use agenticfocus_ui::{canvas::Canvas, inspector::Inspector, panels::Shell, theme::Tokens};
use egui_kittest::{Harness, SnapshotResults};
use support::Bench;

fn window(size: [f32; 2]) -> Harness<'static, Bench> {
    let (mut shell, mut canvas, mut inspector) = (Shell::default(), Canvas::default(), Inspector::default());
    support::harness(Bench::new(Tokens::dark()), size, move |ui, bench| {
        shell.show(ui, &mut bench.context(), |ui, cx| canvas.show(ui, cx), |ui, cx| inspector.show(ui, cx));
    })
}

fn every_step(size: [f32; 2], width: &str) {
    // One window for all: a renderer takes long to start.
    let mut harness = window(size);
    for (theme, tokens) in [("dark", Tokens::dark()), ("light", Tokens::light())] {
        for step in Step::ALL {
            let bench = harness.state_mut();
            bench.tokens = tokens.clone();
            bench.options.step = step;
            harness.run();
            let name = format!("window_{}_{width}_{theme}", format!("{step:?}").to_lowercase());
            harness.snapshot(name);
        }
    }
    let mut results = SnapshotResults::new();
    results.extend_harness(&mut harness);
}

#[test]
fn every_step_looks_as_it_should_in_a_wide_window() {
    every_step([1440.0, 900.0], "wide");
}

#[test]
fn every_step_looks_as_it_should_in_a_narrow_window() {
    every_step([1024.0, 700.0], "narrow");
}
