//! The frame of the window, as an operator meets it.

mod support;

use std::{
    path::PathBuf,
    time::{Duration, SystemTime},
};

use agenticfocus::{
    clip::FrameIndex,
    engine::{Access, Request, SaveState, WorkFailure},
    session::{Command, Entry, LockHolder, Step},
};
use agenticfocus_ui::{
    action::Action,
    panels::{
        Shell,
        timeline::{MaskKind, Rows},
    },
    state::{Work, Workspace},
    theme::Tokens,
    ui_command::UiCommand,
    widgets::blocked,
};
use egui::{Key, Modifiers, pos2};
use egui_kittest::{
    Harness, SnapshotResults,
    kittest::{NodeT as _, Queryable as _},
};
use support::{Bench, FRAMES, SIZE, long_workspace};

/// The canvas' place without a canvas.
fn ground(ui: &mut egui::Ui, cx: &mut agenticfocus_ui::state::Context<'_>) {
    ui.painter().rect_filled(ui.max_rect(), 0.0, cx.tokens.ground);
}

/// The whole window, with nothing on the canvas and in the inspector.
fn window(bench: Bench, size: [f32; 2]) -> Harness<'static, Bench> {
    let mut shell = Shell::default();
    support::harness(bench, size, move |ui, bench| {
        shell.show(ui, &mut bench.context(), ground, |_, _| {});
    })
}

const WIDE: [f32; 2] = [1440.0, 900.0];
const NARROW: [f32; 2] = [1024.0, 700.0];

/// The window with the sample changed by `change`.
fn with(tokens: Tokens, change: impl FnOnce(&mut Bench, &mut Workspace)) -> Bench {
    let mut bench = Bench::new(tokens);
    let mut workspace = support::sample_workspace();
    change(&mut bench, &mut workspace);
    Bench { workspace: Some(workspace), ..bench }
}

fn asked(harness: &Harness<'_, Bench>, fits: impl Fn(&Action) -> bool) -> bool {
    harness.state().actions.iter().any(fits)
}

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
    let mut results = SnapshotResults::new();
    for (tokens, size, name) in [
        (Tokens::dark(), WIDE, "shell_dark"),
        (Tokens::light(), WIDE, "shell_light"),
        (Tokens::dark(), NARROW, "shell_narrow"),
    ] {
        let mut harness = window(Bench::new(tokens), size);
        harness.run();
        harness.snapshot(name);
        results.extend_harness(&mut harness);
    }
}

#[test]
fn a_window_without_a_clip_says_what_to_do() {
    let mut harness = window(Bench::empty(Tokens::light()), NARROW);
    harness.state_mut().options.queue_open = true;
    harness.run();
    harness.get_by_label("The frames of an open clip appear here");
    harness.snapshot("shell_empty");
}

#[test]
fn what_is_wrong_is_said_aloud() {
    let mut results = SnapshotResults::new();
    let running = Work::Running { stage: "object", share: 0.61, left: Some(8.0), paused: false };
    let failed =
        WorkFailure { stage: Some("hands".to_owned()), message: "the model has gone. Run doctor".to_owned() };
    let since = SystemTime::now() - Duration::from_secs(200);
    let full =
        SaveState::NotSaved { saved: 0, since, reason: "disk full. Free space or save elsewhere".to_owned() };
    let holder = LockHolder { program: "agenticfocus".to_owned(), pid: 4242 };
    for (name, bench) in [
        (
            "shell_work",
            with(Tokens::dark(), |bench, w| {
                (w.work, bench.options.step) = (running, Step::Masks);
                bench.options.selection = Some((FrameIndex(28), FrameIndex(37)));
            }),
        ),
        (
            "shell_not_saved",
            with(Tokens::dark(), |_, w| (w.save, w.exporting) = (full, Some((0.4, Some(75.0))))),
        ),
        (
            "shell_read_only",
            with(Tokens::light(), |_, w| {
                (w.access, w.work) = (Access::ReadOnly(holder), Work::Failed(failed));
            }),
        ),
    ] {
        let mut harness = window(bench, NARROW);
        harness.run();
        harness.snapshot(name);
        results.extend_harness(&mut harness);
    }
}

