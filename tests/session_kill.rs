//! Whatever moment a program is killed at, the session keeps every command that it was told was kept.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

use std::{
    env,
    fs::{self, File},
    io::{self, BufRead as _, BufReader, Read as _, Write as _},
    path::Path,
    process::{Child, Command as Process, Stdio},
    sync::mpsc::{Receiver, channel},
    thread,
    time::Duration,
};

use agenticfocus::{
    clip::FrameIndex,
    geometry::Size,
    image::Mask,
    segment::RleMask,
    session::{
        Author, Command, Document, Entry, History, MaskEdit, MaskId, MaskLayer, ReviewState, Session,
        parse_journal,
    },
};

const KILLS: u64 = 50;
/// Set where this binary is the program that gets killed: the session, and the first line it writes.
const FOLDER: &str = "AGENTICFOCUS_TEST_KILLED_IN";
const FIRST: &str = "AGENTICFOCUS_TEST_KILLED_FROM";

fn mask(line: u64) -> RleMask {
    RleMask::encode(&Mask::from_fn(Size::new(32, 24), |x, y| u64::from(x * 7 + y * 5) % 11 < line % 11))
}

/// What the script does in journal line `line`; line 0 creates the session.
fn entry(line: u64) -> Entry {
    let frame = FrameIndex((line % 40) as u32);
    match line % 7 {
        0 => Entry::Do(Command::SetTask(Some(format!("task {line}")))),
        1 => Entry::Found(Command::SetContentHash(format!("{line:064x}"))),
        2 | 3 => {
            let edit = Some(MaskEdit::Mask(MaskId::of(&mask(line)).unwrap()));
            Entry::Do(Command::SetMask { layer: MaskLayer::Object, frame, edit })
        }
        4 => Entry::Undo,
        5 => Entry::Redo,
        _ => Entry::Do(Command::Together(vec![
            Command::SetTemplateFrame(Some(frame)),
            Command::SetReview(ReviewState::Flagged { reason: "look".repeat(400), note: line.to_string() }),
        ])),
    }
}

/// Edits until it is killed, saying which lines are on disk.
fn edit(folder: &Path, first: u64) {
    let (mut session, _) = Session::open(folder).unwrap();
    for line in first.. {
        if matches!(line % 7, 2 | 3) {
            session.masks().put(&mask(line)).unwrap();
        }
        assert!(session.take(Author::Human, entry(line)).unwrap(), "line {line}");
        io::stdout().write_all(format!("\nkept {line}\n").as_bytes()).unwrap();
        if line % 10 == 0 {
            session.save_snapshot().unwrap();
        }
    }
}

struct Editor {
    process: Child,
    kept: Receiver<u64>,
}

impl Editor {
    fn start(folder: &Path, first: u64) -> Self {
        let name = "a_program_killed_at_any_moment_loses_no_command_it_was_told_was_kept";
        let mut process = Process::new(env::current_exe().unwrap())
            .args(["--exact", name, "--nocapture"])
            .env(FOLDER, folder)
            .env(FIRST, first.to_string())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (tell, kept) = channel();
        let lines = BufReader::new(process.stdout.take().unwrap()).lines();
        thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                if let Some(number) = line.strip_prefix("kept ") {
                    tell.send(number.parse().unwrap()).unwrap();
                }
            }
        });
        Self { process, kept }
    }

    /// Kills it and returns the last line it said was kept.
    fn kill(mut self, mut last: Option<u64>) -> Option<u64> {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
        while let Ok(line) = self.kept.recv() {
            last = Some(line);
        }
        let mut complaint = String::new();
        self.process.stderr.take().unwrap().read_to_string(&mut complaint).unwrap();
        assert!(complaint.is_empty(), "{complaint}");
        last
    }
}

/// A number below `limit` that looks like chance.
fn chance(round: u64, limit: u64) -> u64 {
    let mixed = (round + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 33) % limit
}

#[test]
fn a_program_killed_at_any_moment_loses_no_command_it_was_told_was_kept() {
    if let (Some(folder), Ok(first)) = (env::var_os(FOLDER), env::var(FIRST)) {
        edit(Path::new(&folder), first.parse().unwrap());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.afs");
    drop(Session::create(&path, Document::default()).unwrap());
    let mut replayed = History::new(Document::default());
    let mut lines = 1;
    for round in 0..KILLS {
        let editor = Editor::start(&path, lines);
        // Most are killed while they write, some while they start or open the session.
        let heard = if round % 5 == 0 {
            None
        } else {
            Some(editor.kept.recv_timeout(Duration::from_secs(30)).unwrap())
        };
        thread::sleep(Duration::from_micros(chance(round, 20_000)));
        let kept = editor.kill(heard).map_or(lines, |line| line + 1);

        let (session, _) = Session::open(&path).unwrap();
        let mut bytes = Vec::new();
        File::open(path.join("journal.jsonl")).unwrap().read_to_end(&mut bytes).unwrap();
        let found = parse_journal(&bytes).unwrap().lines;
        let count = found.len() as u64;
        assert!((kept..=kept + 1).contains(&count), "round {round}: kept {kept}, found {count}");
        for line in lines..count {
            assert_eq!(found[line as usize].entry, entry(line), "round {round}");
            replayed.apply(entry(line)).unwrap();
        }
        assert_eq!(*session.history(), replayed, "round {round}");
        for edit in session.document().object_masks.values() {
            let MaskEdit::Mask(id) = edit else { panic!("{edit:?}") };
            session.masks().get(id).unwrap();
        }
        lines = count;
    }
    assert!(lines > KILLS, "only {lines} lines were written before the kills");
    assert!(fs::read_dir(path.join("masks")).unwrap().count() > 0);
}
