//! What the window does when something goes wrong on the engine's side: it says so, and lives on.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

mod support;

use std::{
    path::{Path, PathBuf},
    time::SystemTime,
};

use agenticfocus::{
    engine::{Access, Event, Request, Revision, SaveState, WorkFailure},
    session::{Author, Command, LockHolder, ReviewState},
};
use agenticfocus_ui::{action::Action, state::Work, ui_command::UiCommand};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use support::puppet::{Window, opened};

fn keeps(requests: &[Request]) -> usize {
    requests.iter().filter(|request| matches!(request, Request::Keep(_))).count()
}

fn failure() -> WorkFailure {
    WorkFailure { stage: Some("clip".to_owned()), message: "cup.mp4 has gone: put it back".to_owned() }
}

#[test]
fn a_session_that_another_program_writes_to_is_shown_and_refuses_every_change_in_words() {
    let holder = LockHolder { program: "agenticfocus".to_owned(), pid: 4711 };
    let mut window = Window::with_session(Access::ReadOnly(holder));
    assert!(window.says("Read-only: agenticfocus (process 4711)"));
    let before = window.document();
    let set_task = || Command::SetTask(Some("stir".to_owned()));

    window.act(Action::Change(set_task()));
    assert!(window.says("Read-only: another program writes to this session"));
    for command in [UiCommand::Undo, UiCommand::Accept, UiCommand::Confirm] {
        window.act(Action::Run(command));
        let last = window.harness.state().messages().last().unwrap().text.clone();
        let refused = last.starts_with(command.text()) && last.contains("process 4711");
        assert!(refused, "{command:?}: {last}");
    }
    window.press(Modifiers::COMMAND, Key::Z);
    let (revision, author) = (Revision(0), Author::Machine("clip".to_owned()));
    window.tell(Event::Decided { revision, author, command: set_task() });

    assert_eq!(window.document(), before);
    assert_eq!(keeps(&window.asked()), 0);
}

#[test]
fn what_is_not_saved_is_said_loudly_until_it_is_saved() {
    let mut window = Window::with_session(Access::Writable);
    assert!(window.harness.query_by_label("Saved").is_some());
    window.act(Action::Change(Command::SetReview(ReviewState::Accepted)));
    assert_eq!(keeps(&window.asked()), 1);
    assert!(window.harness.query_by_label("Saved").is_none(), "nothing is saved before the engine says so");

    let (since, reason) = (SystemTime::now(), "no space left on /clips".to_owned());
    window.tell(Event::Save(SaveState::NotSaved { saved: 0, since, reason }));
    assert!(window.says("Not saved since") && window.says("no space left on /clips"));
    // Work goes on: the change stays on screen, and more may follow.
    window.act(Action::Change(Command::SetTask(None)));
    assert_eq!((window.document().review, window.document().task), (ReviewState::Accepted, None));
    assert_eq!(keeps(&window.asked()), 1);
    assert!(window.says("Not saved since"));

    window.click("Retry");
    assert!(window.asked().iter().any(|request| matches!(request, Request::RetrySave)));
    window.tell(Event::Save(SaveState::Saved(1)));
    assert!(!window.says("Not saved"));
    assert!(window.harness.query_by_label("Saved").is_none(), "one change is still on its way");
    window.tell(Event::Save(SaveState::Saved(2)));
    assert!(window.harness.query_by_label("Saved").is_some());
}

/// A file as the system hands it over.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("nobody reads it here".to_owned())
    }
}

#[test]
fn what_is_dropped_on_the_window_is_opened_and_what_cannot_be_opened_is_said() {
    let mut window = Window::new();
    let path = PathBuf::from("/clips/cup.mp4");
    window.harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path.clone())));
    window.harness.run_steps(2);
    assert!(window.asked().iter().any(|request| matches!(request, Request::Open(wanted) if *wanted == path)));
    let message = "the video has gone: put it back, or choose another file".to_owned();
    window.tell(Event::NotOpened { path, message });
    assert!(window.says("/clips/cup.mp4 not opened: the video has gone"));
    window.tell(Event::Opened(Box::new(opened(Access::Writable))));
    assert!(!window.says("not opened"), "the window lives on");
}

