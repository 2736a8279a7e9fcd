//! A made-up session for tests of the window: 60 frames of 320×240, two arms, a cup that is carried, and
//! something of everything that a panel has to show. Everything is computed, so it is the same on every run.
#![allow(dead_code, reason = "every test binary uses its own part of this")]
#![allow(clippy::unwrap_used, reason = "a sample that cannot be made is a failed test")]

mod findings;
pub mod puppet;
mod scene;

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

use agenticfocus::{
    clip::FrameIndex,
    engine::{
        Access, Finding, Layers, Opened, PictureKind, PictureRequest, QueueItem, Revision, SaveState, Shown,
    },
    geometry::Size,
    session::{
        Author, ClipReference, Command, Document, Entry, HandEdit, History, LayerOrder, LayerOrderRange,
        MaskEdit, MaskId, MaskLayer, ObjectPromptKind, ObjectProposal, ReviewState, SidesSwapped, Step,
    },
};
use agenticfocus_ui::{
    action::Action,
    state::{Context, Options, Pictures, Queue, Workspace},
    theme::Tokens,
};

#[allow(unused_imports, reason = "every test binary uses its own part of this")]
pub use scene::{FRAMES, SIZE};

/// Everything a panel is handed, owned.
pub struct Bench {
    pub workspace: Option<Workspace>,
    pub queue: Queue,
    pub options: Options,
    pub pictures: Pictures,
    pub tokens: Tokens,
    pub recent: Vec<PathBuf>,
    pub demo: Option<PathBuf>,
    pub actions: Vec<Action>,
}

impl Bench {
    /// The sample session in the middle of work.
    pub fn new(tokens: Tokens) -> Self {
        Self {
            workspace: Some(sample_workspace()),
            queue: sample_queue(),
            options: Options::default(),
            pictures: sample_pictures(),
            tokens,
            recent: Vec::new(),
            demo: None,
            actions: Vec::new(),
        }
    }

    /// A window that was just started.
    pub fn empty(tokens: Tokens) -> Self {
        Self { workspace: None, queue: Queue::default(), pictures: Pictures::default(), ..Self::new(tokens) }
    }

    /// What `show` of a panel takes.
    pub fn context(&mut self) -> Context<'_> {
        Context {
            workspace: self.workspace.as_ref(),
            queue: &self.queue,
            options: &mut self.options,
            pictures: &mut self.pictures,
            tokens: &self.tokens,
            recent: &self.recent,
            demo: self.demo.as_deref(),
            actions: &mut self.actions,
        }
    }
}

fn frame(index: u32) -> FrameIndex {
    FrameIndex(index)
}

/// Three proposals, the best first.
pub fn sample_proposals() -> Vec<ObjectProposal> {
    let machine = || Author::Machine("evidence".to_owned());
    let boxed = |at: u32| ObjectPromptKind::Box(scene::object_box(at));
    vec![
        ObjectProposal {
            label: "cup".to_owned(),
            frame: frame(8),
            prompt: boxed(8),
            confidence: 0.86,
            reason: "moves with the right hand from 0.7 s on".to_owned(),
            author: machine(),
        },
        ObjectProposal {
            label: "lid".to_owned(),
            frame: frame(8),
            prompt: ObjectPromptKind::Box(scene::still_box()),
            confidence: 0.41,
            reason: "near the left hand, does not move".to_owned(),
            author: machine(),
        },
        ObjectProposal {
            label: "table edge".to_owned(),
            frame: frame(0),
            prompt: ObjectPromptKind::Points { positive: vec![scene::table_point()], negative: Vec::new() },
            confidence: 0.12,
            reason: "straight, ends at the picture's border".to_owned(),
            author: machine(),
        },
    ]
}

