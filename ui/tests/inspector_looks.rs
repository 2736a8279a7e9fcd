//! Every inspector in both themes, and in a short and narrow window.

mod support;

use agenticfocus::session::Step;
use agenticfocus_ui::{inspector::Inspector, theme::Tokens};
use egui_kittest::{Harness, SnapshotResults};
use support::Bench;

struct Stage {
    bench: Bench,
    inspector: Inspector,
}

fn harness(stage: Stage, size: [f32; 2]) -> Harness<'static, Stage> {
    Harness::builder().with_size(size).build_ui_state(
        |ui, stage: &mut Stage| {
            agenticfocus_ui::theme::apply(ui.ctx(), &stage.bench.tokens);
            let frame = egui::Frame::new().fill(stage.bench.tokens.panel);
            egui::CentralPanel::default().frame(frame).show(ui, |ui| {
                stage.inspector.show(ui, &mut stage.bench.context());
            });
        },
        stage,
    )
}

fn snapshots(step: Step, name: &str, height: f32) {
    let mut results = SnapshotResults::new();
    let looks = [
        (Tokens::dark(), "dark", [320.0, height]),
        (Tokens::light(), "light", [320.0, height]),
        (Tokens::dark(), "narrow", [256.0, 450.0]),
    ];
    for (tokens, look, size) in looks {
        let mut bench = Bench::new(tokens);
        bench.options.step = step;
        let mut harness = harness(Stage { bench, inspector: Inspector::default() }, size);
        harness.run_steps(4);
        harness.snapshot(format!("inspector_{name}_{look}"));
        results.extend(harness.take_snapshot_results());
    }
}

#[test]
fn object() {
    snapshots(Step::Object, "object", 640.0);
}

#[test]
fn masks() {
    snapshots(Step::Masks, "masks", 800.0);
}

#[test]
fn template() {
    snapshots(Step::Template, "template", 1000.0);
}

#[test]
fn hands() {
    snapshots(Step::Hands, "hands", 760.0);
}

#[test]
fn retarget() {
    snapshots(Step::Retarget, "retarget", 960.0);
}

#[test]
fn composite() {
    snapshots(Step::Composite, "composite", 640.0);
}

#[test]
fn review() {
    snapshots(Step::Review, "review", 860.0);
}

#[test]
fn without_a_clip_it_says_what_to_do() {
    let stage = Stage { bench: Bench::empty(Tokens::dark()), inspector: Inspector::default() };
    let mut harness = harness(stage, [320.0, 300.0]);
    harness.run_steps(2);
    harness.snapshot("inspector_empty");
}
