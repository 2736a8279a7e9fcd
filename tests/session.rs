//! The session document keeps every acknowledged command, whatever happens to the program.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

use std::{
    collections::BTreeMap,
    fs,
    sync::atomic::{AtomicBool, Ordering},
};

use agenticfocus::{
    clip::FrameIndex,
    geometry::{Pixel, Side, Size},
    image::Mask,
    retarget::Beta,
    segment::RleMask,
    session::{
        Author, Command, Document, Entry, HandEdit, History, MaskEdit, MaskLayer, RetargetSettings,
        ReviewState, Session, SessionError, SessionLock, parse_journal,
    },
};
use proptest::prelude::*;

fn mask_bits() -> impl Strategy<Value = Mask> {
    (1_u32..9, 1_u32..9).prop_flat_map(|(width, height)| {
        prop::collection::vec(any::<bool>(), (width * height) as usize).prop_map(move |bits| {
            Mask::from_fn(Size::new(width, height), |x, y| bits[(y * width + x) as usize])
        })
    })
}

fn command() -> impl Strategy<Value = Command> {
    let frame = (0_u32..4).prop_map(FrameIndex);
    let side = prop_oneof![Just(Side::Left), Just(Side::Right)];
    let layer = prop_oneof![Just(MaskLayer::Object), Just(MaskLayer::Arms)];
    let leaf = prop_oneof![
        prop::option::of("[a-z ]{0,12}").prop_map(Command::SetTask),
        (layer, frame.clone(), any::<bool>()).prop_map(|(layer, frame, absent)| Command::SetMask {
            layer,
            frame,
            edit: absent.then_some(MaskEdit::Absent)
        }),
        prop::option::of(frame.clone()).prop_map(Command::SetTemplateFrame),
        (frame, side, 0_u8..21, any::<bool>(), -1e6..1e6_f64).prop_map(|(frame, side, index, invalid, x)| {
            let keypoints = BTreeMap::from([(index, Pixel::new(x, x / 3.0))]);
            Command::SetHandEdit { frame, side, edit: Some(HandEdit { keypoints, invalid }) }
        }),
        (0.05..5.0_f64).prop_map(|beta| Command::SetRetarget(RetargetSettings {
            beta: Some(Beta::Fixed(beta)),
            ..RetargetSettings::default()
        })),
        Just(Command::SetReview(ReviewState::Accepted)),
    ];
    leaf.prop_recursive(2, 8, 3, |inner| prop::collection::vec(inner, 0..3).prop_map(Command::Together))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn run_lengths_return_the_mask_bit_for_bit(mask in mask_bits()) {
        let rle = RleMask::encode(&mask);
        prop_assert_eq!(rle.decode(), mask.clone());
        prop_assert_eq!(rle.area() as usize, mask.area());
        let text = serde_json::to_string(&rle).unwrap();
        prop_assert_eq!(serde_json::from_str::<RleMask>(&text).unwrap(), rle);
    }

    #[test]
    fn run_lengths_are_taken_away_pixel_by_pixel((one, other) in (mask_bits(), mask_bits())) {
        let fitting = Mask::from_fn(one.size(), |x, y| other.get(x % other.size().width, y % other.size().height));
        let left = RleMask::encode(&one).minus(&RleMask::encode(&fitting));
        prop_assert_eq!(left, RleMask::encode(&one.minus(&fitting)));
        let strange = RleMask::empty(Size::new(one.size().width + 1, one.size().height));
        prop_assert_eq!(RleMask::encode(&one).minus(&strange), RleMask::encode(&one));
    }

    #[test]
    fn undo_takes_every_command_back_and_redo_does_it_again(commands in prop::collection::vec(command(), 1..12)) {
        let mut history = History::new(Document::default());
        let mut states = vec![history.document().clone()];
        for command in commands {
            history.apply(Entry::Do(command)).unwrap();
            states.push(history.document().clone());
        }
        for state in states.iter().rev().skip(1) {
            prop_assert!(history.apply(Entry::Undo).unwrap());
            prop_assert_eq!(history.document(), state);
        }
        prop_assert!(!history.apply(Entry::Undo).unwrap());
        for state in states.iter().skip(1) {
            prop_assert!(history.apply(Entry::Redo).unwrap());
            prop_assert_eq!(history.document(), state);
        }
    }
}

#[test]
fn a_journal_cut_at_any_byte_loads_to_the_commands_before_the_cut() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.afs");
    let mut session = Session::create(&path, Document::default()).unwrap();
    for task in ["a", "b", "c"] {
        session.apply(Author::Human, Command::SetTask(Some(task.to_owned()))).unwrap();
    }
    session.undo(Author::Human).unwrap();
    drop(session);
    let bytes = fs::read(path.join("journal.jsonl")).unwrap();
    let ends: Vec<usize> =
        bytes.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(i, _)| i + 1).collect();
    for cut in 0..=bytes.len() {
        let parsed = parse_journal(&bytes[..cut]).unwrap();
        assert_eq!(parsed.lines.len(), ends.iter().filter(|end| **end <= cut).count(), "cut at {cut}");
    }
}