fn sample_document(ids: &[MaskId; 3]) -> Document {
    let proposals = sample_proposals();
    let chosen = ObjectProposal { author: Author::Human, ..proposals[0].clone() };
    let mut document = Document {
        clip: ClipReference {
            id: "cup_lid".to_owned(),
            path: "/clips/cup_lid.mp4".to_owned(),
            content_hash: "0".repeat(64),
            ..ClipReference::default()
        },
        task: Some("take the lid off the cup".to_owned()),
        object: Some(chosen),
        proposals,
        sides_swapped: vec![SidesSwapped { first: frame(10), last: frame(12) }],
        layer_orders: vec![LayerOrderRange {
            first: frame(25),
            last: frame(34),
            order: LayerOrder::ObjectInFront,
            thumb: Some(true),
        }],
        confirmed: [Step::Object].into(),
        ..Document::default()
    };
    document.object_masks = BTreeMap::from([
        (frame(0), MaskEdit::Mask(ids[0].clone())),
        (frame(30), MaskEdit::Mask(ids[1].clone())),
        (frame(50), MaskEdit::Absent),
    ]);
    document.arm_masks = BTreeMap::from([(frame(12), MaskEdit::Mask(ids[2].clone()))]);
    document.template.placements = [20, 42].map(|at| (frame(at), scene::placement(at))).into();
    let dragged = HandEdit { keypoints: [(8, scene::keypoints(1, 15)[8])].into(), invalid: false };
    document.hand_edits.right.insert(frame(15), dragged);
    document.hand_edits.left.insert(frame(36), HandEdit { keypoints: BTreeMap::new(), invalid: true });
    document
}

/// The sample session as the engine opens it.
fn sample_opened() -> Opened {
    let masks = [scene::object_mask(0), scene::object_mask(30), scene::arms_mask(12)].map(Arc::new);
    let ids = [0, 1, 2].map(|at: usize| MaskId::of(&masks[at]).unwrap());
    let mut history = History::new(sample_document(&ids));
    for command in [
        Command::SetTask(Some("take the lid off the cup".to_owned())),
        Command::SetMask {
            layer: MaskLayer::Object,
            frame: frame(30),
            edit: Some(MaskEdit::Mask(ids[1].clone())),
        },
    ] {
        assert!(history.apply(Entry::Do(command)).unwrap());
    }
    Opened {
        folder: PathBuf::from("/clips/cup_lid.afs"),
        history,
        masks: ids.into_iter().zip(masks).collect(),
        access: Access::Writable,
        notes: Vec::new(),
    }
}

/// The sample session as an engine tells of it.
pub fn sample_session() -> (Opened, Vec<Finding>) {
    let found = findings::sample_findings();
    let findings = vec![
        Finding::Clip(found.clip.unwrap()),
        Finding::Landmarks(found.landmarks.unwrap()),
        Finding::Arms(found.arms.unwrap()),
        Finding::Choice(found.choice),
        Finding::Object(found.object.unwrap()),
        Finding::Template(found.template),
        Finding::Background(found.background.unwrap()),
        Finding::Hands(found.hands.unwrap()),
        Finding::Motion(found.motion.unwrap()),
        Finding::Order(found.order.unwrap()),
    ];
    (sample_opened(), findings)
}

/// The sample session with everything found out.
pub fn sample_workspace() -> Workspace {
    let mut workspace = Workspace::new(sample_opened());
    workspace.found = findings::sample_findings();
    workspace.worked_for = Some(workspace.revision);
    workspace.playhead = frame(22);
    workspace.changes_sent = 2;
    workspace.save = SaveState::Saved(2);
    workspace
}

/// Every source frame and thumbnail, the composite of the sample's playhead, and a view from outside.
pub fn sample_pictures() -> Pictures {
    let mut pictures = Pictures::default();
    let mut put = |at: u32, kind, revision, shown| {
        pictures.take(PictureRequest { frame: frame(at), kind, revision }, Ok(shown));
    };
    for at in 0..FRAMES {
        let source = scene::source(at);
        let small = scene::shrunk(&source, 36);
        put(at, PictureKind::Thumbnail { height: 36 }, Revision(0), Shown::Picture(Arc::new(small)));
        put(at, PictureKind::Source, Revision(0), Shown::Picture(source));
    }
    put(22, PictureKind::Composite, Revision(1), Shown::Layers(Arc::new(sample_layers(22))));
    let size = Size::new(296, 200);
    let camera = agenticfocus::engine::OrbitCamera::default();
    let orbit = Shown::Picture(Arc::new(scene::orbit(size)));
    put(22, PictureKind::Orbit { camera, size }, Revision(1), orbit);
    pictures
}