/// Closes the window as the system asks for it; whether it obeys.
fn closes(window: &mut Window) -> bool {
    let root = window.harness.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
    root.events.push(egui::ViewportEvent::Close);
    window.harness.step();
    let told = &window.harness.output().viewport_output[&egui::ViewportId::ROOT].commands;
    !told.contains(&egui::ViewportCommand::CancelClose)
}

#[test]
fn the_first_wish_to_close_is_held_while_changes_are_not_on_disk_and_the_second_is_obeyed() {
    let not_saved = || {
        let reason = "disk full".to_owned();
        Event::Save(SaveState::NotSaved { saved: 0, since: SystemTime::UNIX_EPOCH, reason })
    };
    let mut window = Window::with_session(Access::Writable);
    window.act(Action::Change(Command::SetReview(ReviewState::Accepted)));
    window.tell(not_saved());
    assert!(!closes(&mut window));
    window.harness.run_steps(2);
    assert!(window.says("1 change is not saved: disk full"));
    // Saving is tried again and again meanwhile.
    window.tell(not_saved());
    window.act(Action::Change(Command::SetReview(ReviewState::Unreviewed)));
    window.tell(not_saved());
    assert!(!closes(&mut window), "there is more to lose now");
    window.tell(not_saved());
    assert!(closes(&mut window));
}

#[test]
fn a_damaged_session_is_named_and_the_window_lives_on() {
    let damaged = |path: &Path| Event::NotOpened {
        path: path.to_owned(),
        message: "journal line 7 is damaged; the lines before it are whole".to_owned(),
    };
    let mut window = Window::new();
    let path = PathBuf::from("/clips/broken.afs");
    window.act(Action::Open(path.clone()));
    assert!(window.harness.state().is_opening());
    window.tell(damaged(&path));
    assert!(!window.harness.state().is_opening() && window.harness.state().workspace().is_none());
    assert!(window.says("/clips/broken.afs not opened: journal line 7 is damaged"));
    window.click("Close this message");
    assert!(!window.says("journal line 7"));

    // Another one opens, and a damaged one beside it takes nothing away.
    window.act(Action::Open(PathBuf::from("/clips/cup.afs")));
    window.tell(Event::Opened(Box::new(opened(Access::Writable))));
    window.act(Action::Open(path.clone()));
    window.tell(damaged(&path));
    assert!(window.says("/clips/broken.afs not opened"));
    window.asked();
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.document().task, None);
    assert_eq!(keeps(&window.asked()), 1);
}

#[test]
fn work_that_fails_is_explained_on_a_card_and_can_be_done_again() {
    let mut window = Window::with_session(Access::Writable);
    let revision = window.harness.state().workspace().unwrap().worked_for.unwrap();
    window.act(Action::Change(Command::SetTask(Some("stir".to_owned()))));
    window.asked();
    // Work that was replaced says nothing about how things stand.
    window.tell(Event::WorkEnded { revision, result: Err(Some(failure())) });
    assert!(!window.says("This clip cannot be shown"));

    let revision = window.harness.state().workspace().unwrap().worked_for.unwrap();
    window.tell(Event::WorkEnded { revision, result: Err(Some(failure())) });
    assert_eq!(window.harness.state().workspace().unwrap().work, Work::Failed(failure()));
    assert!(window.harness.query_by_label("This clip cannot be shown").is_some());
    assert!(window.harness.query_by_label("cup.mp4 has gone: put it back").is_some());

    window.act(Action::Run(UiCommand::Rerun));
    let again = |request: &Request| matches!(request, Request::Work { revision: at, .. } if *at == revision);
    assert!(window.asked().iter().any(again));
    window.tell(Event::Progress { stage: "clip", share: 0.3, left: None });
    assert!(!window.says("This clip cannot be shown"));
    window.tell(Event::WorkEnded { revision, result: Ok(()) });
    assert_eq!(window.harness.state().workspace().unwrap().work, Work::Idle);
}