#[test]
fn reopening_cuts_a_torn_line_off_and_keeps_undo() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.afs");
    let mut session = Session::create(&path, Document::default()).unwrap();
    session.apply(Author::Human, Command::SetTask(Some("pour".to_owned()))).unwrap();
    drop(session);
    let journal = path.join("journal.jsonl");
    let mut bytes = fs::read(&journal).unwrap();
    bytes.extend_from_slice(b"{\"crc\":1,\"li");
    fs::write(&journal, &bytes).unwrap();
    let (mut session, report) = Session::open(&path).unwrap();
    assert_eq!(report.torn_bytes, 12);
    assert_eq!(session.document().task.as_deref(), Some("pour"));
    session.apply(Author::Human, Command::SetTask(Some("stir".to_owned()))).unwrap();
    drop(session);
    let (mut session, report) = Session::open(&path).unwrap();
    assert_eq!(report.torn_bytes, 0);
    assert!(session.undo(Author::Human).unwrap());
    assert!(session.undo(Author::Human).unwrap());
    assert_eq!(session.document().task, None);
}

#[test]
fn damage_in_the_middle_is_an_error_that_names_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.afs");
    let mut session = Session::create(&path, Document::default()).unwrap();
    for task in ["a", "b"] {
        session.apply(Author::Human, Command::SetTask(Some(task.to_owned()))).unwrap();
    }
    drop(session);
    let journal = path.join("journal.jsonl");
    let text = fs::read_to_string(&journal).unwrap().replacen("\"a\"", "\"z\"", 1);
    fs::write(&journal, text).unwrap();
    let error = Session::open(&path).unwrap_err();
    assert!(matches!(error, SessionError::Damaged { line: 2, .. }), "{error}");
}

#[test]
fn a_newer_format_is_refused_and_left_untouched() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.afs");
    drop(Session::create(&path, Document::default()).unwrap());
    let snapshot = path.join("session.json");
    let text = fs::read_to_string(&snapshot).unwrap().replacen("\"version\": 1", "\"version\": 2", 1);
    fs::write(&snapshot, &text).unwrap();
    let error = Session::open(&path).unwrap_err();
    assert!(matches!(error, SessionError::NewerVersion { found: 2, .. }), "{error}");
    assert_eq!(fs::read_to_string(&snapshot).unwrap(), text);
}

#[test]
fn a_second_writer_is_told_who_holds_the_session() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.afs");
    let session = Session::create(&path, Document::default()).unwrap();
    let error = SessionLock::take(&path).unwrap_err();
    assert!(matches!(&error, SessionError::Locked(holder) if holder.pid == std::process::id()), "{error}");
    assert!(Session::open_read_only(&path).is_ok());
    drop(session);
    assert!(Session::open(&path).is_ok());
}

/// A process that is just being started has copies of all files for a moment.
#[test]
fn a_lock_ends_with_its_session_while_other_processes_are_started() {
    let folder = tempfile::tempdir().unwrap();
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let starts = || {
            while !done.load(Ordering::Relaxed) {
                std::process::Command::new("true").status().unwrap();
            }
        };
        scope.spawn(starts);
        scope.spawn(starts);
        let taken = (0..2000).try_for_each(|_| SessionLock::take(folder.path()).map(drop));
        done.store(true, Ordering::Relaxed);
        taken.unwrap();
    });
}

#[test]
fn a_refused_command_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.afs");
    let mut session = Session::create(&path, Document::default()).unwrap();
    let settings = RetargetSettings { alpha: Some(0.0), ..RetargetSettings::default() };
    let together =
        Command::Together(vec![Command::SetTask(Some("x".to_owned())), Command::SetRetarget(settings)]);
    assert!(session.apply(Author::Human, together).is_err());
    assert_eq!(session.document(), &Document::default());
    drop(session);
    assert_eq!(Session::open(&path).unwrap().0.document(), &Document::default());
}

#[test]
fn a_mask_is_stored_by_content_and_checked_when_read() {
    let folder = tempfile::tempdir().unwrap();
    let session = Session::create(&folder.path().join("clip.afs"), Document::default()).unwrap();
    let mask = RleMask::encode(&Mask::from_fn(Size::new(5, 4), |x, y| x > 1 && y != 2));
    let id = session.masks().put(&mask).unwrap();
    assert_eq!(session.masks().put(&mask).unwrap(), id);
    assert_eq!(session.masks().get(&id).unwrap(), mask);
    let path = session.folder().join("masks").join(format!("{id}.rle"));
    fs::write(&path, b"{}").unwrap();
    assert!(session.masks().get(&id).is_err());
}
