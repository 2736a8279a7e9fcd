//! The engine of an interactive program: opens, finds out, shows and exports exactly what the batch does.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "support/program.rs"]
mod program;
mod support;

use std::{
    fs,
    path::{Path, PathBuf},
    sync::{
        Arc, Condvar, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use agenticfocus::{
    clip::FrameIndex,
    engine::{
        Change, Engine, Event, Finding, LocalEngine, Opened, PictureKind, PictureRequest, Request, Revision,
        SaveState, Shown,
    },
    pipeline::Installation,
    session::{Author, Command, Document, Entry, RetargetSettings},
};

/// An engine and everything it told so far.
struct Operator {
    engine: LocalEngine,
    woken: Arc<(Mutex<bool>, Condvar)>,
}

impl Operator {
    fn new(out: &Path) -> Self {
        Self::with_fault(out, Arc::default())
    }

    /// An engine of which the next job panics as soon as `fault` is set.
    fn with_fault(out: &Path, fault: Arc<AtomicBool>) -> Self {
        let woken = Arc::new((Mutex::new(false), Condvar::new()));
        let waker = {
            let woken = Arc::clone(&woken);
            Arc::new(move || {
                assert!(!fault.swap(false, Ordering::Relaxed), "made up by a test");
                *woken.0.lock().unwrap() = true;
                woken.1.notify_all();
            })
        };
        Self { engine: LocalEngine::start(out.to_owned(), Installation::locate(), waker), woken }
    }

    /// Waits for the first event that `pick` takes.
    fn wait<T>(&self, mut pick: impl FnMut(Event) -> Option<T>) -> T {
        let end = Instant::now() + Duration::from_secs(240);
        loop {
            while let Some(event) = self.engine.poll() {
                if let Event::WorkEnded { result: Err(Some(failure)), .. } = &event {
                    panic!("{failure:?}");
                }
                if let Event::Decided { author, command, .. } = &event {
                    let (author, entry) = (author.clone(), Entry::Found(command.clone()));
                    self.engine.send(Request::Keep(Change { author, entry, masks: Vec::new() }));
                }
                if let Some(found) = pick(event) {
                    return found;
                }
            }
            assert!(Instant::now() < end, "the engine did not answer in time");
            let woken = self.woken.0.lock().unwrap();
            let (mut woken, _) = self.woken.1.wait_timeout(woken, Duration::from_millis(200)).unwrap();
            *woken = false;
        }
    }

    fn open(&self, path: &Path) -> Opened {
        self.engine.send(Request::Open(path.to_owned()));
        self.wait(|event| match event {
            Event::Opened(opened) => Some(*opened),
            Event::NotOpened { message, .. } => panic!("{message}"),
            _ => None,
        })
    }

    fn work(&self, document: &Document, revision: u64) {
        let document = Arc::new(document.clone());
        self.engine.send(Request::Work { document, revision: Revision(revision) });
    }

    fn wait_for_work(&self, revision: u64) {
        self.wait(|event| match event {
            Event::WorkEnded { revision: ended, result } if ended == Revision(revision) => Some(result),
            _ => None,
        })
        .unwrap();
    }

    fn composite(&self, frame: u32, revision: u64) -> Arc<agenticfocus::engine::Layers> {
        let (frame, revision) = (FrameIndex(frame), Revision(revision));
        self.engine.send(Request::Show(PictureRequest { frame, kind: PictureKind::Composite, revision }));
        self.wait(|event| match event {
            Event::Picture { request, result } if request.kind == PictureKind::Composite => {
                Some(result.unwrap())
            }
            _ => None,
        })
        .layers()
    }
}

trait LayersOf {
    fn layers(self) -> Arc<agenticfocus::engine::Layers>;
}

impl LayersOf for Shown {
    fn layers(self) -> Arc<agenticfocus::engine::Layers> {
        match self {
            Self::Layers(layers) => layers,
            Self::Picture(_) => panic!("a picture without layers"),
        }
    }
}

/// What was shown is what the export kept, pixel for pixel, the absent object included.
fn assert_layers(shown: &agenticfocus::engine::Layers, kept: &Path, name: &str) {
    let file = |layer: &str| kept.join(layer).join(name);
    let pixels = |layer: &str| {
        let reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(file(layer)).unwrap()));
        let mut reader = reader.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        pixels
    };
    let same = |layer: &str, data: &[u8]| assert!(pixels(layer) == data, "{layer} of {name} differs");
    same("composite", shown.composite.data());
    same("background", shown.background.data());
    same("robot", shown.robot.data());
    same("front", shown.front.data());
    match &shown.object {
        Some(object) => same("object", object.data()),
        None => assert!(!file("object").exists()),
    }
}

