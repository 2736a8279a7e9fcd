//! Every inspector in both themes, and in a short and narrow window.

mod support;

use agenticfocus::{
    engine::{Access, ModelUse},
    geometry::PerSide,
    retarget::{Beta, Smoothing, WristTurn},
    session::{Command, Entry, LockHolder, RetargetSettings, Step},
};
use agenticfocus_ui::{
    inspector::Inspector,
    state::{Findings, Work},
    theme::Tokens,
};
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

/// One inspector in a state that the sample is not in.
fn snapshot_of(step: Step, name: &str, height: f32, prepare: impl FnOnce(&mut Bench)) {
    let mut bench = Bench::new(Tokens::dark());
    bench.options.step = step;
    prepare(&mut bench);
    let mut harness = harness(Stage { bench, inspector: Inspector::default() }, [320.0, height]);
    harness.run_steps(4);
    harness.snapshot(name);
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
    snapshots(Step::Masks, "masks", 1000.0);
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

#[test]
fn work_in_progress_can_be_held_and_stopped() {
    snapshot_of(Step::Masks, "inspector_masks_running", 640.0, |bench| {
        let running = Work::Running { stage: "object", share: 0.61, left: Some(8.0), paused: false };
        bench.workspace.as_mut().unwrap().work = running;
    });
}

#[test]
fn changed_parameters_have_a_dot_and_errors_a_plot() {
    snapshot_of(Step::Retarget, "inspector_retarget_changed", 1180.0, |bench| {
        let right = WristTurn { pitch_deg: -4.0, ..WristTurn::default() };
        let settings = RetargetSettings {
            smoothing: Some(Smoothing::Ema),
            wrist: PerSide { left: WristTurn::default(), right },
            beta: Some(Beta::Fixed(0.75)),
            offset: Some([0.1, 0.0, 0.4299]),
            ..RetargetSettings::default()
        };
        let workspace = bench.workspace.as_mut().unwrap();
        workspace.history.apply(Entry::Do(Command::SetRetarget(settings))).unwrap();
        bench.options.plot = 1;
    });
}

#[test]
fn a_model_that_broke_down_is_named_beside_what_was_done_instead() {
    let line = "/home/curator/.local/share/agenticfocus/models/e2fgvi-hq/video_inpaint.onnx: sha256 0f3a is listed in \
                no registry.toml; add it to the one in your data folder if you made this file yourself, or pass \
                --allow-unlisted-model; instead: background from plates";
    snapshot_of(Step::Composite, "inspector_composite_fault", 720.0, |bench| {
        let found = &mut bench.workspace.as_mut().unwrap().found;
        found.take_model_fault(ModelUse::Background, Some(line.to_owned()));
    });
}

#[test]
fn an_export_says_where_it_went_in_a_session_that_is_read_only() {
    snapshot_of(Step::Review, "inspector_review_exported", 860.0, |bench| {
        let workspace = bench.workspace.as_mut().unwrap();
        workspace.exported = Some(Ok("/clips/results/cup_lid".into()));
        workspace.access = Access::ReadOnly(LockHolder { program: "agenticfocus".to_owned(), pid: 7 });
    });
}

#[test]
fn before_anything_was_found_steps_say_what_is_missing() {
    snapshot_of(Step::Retarget, "inspector_retarget_nothing", 640.0, |bench| {
        bench.workspace.as_mut().unwrap().found = Findings::default();
    });
}