#[test]
fn a_failed_save_offers_a_way_out() {
    let since = SystemTime::now() - Duration::from_secs(200);
    let state = SaveState::NotSaved { saved: 0, since, reason: "disk full".to_owned() };
    let mut harness = window(with(Tokens::dark(), |_, w| w.save = state), NARROW);
    harness.run();
    harness.get_by_label("Not saved since 3 min ago: disk full");
    harness.get_by_label("Retry").click();
    harness.run();
    assert!(asked(&harness, |action| matches!(action, Action::Ask(Request::RetrySave))));
    harness.get_by_label(UiCommand::SaveElsewhere.text()).click();
    harness.run();
    assert!(asked(&harness, |action| matches!(action, Action::Run(UiCommand::SaveElsewhere))));
}

#[test]
fn chips_say_the_states_of_steps_and_lead_there() {
    let mut harness = window(Bench::new(Tokens::dark()), WIDE);
    harness.run();
    harness.get_by_label("Object: confirmed");
    let count = harness.state().workspace.as_ref().unwrap().problems().len();
    harness.get_by_label(&format!("Masks: {count} frames need a look")).click();
    harness.run();
    assert!(asked(&harness, |action| matches!(action, Action::SetStep(Step::Masks))));
}

#[test]
fn a_clip_of_the_queue_opens_by_a_click() {
    let mut harness = window(Bench::new(Tokens::dark()), WIDE);
    harness.run();
    harness.get_by_label("spoon_stir: not reviewed").click();
    harness.run();
    let wanted = PathBuf::from("/clips/spoon_stir.mp4");
    assert!(asked(&harness, |action| matches!(action, Action::Open(path) if *path == wanted)));
}

#[test]
fn the_queue_folds_away_in_a_narrow_window_and_comes_back() {
    let mut harness = window(Bench::new(Tokens::dark()), NARROW);
    harness.run();
    assert!(harness.query_by_label("spoon_stir: not reviewed").is_none());
    harness.set_size(WIDE.into());
    harness.run();
    harness.get_by_label("spoon_stir: not reviewed");
}

#[test]
fn a_typed_frame_or_time_is_gone_to() {
    let mut harness = window(Bench::new(Tokens::dark()), WIDE);
    harness.run();
    for (field, text, frame) in
        [("Frame", "33", 33), ("Time in seconds", "1.5", 45), ("Frame", "999", FRAMES - 1)]
    {
        harness.get_by_label(field).focus();
        harness.run();
        harness.get_by_label(field).type_text(text);
        harness.run();
        harness.key_press(Key::Enter);
        harness.run();
        let wanted = FrameIndex(frame);
        assert!(
            asked(&harness, |action| matches!(action, Action::Seek(at) if *at == wanted)),
            "{field} {text}"
        );
    }
}

#[test]
fn dragging_scrubs_and_with_shift_selects() {
    let mut harness = window(Bench::new(Tokens::dark()), WIDE);
    harness.run();
    let rect = harness.get_by_label("Timeline").rect();
    let y = rect.center().y;
    harness.drag_at(pos2(rect.left() + 400.0, y));
    harness.run();
    harness.hover_at(pos2(rect.left() + 700.0, y));
    harness.run();
    let seeks: Vec<FrameIndex> = harness
        .state()
        .actions
        .iter()
        .filter_map(|action| if let Action::Seek(frame) = action { Some(*frame) } else { None })
        .collect();
    assert!(seeks.first() < seeks.last(), "{seeks:?}");
    assert_eq!(harness.state().options.selection, None);
    harness.drop_at(pos2(rect.left() + 700.0, y));
    harness.run();

    harness.event(egui::Event::ModifiersChanged(Modifiers::SHIFT));
    harness.drag_at(pos2(rect.left() + 700.0, y));
    harness.run();
    harness.hover_at(pos2(rect.left() + 400.0, y));
    harness.run();
    let (first, last) = harness.state().options.selection.unwrap();
    assert!(last.0 - first.0 > 5, "{first} to {last}");
}