/// The layers of one frame.
pub fn sample_layers(at: u32) -> Layers {
    let background = scene::background();
    let (robot, object, front) = scene::layers(at);
    let mut composite = background.clone();
    for layer in [&robot, &object, &front] {
        layer.draw_over(&mut composite);
    }
    Layers { composite, background, robot, object: Some(object), front }
}

/// Six clips, one in every state.
pub fn sample_queue() -> Queue {
    let item = |id: &str, review, flags: &[&str], at: u32| QueueItem {
        id: id.to_owned(),
        path: PathBuf::from(format!("/clips/{id}.mp4")),
        review,
        flags: flags.iter().map(|flag| (*flag).to_owned()).collect(),
        exported: false,
        thumbnail: Some(Arc::new(scene::shrunk(&scene::source(at), 48))),
        fault: None,
    };
    let flagged = ReviewState::Flagged { reason: "thumb in the cup".to_owned(), note: String::new() };
    let rejected = ReviewState::Rejected { reason: "hand out of view".to_owned(), note: String::new() };
    let doubt = ReviewState::NeedsReview { reason: "two objects are as likely".to_owned() };
    let mut items = vec![
        item("blocks_stack", ReviewState::Accepted, &[], 50),
        item("cup_lid", ReviewState::Unreviewed, &[], 22),
        item("drawer_open", doubt, &["truncated", "variable_frame_rate"], 30),
        item("pan_scrape_with_a_wooden_spoon", flagged, &[], 40),
        item("put_plate", rejected, &[], 10),
        item("spoon_stir", ReviewState::Unreviewed, &[], 5),
        item("wipe_board", ReviewState::Unreviewed, &[], 0),
    ];
    items[0].exported = true;
    items[6].thumbnail = None;
    items[6].fault = Some("The file has gone. Put it back or remove it from the manifest".to_owned());
    Queue { path: Some(PathBuf::from("/clips")), items }
}

/// The sample with `count` frames, for tests of long clips: masks are shared, findings repeat.
pub fn long_workspace(count: usize) -> Workspace {
    let mut workspace = sample_workspace();
    findings::lengthen(&mut workspace.found, count);
    workspace
}

/// A harness-sized picture of nothing, where a test needs one.
pub fn blank(size: Size) -> agenticfocus::image::Rgb8 {
    agenticfocus::image::Rgb8::new(size)
}

/// A mask of the sample's size with a square in it.
pub fn square_mask() -> agenticfocus::image::Mask {
    agenticfocus::image::Mask::from_fn(SIZE, |x, y| (40..80).contains(&x) && (40..80).contains(&y))
}

/// A harness of the given size that draws `show` with the bench, light or dark as the bench's tokens say.
pub fn harness<'a>(
    bench: Bench,
    size: [f32; 2],
    mut show: impl FnMut(&mut egui::Ui, &mut Bench) + 'a,
) -> egui_kittest::Harness<'a, Bench> {
    egui_kittest::Harness::builder()
        .with_size(size)
        .with_max_steps(16)
        .with_os(egui::os::OperatingSystem::Nix)
        .wgpu()
        .build_ui_state(
            move |ui, bench: &mut Bench| {
                agenticfocus_ui::theme::apply(ui.ctx(), &bench.tokens);
                ui.painter().rect_filled(ui.ctx().content_rect(), 0.0, bench.tokens.panel);
                show(ui, bench);
            },
            bench,
        )
}
