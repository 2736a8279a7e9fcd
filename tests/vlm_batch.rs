//! A batch that asks a model for the object: the answer is kept in the session, replayed without the network to the same
//! bytes, missed without harm, and the key is written nowhere.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "support/chat_server.rs"]
mod chat_server;
mod support;

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use agenticfocus::{
    clip::FrameIndex,
    geometry::Size,
    progress::Unwatched,
    session::{Author, Said, Session},
    synth::{Episode, EpisodeSpec, generate},
};
use base64::Engine as _;
use chat_server::{Act, Asked, ChatServer};
use opencv::core::MatTraitConst as _;
use serde_json::{Value, json};
use support::{files, hand_track};

const CANARY: &str = "canary-51d0e7";
const SIZE: Size = Size::new(256, 192);

fn batch(input: &Path, out: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_agenticfocus"));
    command.env("XDG_DATA_HOME", out.join("no-data")).env("AGENTICFOCUS_VLM_KEY", CANARY);
    command.arg("--batch").arg(input).arg("--out").arg(out).args(more);
    let output = command.output().unwrap();
    let told = [&output.stdout[..], &output.stderr[..]].concat();
    let told = String::from_utf8_lossy(&told);
    assert!(!told.contains("canary"), "{told}");
    assert!(output.status.success(), "{told}");
    output
}

/// The sizes of the pictures in a question.
fn pictures(asked: &Asked) -> Vec<(i32, i32)> {
    let content = asked.body["messages"][1]["content"].as_array().unwrap().clone();
    let urls = content.iter().filter_map(|part| part["image_url"]["url"].as_str());
    let size = |url: &str| {
        let text = url.strip_prefix("data:image/jpeg;base64,").unwrap();
        let bytes = base64::engine::general_purpose::STANDARD.decode(text).unwrap();
        let bytes = opencv::core::Vector::<u8>::from_slice(&bytes);
        let picture = opencv::imgcodecs::imdecode(&bytes, opencv::imgcodecs::IMREAD_COLOR).unwrap();
        (picture.cols(), picture.rows())
    };
    urls.map(size).collect()
}

fn backend(folder: &Path) -> Value {
    let text = fs::read(folder.join("record.json")).unwrap();
    serde_json::from_slice::<Value>(&text).unwrap()["backends"]["select"].clone()
}

#[test]
fn an_answer_is_kept_and_replayed_and_a_missing_one_costs_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("source");
    let spec = EpisodeSpec { seed: 2, size: SIZE, frames: 8, ..EpisodeSpec::default() };
    generate(&spec, &source, &Unwatched).unwrap();
    let episode = Episode::load(&source).unwrap();
    fs::write(source.join("hands.json"), hand_track(&episode).to_string()).unwrap();
    let manifest = source.join("clips.toml");
    let text =
        "[[clip]]\nid = \"a\"\npath = \"clip.mp4\"\ntask = \"move it\"\nhands = { track = \"hands.json\" }\n";
    fs::write(&manifest, text).unwrap();
    let truth = episode.object_visible(FrameIndex(0)).unwrap().bounding_box().unwrap();
    let chat = ChatServer::start(move |_, asked| {
        let (width, height) = pictures(asked)[0];
        assert!(width % 224 == 0 && height % 224 == 0 && width * height <= 1_003_520);
        let (width, height) = (f64::from(width), f64::from(height));
        let scale = (width / f64::from(SIZE.width)).min(height / f64::from(SIZE.height)).min(1.5);
        let x = |at: f64| (at * scale / width * 1000.0).round();
        let y = |at: f64| (at * scale / height * 1000.0).round();
        let answer = json!({"found": true, "object": "thing", "frame": 0, "x1": x(truth.x0), "y1": y(truth.y0),
            "x2": x(truth.x1), "y2": y(truth.y1), "px": 0, "py": 0, "hand": "none", "confidence": 0.8,
            "reason": format!("it is moved; your key is {CANARY}")});
        Act::says(&answer.to_string())
    });
    let out = folder.path().join("out");

    // Nobody listens: one clear line, and the clip is done all the same.
    let nobody = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let nowhere = format!("http://{nobody}/v1");
    let output = batch(&manifest, &out, &["--vlm-url", &nowhere, "--vlm-model", "test-vlm"]);
    let lines = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(lines.contains("test-vlm was not asked") && lines.contains("contact motion proposes"), "{lines}");
    assert_ne!(backend(&out.join("a")), "vlm test-vlm");

    // The same with a server: asked now, though the clip was done, and only once.
    for _ in 0..2 {
        batch(&manifest, &out, &["--vlm-url", &chat.url, "--vlm-model", "test-vlm"]);
        assert_eq!(chat.asked().len(), 1);
    }
    assert!(chat.asked()[0].head.contains(CANARY));
    assert_eq!(backend(&out.join("a")), "vlm test-vlm");
    let (session, _) = Session::open_read_only(&out.join("a.afs")).unwrap();
    let document = session.document();
    let answer = document.object_answer.clone().unwrap();
    let Said::Object(object) = &answer.said else { panic!("{answer:?}") };
    assert_eq!((answer.request.len(), answer.raw.len(), object.label.as_str()), (64, 1, "thing"));
    assert_eq!(object.author, Author::Machine("vlm test-vlm".to_owned()));
    assert_eq!(document.proposals.first(), Some(object));
    assert_eq!(session.history().undo_depth(), 0, "what a machine found is no step of undo");

    // Elsewhere and without the network, to the same bytes.
    let copy = folder.path().join("a.afs");
    for file in files(&out.join("a.afs")) {
        let to = copy.join(&file);
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(out.join("a.afs").join(&file), to).unwrap();
    }
    let replayed = folder.path().join("replayed");
    batch(&copy, &replayed, &["--vlm", "cache"]);
    assert_eq!(chat.asked().len(), 1);
    for file in ["record.npz", "record.json", "template.png", "masks/object/000007.png"] {
        let read = |out: &Path| fs::read(out.join("a").join(file)).unwrap();
        assert!(read(&out) == read(&replayed), "{file} differs");
    }
    for file in files(folder.path()) {
        let bytes = fs::read(folder.path().join(&file)).unwrap();
        assert!(!bytes.windows(6).any(|window| window == b"canary"), "the key is in {}", file.display());
    }
}