#[test]
fn hovering_the_timeline_tells_who_made_a_frame_and_what_is_doubtful() {
    // The keyframes of the placement are joined: a thick line between them.
    let joined = Command::SetInterpolated { frame: FrameIndex(20), interpolated: true };
    let bench = with(Tokens::dark(), |_, workspace| {
        assert!(workspace.history.apply(Entry::Do(joined)).unwrap());
    });
    let mut harness = window(bench, WIDE);
    harness.run();
    let rect = harness.get_by_label("Timeline").rect();
    let x = rect.left() + 72.0 + (33.5 / 60.0) * (rect.width() - 84.0);
    harness.hover_at(pos2(x, rect.center().y));
    harness.run_steps(40);
    harness.get_by_label("Frame 33 · 1.10 s");
    harness.get_by_label_contains("overlaps little with the frame before");
    harness.get_by_label("between a person's frames 20 and 42");
    harness.snapshot("timeline_hover");
}

#[test]
fn the_palette_finds_and_runs_a_command() {
    let mut harness = window(Bench::new(Tokens::dark()), NARROW);
    harness.state_mut().options.palette_open = true;
    harness.run();
    harness.snapshot("palette");
    harness.get_by_label("Find a command").type_text("undo");
    harness.run();
    harness.key_press(Key::Enter);
    harness.run();
    assert!(asked(&harness, |action| matches!(action, Action::Run(UiCommand::Undo))));
    assert!(!harness.state().options.palette_open);
}

#[test]
fn the_palette_greys_what_cannot_be_done_and_does_not_run_it() {
    let mut harness = window(Bench::empty(Tokens::light()), NARROW);
    harness.state_mut().options.palette_open = true;
    harness.run();
    harness.get_by_label("Find a command").type_text("undo");
    harness.run();
    harness.key_press(Key::Enter);
    harness.run();
    assert!(!asked(&harness, |action| matches!(action, Action::Run(_))));
    assert!(harness.state().options.palette_open);
    harness.get_by_label_contains("No clip open");
    harness.snapshot("palette_blocked");
}

#[test]
fn arrow_keys_walk_the_palette() {
    let mut harness = window(Bench::new(Tokens::dark()), NARROW);
    harness.state_mut().options.palette_open = true;
    harness.run();
    harness.key_press(Key::ArrowDown);
    harness.run();
    harness.key_press(Key::Enter);
    harness.run();
    assert!(asked(&harness, |action| matches!(action, Action::Run(UiCommand::OpenFolder))));
}

#[test]
fn the_key_sheet_shows_every_command() {
    let mut results = SnapshotResults::new();
    for (tokens, size, name) in
        [(Tokens::dark(), WIDE, "key_sheet_dark"), (Tokens::light(), NARROW, "key_sheet_narrow")]
    {
        let mut harness = window(Bench::new(tokens), size);
        harness.state_mut().options.keys_open = true;
        harness.run();
        for command in UiCommand::all() {
            assert!(harness.query_all_by_label(command.text()).next().is_some(), "{command:?}");
        }
        harness.snapshot(name);
        results.extend_harness(&mut harness);
    }
}

#[test]
fn the_menu_opens() {
    let mut harness = window(Bench::new(Tokens::dark()), NARROW);
    harness.run();
    harness.get_by_label("Menu").click();
    harness.run();
    harness.get_by_label(UiCommand::OpenFolder.text());
    harness.snapshot("menu");
}

#[test]
fn a_button_that_cannot_be_pressed_says_so() {
    let mut harness = window(Bench::new(Tokens::dark()), NARROW);
    harness.run();
    let redo = harness.get_by_label(UiCommand::Redo.text());
    assert!(redo.accesskit_node().is_disabled(), "there is nothing to do again");
    assert!(!harness.get_by_label(UiCommand::Undo.text()).accesskit_node().is_disabled());
}

#[test]
fn the_palette_goes_to_the_step_of_a_command_first() {
    let mut harness = window(Bench::new(Tokens::dark()), NARROW);
    harness.state_mut().options.palette_open = true;
    harness.run();
    harness.get_by_label("Find a command").type_text("fit β");
    harness.run();
    harness.key_press(Key::Enter);
    harness.run();
    let actions = &harness.state().actions;
    assert!(
        matches!(actions[..], [Action::SetStep(Step::Retarget), Action::Run(UiCommand::FitBeta)]),
        "{actions:?}"
    );
}

