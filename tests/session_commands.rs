//! Every command can be taken back, is kept as it was given, and leaves no trace where it could not be kept.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "support/commands.rs"]
mod commands;

use agenticfocus::session::{Author, Command, Document, Entry, History, Session, SessionError};
use commands::{KINDS, command, entries, human_command, kind, machine_command, refused_command};
use proptest::{prelude::*, strategy::ValueTree as _, test_runner::TestRunner};

/// Every bit of it: `==` takes −0 for 0.
fn bits(value: &impl std::fmt::Debug) -> String {
    format!("{value:?}")
}

fn author(entry: &Entry) -> Author {
    if matches!(entry, Entry::Found(_)) { Author::Machine("test".to_owned()) } else { Author::Human }
}

/// What a person did and what a machine found, kept apart.
#[derive(Default)]
struct Model {
    states: Vec<Document>,
    at: usize,
    found: Document,
}

impl Model {
    /// What the person made of the document, with what the machine found in it.
    fn document(&self) -> Document {
        let mut document = self.states[self.at].clone();
        document.proposals.clone_from(&self.found.proposals);
        document.object_answer.clone_from(&self.found.object_answer);
        document.clip.content_hash.clone_from(&self.found.clip.content_hash);
        document
    }

    fn apply(&mut self, entry: Entry) {
        match entry {
            Entry::Do(command) => {
                let mut next = self.states[self.at].clone();
                next.apply(command).unwrap();
                self.states.truncate(self.at + 1);
                self.states.push(next);
                self.at += 1;
            }
            Entry::Found(command) => {
                self.found.apply(command).unwrap();
            }
            Entry::Undo => self.at = self.at.saturating_sub(1),
            Entry::Redo => self.at = (self.at + 1).min(self.states.len() - 1),
            Entry::Create(_) => unreachable!("never drawn"),
        }
    }
}

