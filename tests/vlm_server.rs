//! A model behind a real HTTP server, with all that servers do: what it says is a proposal, what goes wrong is a line, and
//! the key is seen by the server alone.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "support/chat_server.rs"]
mod chat_server;

use std::{
    cell::RefCell,
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, Instant},
};

use agenticfocus::{
    clip::{FrameIndex, FramesInMemory},
    geometry::{PerSide, PixelBox, Size},
    image::{Mask, Rgb8},
    landmarks::LandmarkTrack,
    progress::{Unwatched, Watch},
    segment::{MaskAuthor, MaskFrame, MaskTrack, RleMask},
    select::{
        ObjectSelector as _, SelectInput,
        vlm::{BaseUrl, Profile, ProfileOrigin, Secret, VlmError, VlmSelector, VlmServer, answers},
    },
    session::{Author, ObjectAnswer, ObjectPromptKind, Said},
};
use chat_server::{Act, ChatServer};
use serde_json::json;

const CANARY: &str = "canary-3f9c71aa";
/// Sent at 672×672, so that the model's thousandths are the clip's.
const SIZE: Size = Size::new(448, 448);

/// Eight frames whose left half is arm.
struct Clip {
    frames: FramesInMemory,
    landmarks: LandmarkTrack,
    arms: MaskTrack,
}

impl Clip {
    fn new() -> Self {
        let frames = FramesInMemory::new(vec![Rgb8::new(SIZE); 8]).unwrap();
        let mask = RleMask::encode(&Mask::from_fn(SIZE, |x, _| x < 224));
        let frame = MaskFrame { mask, author: MaskAuthor::Seeded, score: 1.0, flags: Vec::new() };
        let arms = MaskTrack { size: SIZE, frames: vec![frame; 8], backend: String::new() };
        Self { frames, landmarks: vec![PerSide::default(); 8], arms }
    }

    fn input(&self) -> SelectInput<'_> {
        SelectInput { frames: &self.frames, landmarks: &self.landmarks, arms: &self.arms }
    }
}

fn server(url: &str) -> VlmServer {
    VlmServer {
        url: url.parse::<BaseUrl>().unwrap(),
        model: "test-model".to_owned(),
        profile: Profile::Rel1000Xyxy,
        profile_origin: ProfileOrigin::Given,
        connect_timeout: Duration::from_secs(1),
        total_timeout: Duration::from_secs(10),
        first_wait: Duration::from_millis(100),
        key: Secret::new(CANARY),
    }
}

/// What came of a question, and the lines that were said meanwhile.
struct Told {
    result: Result<ObjectAnswer, VlmError>,
    lines: Vec<String>,
}

impl Told {
    fn by(server: &VlmServer, watch: &dyn Watch) -> Self {
        let (clip, lines) = (Clip::new(), RefCell::new(Vec::new()));
        let say = |line: &str| lines.borrow_mut().push(line.to_owned());
        let selector = VlmSelector { server, task: Some("put the cup away"), clip: "hash", say: &say };
        let result = selector.ask(clip.input(), watch);
        let told = Self { result, lines: lines.into_inner() };
        told.assert_no_key();
        told
    }

    fn of(chat: &ChatServer) -> Self {
        Self::by(&server(&chat.url), &Unwatched)
    }

    /// Neither lines nor answer nor error hold the key, however they are printed.
    fn assert_no_key(&self) {
        let mut texts = self.lines.clone();
        match &self.result {
            Ok(answer) => texts.extend([format!("{answer:?}"), serde_json::to_string(answer).unwrap()]),
            Err(error) => texts.extend([error.to_string(), format!("{error:?}")]),
        }
        assert!(texts.iter().all(|text| !text.contains("canary")), "{texts:?}");
    }

    fn said(&self) -> &Said {
        match &self.result {
            Ok(answer) => &answer.said,
            Err(error) => panic!("{error}; {:?}", self.lines),
        }
    }

    fn object_box(&self) -> PixelBox {
        match self.said() {
            Said::Object(object) => match object.prompt {
                ObjectPromptKind::Box(bounds) => bounds,
                _ => panic!("{object:?}"),
            },
            other => panic!("{other:?}"),
        }
    }

    fn error(self) -> VlmError {
        self.result.map(|answer| panic!("{answer:?}")).unwrap_err()
    }
}

/// A good answer: on frame 4, right of the arm.
fn good() -> serde_json::Value {
    json!({"found": true, "object": "cup", "frame": 4, "x1": 600, "y1": 200, "x2": 800, "y2": 600, "px": 700,
        "py": 400, "hand": "right", "confidence": 0.9, "reason": "the right hand lifts it"})
}