#[test]
fn a_session_held_by_another_program_cannot_be_changed_but_looked_at() {
    let holder = LockHolder { program: "agenticfocus".to_owned(), pid: 4242 };
    let mut bench = with(Tokens::dark(), |bench, w| {
        (w.access, bench.options.step) = (Access::ReadOnly(holder), Step::Masks);
    });
    let cx = bench.context();
    for command in [UiCommand::Undo, UiCommand::Confirm, UiCommand::Grow, UiCommand::Trust] {
        let reason = blocked(&cx, command).unwrap();
        assert!(reason.contains("process 4242"), "{command:?}: {reason}");
    }
    for command in [UiCommand::NextFrame, UiCommand::NextProblem, UiCommand::Brush, UiCommand::Fit] {
        assert_eq!(blocked(&cx, command), None, "{command:?}");
    }
}

#[test]
fn large_text_keeps_every_step_in_sight() {
    let mut harness = window(Bench::new(Tokens::dark()), [760.0, 560.0]);
    harness.run();
    let window = harness.ctx.content_rect();
    for step in ["Object: confirmed", "Review: not run"] {
        let rect = harness.get_by_label(step).rect();
        assert!(window.contains_rect(rect), "{step} at {rect:?}");
    }
    harness.snapshot("shell_tiny");
}

#[test]
fn escape_closes_what_lies_over_the_window() {
    let mut harness = window(Bench::new(Tokens::dark()), NARROW);
    harness.state_mut().options.palette_open = true;
    harness.run();
    harness.key_press(Key::Escape);
    harness.run();
    assert!(!harness.state().options.palette_open);
    harness.state_mut().options.keys_open = true;
    harness.run();
    harness.key_press(Key::Escape);
    harness.run();
    assert!(!harness.state().options.keys_open);
}

#[test]
fn going_to_a_frame_puts_the_keyboard_into_its_field() {
    let mut shell = Shell::default();
    let mut asked_for = true;
    let mut harness = support::harness(Bench::new(Tokens::dark()), WIDE, move |ui, bench| {
        if std::mem::take(&mut asked_for) {
            assert!(shell.perform(UiCommand::GoToFrame, &mut bench.context()));
        }
        shell.show(ui, &mut bench.context(), ground, |_, _| {});
    });
    harness.run();
    assert!(harness.get_by_label("Frame").accesskit_node().is_focused());
}

#[test]
fn ctrl_and_wheel_zoom_the_timeline_at_the_pointer() {
    let mut harness = window(Bench::new(Tokens::light()), NARROW);
    harness.run();
    let rect = harness.get_by_label("Timeline").rect();
    harness.hover_at(pos2(rect.left() + 500.0, rect.top() + 30.0));
    harness.run();
    harness.event(egui::Event::Zoom(3.0));
    harness.run();
    harness.hover_at(pos2(100.0, 100.0));
    harness.run();
    harness.snapshot("timeline_zoomed");
}

#[test]
fn every_frame_is_drawn_as_what_it_is() {
    let workspace = support::sample_workspace();
    let rows = Rows::new(&workspace);
    for frame in FrameIndex::all(workspace.frame_count()) {
        let human = rows.object.human.iter().any(|(at, _)| *at == frame.0);
        let in_runs: Vec<_> =
            rows.object.runs.iter().filter(|r| (r.first..=r.last).contains(&frame.0)).collect();
        assert_eq!(human, workspace.document().object_masks.contains_key(&frame), "{frame}");
        assert!(in_runs.len() + usize::from(human) <= 1, "{frame} is drawn twice");
        let doubtful = in_runs.iter().any(|run| run.kind != MaskKind::Machine);
        assert_eq!(doubtful, workspace.is_problem(frame), "{frame}");
    }
    for pair in rows.object.runs.windows(2) {
        assert!(pair[0].last + 1 < pair[1].first || pair[0].kind != pair[1].kind, "{pair:?} is one run");
    }
}

#[test]
fn nine_thousand_frames_are_looked_at_once() {
    let mut bench = Bench::new(Tokens::dark());
    bench.workspace = Some(long_workspace(9_000));
    let mut shell = Shell::default();
    let mut harness = support::harness(bench, WIDE, move |ui, bench| {
        shell.show(ui, &mut bench.context(), ground, |_, _| {});
        assert_eq!(shell.timeline.times_computed(), 1);
    });
    harness.run();
    harness.state_mut().workspace.as_mut().unwrap().playhead = FrameIndex(4_000);
    harness.run();
    harness.snapshot("timeline_long");
}