#[test]
fn the_commands_drawn_here_are_all_there_are() {
    let mut runner = TestRunner::deterministic();
    let mut drawn = [false; KINDS];
    for _ in 0..2000 {
        drawn[kind(&command().new_tree(&mut runner).unwrap().current())] = true;
    }
    assert_eq!(drawn, [true; KINDS]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn undo_after_any_entry_restores_the_document_bit_for_bit(
        entries in entries(command(), command()), last in command(),
    ) {
        let mut history = History::new(Document::default());
        for entry in entries {
            history.apply(entry).unwrap();
        }
        let (before, depth) = (bits(history.document()), history.undo_depth());
        history.apply(Entry::Do(last)).unwrap();
        let after = bits(history.document());
        prop_assert_eq!((history.undo_depth(), history.redo_depth()), (depth + 1, 0));
        for _ in 0..2 {
            prop_assert!(history.apply(Entry::Undo).unwrap());
            prop_assert_eq!(bits(history.document()), before.clone());
            prop_assert!(history.apply(Entry::Redo).unwrap());
            prop_assert_eq!(bits(history.document()), after.clone());
        }
    }

    #[test]
    fn undo_and_redo_walk_through_what_a_person_did_and_leave_what_a_machine_found(
        entries in entries(human_command(), machine_command()),
    ) {
        let mut history = History::new(Document::default());
        let mut model = Model { states: vec![Document::default()], ..Model::default() };
        for entry in entries {
            history.apply(entry.clone()).unwrap();
            model.apply(entry);
            prop_assert_eq!(bits(history.document()), bits(&model.document()));
            prop_assert_eq!(history.undo_depth(), model.at);
            prop_assert_eq!(history.redo_depth(), model.states.len() - 1 - model.at);
        }
        while history.apply(Entry::Undo).unwrap() {}
        prop_assert_eq!(bits(history.document()), bits(&model.found));
    }

    #[test]
    fn a_refused_entry_leaves_the_history_as_before(
        entries in entries(command(), command()), fine in command(), refused in refused_command(),
    ) {
        let mut history = History::new(Document::default());
        for entry in entries {
            history.apply(entry).unwrap();
        }
        let before = bits(&history);
        let together = Command::Together(vec![fine.clone(), Command::Together(vec![fine, refused.clone()])]);
        for command in [refused, together] {
            prop_assert!(history.apply(Entry::Do(command.clone())).is_err());
            prop_assert_eq!(bits(&history), before.clone());
            prop_assert!(history.apply(Entry::Found(command)).is_err());
            prop_assert_eq!(bits(&history), before.clone());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn a_reopened_session_has_the_same_history(entries in entries(command(), command())) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.afs");
        let mut session = Session::create(&path, Document::default()).unwrap();
        let mut history = History::new(Document::default());
        for entry in entries {
            let taken = session.take(author(&entry), entry.clone()).unwrap();
            prop_assert_eq!(taken, history.apply(entry).unwrap());
        }
        prop_assert_eq!(bits(session.history()), bits(&history));
        drop(session);
        prop_assert_eq!(bits(Session::open(&path).unwrap().0.history()), bits(&history));
    }
}

/// A disk that is full for one file: files of this process may not grow beyond a limit.
#[cfg(unix)]
mod full_disk {
    use std::{fs, io::Write as _, path::Path, process::Command as Process};

    use super::*;

    const LIMITED: &str = "AGENTICFOCUS_TEST_LIMITED";

    /// The size beyond which no file of this process grows.
    fn limit(folder: &Path) -> usize {
        fs::File::create(folder.join("probe")).unwrap().write(&vec![0; 1 << 20]).unwrap()
    }

    /// Leaves room for a part of a line, by findings, so that undo and redo stay as they are.
    fn fill(session: &mut Session, limit: usize) {
        let journal = session.folder().join("journal.jsonl");
        let length = || fs::metadata(&journal).unwrap().len() as usize;
        let mut find = |letters: usize| {
            let found = Entry::Found(Command::SetContentHash("x".repeat(letters)));
            session.take(Author::Machine("test".to_owned()), found).unwrap();
        };
        let before = length();
        find(0);
        let frame = length() - before;
        find(limit - length() - frame - 40);
        assert!((1..80).contains(&(limit - length())));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn an_entry_that_cannot_be_written_leaves_the_session_as_before(
            kept in entries(command(), command()), lost in entries(command(), command()),
        ) {
            if std::env::var_os(LIMITED).is_none() {
                return Ok(());
            }
            let folder = tempfile::tempdir().unwrap();
            let limit = limit(folder.path());
            let path = folder.path().join("clip.afs");
            let mut session = Session::create(&path, Document::default()).unwrap();
            for entry in kept {
                session.take(author(&entry), entry).unwrap();
            }
            fill(&mut session, limit);
            let (before, edits) = (bits(session.history()), session.human_edits());
            let journal = fs::read(path.join("journal.jsonl")).unwrap();
            for entry in lost {
                let nothing_to_do = match &entry {
                    Entry::Undo => session.history().undo_depth() == 0,
                    Entry::Redo => session.history().redo_depth() == 0,
                    _ => false,
                };
                match session.take(author(&entry), entry) {
                    Ok(taken) => prop_assert!(nothing_to_do && !taken),
                    Err(error) => prop_assert!(matches!(error, SessionError::Io { .. }), "{}", error),
                }
                prop_assert_eq!(bits(session.history()), before.clone());
                prop_assert_eq!(session.human_edits(), edits);
                prop_assert_eq!(&fs::read(path.join("journal.jsonl")).unwrap(), &journal);
            }
            drop(session);
            let (session, report) = Session::open(&path).unwrap();
            prop_assert_eq!((bits(session.history()), report.torn_bytes), (before, 0));
        }
    }

    #[test]
    fn a_full_disk_loses_nothing() {
        let name = "full_disk::an_entry_that_cannot_be_written_leaves_the_session_as_before";
        let output = Process::new("sh")
            .args(["-c", "trap '' XFSZ; ulimit -f 256; exec \"$0\" --exact \"$1\""])
            .arg(std::env::current_exe().unwrap())
            .arg(name)
            .env(LIMITED, "1")
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.contains("1 passed"), "{said}");
    }
}