fn good_with(key: &str, value: impl Into<serde_json::Value>) -> String {
    let mut answer = good();
    answer[key] = value.into();
    answer.to_string()
}

/// Whether `bounds` are the clip's pixels of that box.
fn is_good(bounds: PixelBox) -> bool {
    let at = |value: f64, thousandths: f64| (value - 0.448 * thousandths).abs() < 1e-9;
    at(bounds.x0, 600.0) && at(bounds.y0, 200.0) && at(bounds.x1, 800.0) && at(bounds.y1, 600.0)
}

#[test]
fn a_good_answer_is_a_proposal_and_what_was_sent_is_as_the_protocol_wants_it() {
    let chat = ChatServer::acting(&[Act::says(&good().to_string())]);
    let told = Told::of(&chat);
    let Said::Object(object) = told.said() else { panic!("{:?}", told.said()) };
    assert_eq!((object.label.as_str(), object.frame, object.confidence), ("cup", FrameIndex(4), 0.9));
    assert_eq!(object.author, Author::Machine("vlm test-model".to_owned()));
    assert_eq!(object.reason, "the right hand lifts it (right hand)");
    let asked = &chat.asked()[0];
    assert!(asked.head.starts_with("POST /v1/chat/completions HTTP/1.1"), "{}", asked.head);
    assert!(asked.head.contains(CANARY), "the server gets the key");
    assert_eq!((&asked.body["temperature"], &asked.body["max_tokens"]), (&json!(0), &json!(600)));
    assert_eq!(asked.body["response_format"]["type"], "json_schema");
    let content = asked.body["messages"][1]["content"].as_array().unwrap();
    assert!(content[0]["text"].as_str().unwrap().contains("put the cup away"));
    let urls: Vec<&str> = content.iter().filter_map(|part| part["image_url"]["url"].as_str()).collect();
    assert_eq!(urls.len(), 3);
    assert!(urls.iter().all(|url| url.starts_with("data:image/jpeg;base64,")));
    assert!(told.lines[0].contains("frames 0, 2, 4") && told.lines[0].contains("rel1000-xyxy (given)"));
}

#[test]
fn fenced_thinking_and_partial_answers_mean_the_same() {
    let answer = good().to_string();
    for choice in [
        json!({"message": {"content": format!("```json\n{answer}\n```")}}),
        json!({"message": {"content": format!("<think>a cup? {{maybe}} [1,2,3,4]</think>\n{answer}")}}),
        json!({"message": {"reasoning_content": "hm", "content": [{"type": "text", "text": answer}]}}),
        json!({"message": {"content": format!("Here: {answer}. Anything else?")}}),
    ] {
        assert!(is_good(Told::of(&ChatServer::acting(&[Act::chat(choice)])).object_box()));
    }
}