fn manifest_in(folder: &Path) -> PathBuf {
    support::episode(folder);
    support::manifest(folder, &["clip"], "")
}

#[test]
fn a_session_worked_on_through_the_engine_exports_what_the_batch_exports() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = manifest_in(folder.path());
    let out = folder.path().join("window");
    let operator = Operator::new(&out);
    operator.engine.send(Request::Survey(manifest.clone()));
    let items = operator.wait(|event| match event {
        Event::Queue { items, .. } => Some(items),
        _ => None,
    });
    assert_eq!(items.len(), 1);
    operator.wait(|event| match event {
        Event::QueueThumbnail { item, .. } => (item == items[0].path).then_some(()),
        _ => None,
    });
    let mut opened = operator.open(&items[0].path);
    operator.work(opened.history.document(), 1);
    operator.wait_for_work(1);
    let before = operator.composite(10, 1);

    // A change of the operator's: shown at once, and kept.
    let settings = RetargetSettings {
        alpha: Some(0.3),
        beta: Some(agenticfocus::retarget::Beta::Fixed(0.6)),
        ..RetargetSettings::default()
    };
    let entry = Entry::Do(Command::SetRetarget(settings));
    opened.history.apply(entry.clone()).unwrap();
    operator.engine.send(Request::Keep(Change { author: Author::Human, entry, masks: Vec::new() }));
    operator.work(opened.history.document(), 2);
    let motion = operator.wait(|event| match event {
        Event::Found { revision: Revision(2), finding: Finding::Motion(motion) } => Some(motion),
        _ => None,
    });
    assert!((motion.map.beta - 0.6).abs() < 1e-12);
    let after = operator.composite(10, 2);
    assert_ne!(before.composite, after.composite);
    assert_eq!(before.background, after.background);

    let previews: Vec<_> = (0..20).map(|frame| operator.composite(frame, 2)).collect();
    operator.engine.send(Request::Export);
    let exported = operator.wait(|event| match event {
        Event::Exported(result) => Some(result.unwrap()),
        _ => None,
    });
    operator.engine.send(Request::Close);
    drop(operator);

    let batch = folder.path().join("batch");
    let run = program::batch(&[&opened.folder], &batch, &[]);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let mut names = support::files(&exported);
    assert_eq!(names, support::files(&batch.join("clip")));
    names.retain(|name| name != Path::new("report.json"));
    assert!(names.len() > 40);
    for name in names {
        let same =
            fs::read(exported.join(&name)).unwrap() == fs::read(batch.join("clip").join(&name)).unwrap();
        assert!(same, "{} differs", name.display());
    }

    // With its layers it is made again, as the preview showed it.
    let run = program::batch(&[&opened.folder], &batch, &["--layers"]);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    for (frame, layers) in previews.iter().enumerate() {
        assert_layers(layers, &batch.join("clip/layers"), &format!("{frame:06}.png"));
    }
    let video = |folder: &Path| fs::read(folder.join("composite.mp4")).unwrap();
    assert!(video(&exported) == video(&batch.join("clip")));
}

