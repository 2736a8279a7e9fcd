//! The whole window over the real engine.
#![allow(dead_code, reason = "every test binary uses its own part of this")]
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use agenticfocus::{engine::LocalEngine, pipeline::Installation};
use agenticfocus_ui::{
    app::{Dialogs, OperatorApp, Purpose},
    state::Work,
};
use egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;

/// Nobody is asked for files here.
struct NoDialogs;

impl Dialogs for NoDialogs {
    fn ask(&mut self, _purpose: Purpose, _start: Option<&Path>) {}

    fn answer(&mut self) -> Option<(Purpose, PathBuf)> {
        None
    }
}

pub type Window = Harness<'static, OperatorApp>;

/// A window whose clips get their sessions and results in `out`.
pub fn window(out: &Path, installation: Installation) -> Window {
    let engine = LocalEngine::start(out.to_owned(), installation, Arc::new(|| {}));
    let app = OperatorApp::new(Box::new(engine), Box::new(NoDialogs));
    Harness::builder()
        .with_size(vec2(1440.0, 900.0))
        .wgpu()
        .build_ui_state(|ui, app: &mut OperatorApp| app.show(ui), app)
}

/// Goes on drawing until `done`.
pub fn wait(window: &mut Window, what: &str, done: impl Fn(&OperatorApp) -> bool) {
    let end = Instant::now() + Duration::from_secs(300);
    while !done(window.state()) {
        assert!(Instant::now() < end, "{what}: {:?}", window.state().messages());
        if let Some(Work::Failed(failure)) = window.state().workspace().map(|workspace| &workspace.work) {
            panic!("{what}: {failure:?}");
        }
        window.run_steps(1);
        std::thread::sleep(Duration::from_millis(20));
    }
    window.run_steps(2);
}

/// Whether everything was found out for the document as it is.
pub fn is_idle(app: &OperatorApp) -> bool {
    app.workspace().is_some_and(|workspace| {
        workspace.work == Work::Idle
            && workspace.worked_for == Some(workspace.revision)
            && workspace.found.order.is_some()
    })
}

pub fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    window.run_steps(2);
}