#[test]
fn an_answer_that_cannot_be_used_is_asked_again_once_with_the_reason() {
    let truncated = json!({"message": {"content": &good().to_string()[..70]}, "finish_reason": "length"});
    for (bad, reason) in [
        (Act::chat(truncated), "cut off"),
        (Act::says(r#"{"thing": "cup", "place": [1, 2]}"#), "place, thing"),
        (Act::says(&good_with("x2", 2900)), "outside"),
        (Act::says(&good_with("x1", 10)), "hand or arm"),
        (Act::says(&good_with("frame", 5)), "frame 5 was not sent"),
        (Act::says("I am sorry."), "no JSON"),
        (Act::says(""), "empty"),
    ] {
        // The box on the hand is all on it.
        let bad = match bad {
            Act::Answer(200, ..) if reason == "hand or arm" => {
                let mut answer = good();
                (answer["x1"], answer["x2"]) = (json!(10), json!(400));
                Act::says(&answer.to_string())
            }
            other => other,
        };
        let chat = ChatServer::acting(&[bad.clone(), Act::says(&good().to_string())]);
        let told = Told::of(&chat);
        assert!(is_good(told.object_box()), "{reason}");
        let messages = chat.asked()[1].body["messages"].as_array().unwrap().clone();
        assert_eq!(messages.len(), 4);
        assert!(messages[3]["content"].as_str().unwrap().contains(reason), "{}", messages[3]);
        assert_eq!(told.result.unwrap().raw.len(), 2);

        // Asked once more in vain, it is no error either.
        let chat = ChatServer::acting(&[bad]);
        let told = Told::of(&chat);
        assert!(matches!(told.said(), Said::Unusable(why) if why.contains(reason)), "{:?}", told.said());
        assert_eq!(chat.asked().len(), 2);
    }
}

#[test]
fn no_object_is_an_answer() {
    let told = Told::of(&ChatServer::acting(&[Act::says(r#"{"found": false, "reason": "only a table"}"#)]));
    assert_eq!(told.said(), &Said::Nothing("only a table".to_owned()));
}

#[test]
fn servers_without_schemas_are_asked_for_less() {
    let chat = ChatServer::start(|_, asked| match asked.body["response_format"]["type"].as_str() {
        Some(form) => Act::refuses(400, &format!("response_format {form} is not supported")),
        None => Act::says(&good().to_string()),
    });
    let told = Told::of(&chat);
    assert!(is_good(told.object_box()));
    let forms: Vec<_> =
        chat.asked().iter().map(|asked| asked.body["response_format"]["type"].clone()).collect();
    assert_eq!(forms, [json!("json_schema"), json!("json_object"), json!(null)]);
    // Another 400 is final.
    let chat = ChatServer::acting(&[Act::refuses(400, "image too large")]);
    assert!(matches!(Told::of(&chat).error(), VlmError::Refused { status: 400, .. }));
    assert_eq!(chat.asked().len(), 1);
}

#[test]
fn a_busy_server_is_asked_again_when_it_says_so_and_not_much_later() {
    let began = Instant::now();
    let busy = Act::refuses(429, "slow down");
    let chat = ChatServer::acting(&[busy.clone().with("Retry-After: 0.2"), Act::says(&good().to_string())]);
    assert!(is_good(Told::of(&chat).object_box()));
    let waited = began.elapsed().as_secs_f64();
    assert!((0.2..0.45).contains(&waited), "{waited}");
    let chat = ChatServer::acting(&[busy.with("Retry-After: 3600")]);
    let error = Told::of(&chat).error();
    assert!(matches!(&error, VlmError::Busy { wait, .. } if wait.as_secs() == 3600), "{error}");
    assert_eq!(chat.asked().len(), 1);
}

#[test]
fn a_server_that_stumbles_is_asked_three_times() {
    let stumbles = Act::refuses(500, "out of memory");
    let chat = ChatServer::acting(&[stumbles.clone(), Act::HangUp, Act::says(&good().to_string())]);
    assert!(is_good(Told::of(&chat).object_box()));
    let chat = ChatServer::acting(&[stumbles]);
    let error = Told::of(&chat).error();
    assert!(
        matches!(&error, VlmError::Refused { status: 500, said, .. } if said == "out of memory"),
        "{error}"
    );
    assert_eq!(chat.asked().len(), 3);
    // Nobody listens there.
    let nobody = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let told = Told::by(&server(&format!("http://{nobody}/v1")), &Unwatched);
    assert!(matches!(told.error(), VlmError::Connect { .. }));
}

#[test]
fn a_silent_server_is_not_waited_for_beyond_the_limit() {
    let chat = ChatServer::acting(&[Act::Silence]);
    let began = Instant::now();
    let short = VlmServer { total_timeout: Duration::from_millis(300), ..server(&chat.url) };
    let error = Told::by(&short, &Unwatched).error();
    assert!(matches!(&error, VlmError::Timeout { .. }), "{error}");
    assert!(began.elapsed() < Duration::from_millis(1500), "{:?}", began.elapsed());
}

#[test]
fn waiting_ends_at_once_when_nobody_wants_the_answer() {
    struct Soon(Instant, AtomicBool);
    impl Watch for Soon {
        fn advance(&self, _done: usize, _total: usize) {}
        fn is_cancelled(&self) -> bool {
            self.1.store(true, Ordering::Relaxed);
            self.0.elapsed() > Duration::from_millis(150)
        }
    }
    for act in [Act::Silence, Act::refuses(503, "soon").with("Retry-After: 9")] {
        let chat = ChatServer::acting(&[act]);
        let watch = Soon(Instant::now(), AtomicBool::new(false));
        let error = Told::by(&server(&chat.url), &watch).error();
        assert!(matches!(error, VlmError::Cancelled(_)), "{error}");
        assert!(watch.0.elapsed() < Duration::from_millis(600) && watch.1.load(Ordering::Relaxed));
    }
}

#[test]
fn a_flood_is_cut_short() {
    for announced in [true, false] {
        let chat = ChatServer::acting(&[Act::Flood { bytes: 100 << 20, announced }]);
        let began = Instant::now();
        let error = Told::of(&chat).error();
        assert!(matches!(error, VlmError::TooLarge { .. }), "{error}");
        assert!(began.elapsed() < Duration::from_secs(2), "{:?}", began.elapsed());
        assert_eq!(chat.asked().len(), 1);
    }
    // A small body that unpacks to a large one is a flood, too.
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::Write::write_all(&mut packed, &vec![b' '; 32 << 20]).unwrap();
    let bomb = Act::Answer(200, vec!["Content-Encoding: gzip".to_owned()], packed.finish().unwrap());
    assert!(matches!(Told::of(&ChatServer::acting(&[bomb])).error(), VlmError::TooLarge { .. }));
}

#[test]
fn what_is_no_chat_is_said() {
    for act in [
        Act::Answer(200, Vec::new(), b"<html>welcome</html>".to_vec()),
        Act::Answer(200, Vec::new(), b"{}".to_vec()),
        Act::Answer(200, Vec::new(), vec![0xff, 0xfe, 0]),
    ] {
        assert!(matches!(Told::of(&ChatServer::acting(&[act])).error(), VlmError::Protocol { .. }));
    }
    let moved = Act::refuses(307, "gone").with("Location: http://127.0.0.1:9/elsewhere");
    let chat = ChatServer::acting(&[moved]);
    assert!(matches!(Told::of(&chat).error(), VlmError::Refused { status: 307, .. }));
    assert_eq!(chat.asked().len(), 1);
}

#[test]
fn a_server_that_repeats_the_key_does_not_spread_it() {
    // `Told` looks for the key wherever it could have come to.
    let echo = format!("Incorrect API key provided: {CANARY}.");
    for act in [
        Act::refuses(401, &echo),
        Act::refuses(400, &format!("{}{CANARY}", "x".repeat(195))),
        Act::Answer(200, Vec::new(), echo.clone().into_bytes()),
        Act::says(&echo),
        Act::says(&good_with("reason", echo.clone())),
        Act::says(&good_with("object", CANARY)),
        Act::says(&format!(r#"{{"found": false, "reason": "{CANARY}"}}"#)),
        Act::says(&format!(r#"{{"{CANARY}": 1}}"#)),
        Act::says(&good().to_string().replace("lifts it", "lifts \\u0063anary-3f9c71aa")),
    ] {
        Told::of(&ChatServer::acting(&[act]));
    }
    let broken = VlmServer { key: Secret::new("canary\nX-Injected: 1"), ..server("http://127.0.0.1:9/v1") };
    let told = Told::by(&broken, &Unwatched);
    assert!(matches!(told.error(), VlmError::Key));
    assert!(!format!("{broken:?}").contains("canary"));
    let panic = std::panic::catch_unwind(|| panic!("{:?}", server("http://127.0.0.1:9/v1"))).unwrap_err();
    assert!(!panic.downcast_ref::<String>().unwrap().contains("canary"));
}

#[test]
fn the_same_question_has_the_same_answer_and_another_one_has_none() {
    let chat = ChatServer::acting(&[Act::says(&good().to_string())]);
    let (one, two) = (Told::of(&chat).result.unwrap(), Told::of(&chat).result.unwrap());
    assert_eq!(one, two);
    let bodies: Vec<_> = chat.asked().into_iter().map(|asked| asked.body).collect();
    assert_eq!(bodies[0], bodies[1]);
    let (task, any) = (Some("put the cup away"), (None, None));
    assert!(answers(&one, task, "hash", SIZE, any));
    assert!(answers(&one, task, "hash", SIZE, (Some("test-model"), Some(Profile::Rel1000Xyxy))));
    assert!(!answers(&one, task, "hash", SIZE, (Some("other"), None)));
    assert!(!answers(&one, task, "hash", SIZE, (None, Some(Profile::AbsXyxy))));
    assert!(!answers(&one, None, "hash", SIZE, any));
    assert!(!answers(&one, task, "other", SIZE, any));
}

#[test]
fn a_model_that_points_is_shown_one_frame() {
    let chat = ChatServer::acting(&[Act::says(r#"<point x="75" y="50" alt="cup">cup</point>"#)]);
    let pointing = VlmServer { profile: Profile::PctPoint, ..server(&chat.url) };
    let told = Told::by(&pointing, &Unwatched);
    let Said::Object(object) = told.said() else { panic!("{:?}", told.said()) };
    let ObjectPromptKind::Points { positive, .. } = &object.prompt else { panic!("{object:?}") };
    assert!((positive[0].x - 336.0).abs() < 1e-9 && (positive[0].y - 224.0).abs() < 1e-9);
    let body = &chat.asked()[0].body;
    assert_eq!(body["messages"][1]["content"].as_array().unwrap().len(), 3);
    assert!(body.get("response_format").is_none());

    let clip = Clip::new();
    let selector = VlmSelector { server: &pointing, task: None, clip: "hash", say: &|_| {} };
    let proposals = selector.select(clip.input(), &Unwatched).unwrap();
    assert_eq!((proposals.len(), proposals[0].backend.as_str()), (1, "vlm test-model"));
    assert_eq!(proposals[0].point, Some(positive[0]));
}