#[test]
fn a_folder_that_cannot_be_written_loses_nothing_and_saving_resumes() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = manifest_in(folder.path());
    let operator = Operator::new(&folder.path().join("out"));
    operator.engine.send(Request::Survey(manifest));
    let path = operator.wait(|event| match event {
        Event::Queue { items, .. } => Some(items[0].path.clone()),
        _ => None,
    });
    let opened = operator.open(&path);
    // A folder where the journal's masks must go stands in for a full disk: root may write anywhere.
    let masks = opened.folder.join("masks");
    fs::remove_dir_all(&masks).ok();
    fs::write(&masks, b"in the way").unwrap();
    let size = agenticfocus::geometry::Size::new(320, 240);
    let mask = Arc::new(agenticfocus::segment::RleMask::empty(size));
    let id = agenticfocus::session::MaskId::of(&mask).unwrap();
    let edit = Some(agenticfocus::session::MaskEdit::Mask(id.clone()));
    let layer = agenticfocus::session::MaskLayer::Object;
    let command = Command::SetMask { layer, frame: FrameIndex(3), edit };
    let entry = Entry::Do(command);
    operator.engine.send(Request::Keep(Change { author: Author::Human, entry, masks: vec![(id, mask)] }));
    let entry = Entry::Do(Command::SetTask(Some("after it".to_owned())));
    operator.engine.send(Request::Keep(Change { author: Author::Human, entry, masks: Vec::new() }));
    operator.wait(|event| matches!(event, Event::Save(SaveState::NotSaved { saved: 0, .. })).then_some(()));
    fs::remove_file(&masks).unwrap();
    operator.engine.send(Request::RetrySave);
    operator.wait(|event| matches!(event, Event::Save(SaveState::Saved(2))).then_some(()));
    drop(operator);
    let (session, _) = agenticfocus::session::Session::open(&opened.folder).unwrap();
    assert_eq!(session.document().task.as_deref(), Some("after it"));
    assert!(session.document().object_masks.contains_key(&FrameIndex(3)));
}

#[test]
fn a_panic_in_a_job_ends_that_job_with_a_message_and_the_engine_lives_on() {
    let folder = tempfile::tempdir().unwrap();
    let clip = folder.path().join("clip.mp4");
    support::episode(folder.path());
    let fault = Arc::new(AtomicBool::new(false));
    let operator = Operator::with_fault(&folder.path().join("out"), Arc::clone(&fault));
    let opened = operator.open(&clip);
    let document = opened.history.document();
    fault.store(true, Ordering::Relaxed);
    operator.work(document, 1);
    let end = Instant::now() + Duration::from_secs(60);
    let failure = loop {
        match operator.engine.poll() {
            Some(Event::WorkEnded { result, .. }) => break result.unwrap_err().unwrap(),
            _ => assert!(Instant::now() < end),
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    assert!(failure.message.contains("made up by a test") && failure.message.contains("session is safe"));
    operator.work(document, 2);
    operator.wait(|event| matches!(event, Event::Found { finding: Finding::Clip(_), .. }).then_some(()));
}

#[test]
fn what_cannot_be_opened_is_said_and_the_engine_lives_on() {
    let folder = tempfile::tempdir().unwrap();
    let operator = Operator::new(&folder.path().join("out"));
    let refused = |path: PathBuf| {
        operator.engine.send(Request::Open(path));
        operator.wait(|event| match event {
            Event::NotOpened { message, .. } => Some(message),
            Event::Opened(_) => panic!("opened"),
            _ => None,
        })
    };
    assert!(refused(folder.path().join("gone.mp4")).contains("gone.mp4"));
    let corrupt = folder.path().join("bad.afs");
    fs::create_dir(&corrupt).unwrap();
    fs::write(corrupt.join("journal.jsonl"), b"{}\n{}\n{}\n").unwrap();
    assert!(refused(corrupt).contains("journal"));
    let text = folder.path().join("text.mp4");
    fs::write(&text, b"no video").unwrap();
    let opened = operator.open(&text);
    operator
        .engine
        .send(Request::Work { document: Arc::new(opened.history.document().clone()), revision: Revision(1) });
    let end = Instant::now() + Duration::from_secs(30);
    let failure = loop {
        match operator.engine.poll() {
            Some(Event::WorkEnded { result, .. }) => break result.unwrap_err().unwrap(),
            _ => assert!(Instant::now() < end),
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    assert!(failure.message.contains("text.mp4"), "{failure:?}");
}
