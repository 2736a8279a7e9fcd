//! A manifest says everything about its clips, or says on which line it does not.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

use std::{fs, path::PathBuf};

use agenticfocus::{
    clip::{CameraSpec, Rotation},
    pipeline::{ClipJob, jobs_from_inputs},
    retarget::{Beta, CameraRotation, Method, Smoothing, WristTurn},
    select::vlm::{Profile, VlmMode},
};

fn jobs(name: &str, text: &str) -> Result<Vec<ClipJob>, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    jobs_from_inputs(&[path]).map_err(|error| error.to_string())
}

const WHOLE: &str = r#"
[[clip]]
id = "blocks"
path = "blocks/blocks.mp4"
task = "move the block"
rotate = 180
object = { label = "block T", frame = 3, box = [920, 214, 1026, 320] }
camera = { hfov_deg = 60.0 }
hands = { track = "hands.npz", length_mm = 180 }
params = { method = "masquerade", shared_map = true, beta = "fit", alpha = 0.4, T_offset = [0.05, 0.0, 0.43], R_cam = { pitch_deg = 30.0 }, smoothing = "ema", wrist = { right = { yaw_deg = -6.0 } }, hole_dilation = 0.02 }
vlm = { mode = "live", model = "some-vlm", profile = "abs-xyxy" }
start = 1.0
end = 2.5
"#;

#[test]
fn every_key_of_the_schema_arrives_in_the_document() {
    let jobs = jobs("m.toml", WHOLE).unwrap();
    let [job] = jobs.as_slice() else { panic!("one clip expected") };
    let document = &job.document;
    assert_eq!(job.id, "blocks");
    assert!(document.clip.path.ends_with("blocks/blocks.mp4"));
    assert!(PathBuf::from(&document.clip.path).is_absolute());
    assert_eq!(document.task.as_deref(), Some("move the block"));
    assert_eq!(document.clip.rotate, Rotation::Deg180);
    assert_eq!((document.clip.start, document.clip.end), (Some(1.0), Some(2.5)));
    assert_eq!(document.camera, CameraSpec::HorizontalFov(60.0));
    assert!(document.hand_track.as_ref().unwrap().ends_with("hands.npz"));
    assert_eq!(document.retarget.method, Some(Method::Masquerade));
    assert_eq!(document.retarget.shared_map, Some(true));
    assert_eq!(document.retarget.beta, Some(Beta::Fit));
    assert_eq!(document.retarget.alpha, Some(0.4));
    assert_eq!(document.retarget.hand_length, Some(0.18));
    assert_eq!(document.retarget.smoothing, Some(Smoothing::Ema));
    assert_eq!(document.hole_dilation, Some(0.02));
    let wrist = document.retarget.wrist;
    assert_eq!((wrist.left, wrist.right.degrees()), (WristTurn::default(), [0.0, 0.0, -6.0]));
    let Some(CameraRotation::Angles(angles)) = document.retarget.camera_rotation else {
        panic!("angles expected")
    };
    assert!((angles.pitch_deg - 30.0).abs() < 1e-12);
    let object = job.object.as_ref().unwrap();
    assert_eq!((object.label.as_str(), object.source_frame), ("block T", 3));
    assert_eq!(object.bounds, Some([920.0, 214.0, 1026.0, 320.0]));
    let wish = (job.vlm.mode, job.vlm.model.as_deref(), job.vlm.profile);
    assert_eq!(wish, (Some(VlmMode::Live), Some("some-vlm"), Some(Profile::AbsXyxy)));
}

#[test]
fn a_manifest_cannot_say_where_pictures_and_the_key_are_sent() {
    let clip = "[[clip]]\npath = \"a.mp4\"\n";
    for key in ["url = \"http://elsewhere/v1\"", "key = \"canary\""] {
        let error = jobs("m.toml", &format!("{clip}vlm = {{ {key} }}\n")).unwrap_err();
        assert!(error.contains(":3:") && error.contains("unknown field"), "{error}");
        assert!(!error.contains("canary"), "{error}");
    }
}

#[test]
fn json_lines_take_the_same_schema() {
    let text = r#"{"path": "a.mp4", "params": {"beta": 0.8, "R_cam": [[0,-1,0],[-1,0,0],[0,0,-1]]}}

{"path": "b.mp4", "id": "second", "object": {"points": [[1, 2]], "negative": [[3, 4]]}}"#;
    let jobs = jobs("m.jsonl", text).unwrap();
    assert_eq!(jobs.iter().map(|job| job.id.as_str()).collect::<Vec<_>>(), ["a", "second"]);
    assert_eq!(jobs[0].document.retarget.beta, Some(Beta::Fixed(0.8)));
    assert_eq!(jobs[1].object.as_ref().unwrap().points, [[1.0, 2.0]]);
}

#[test]
fn an_unknown_key_is_named_with_its_line() {
    let text = "[[clip]]\npath = \"a.mp4\"\n\ncolour = 1\n";
    let error = jobs("m.toml", text).unwrap_err();
    assert!(error.contains(":4:") && error.contains("`colour`"), "{error}");
    let error = jobs("m.toml", "[[clip]]\npath = \"a.mp4\"\ncamera = { fov = 3 }\n").unwrap_err();
    assert!(error.contains(":3:") && error.contains("`fov`"), "{error}");
    let error = jobs("m.jsonl", "{\"path\": \"a.mp4\"}\n{\"path\": \"b.mp4\", \"colour\": 1}\n").unwrap_err();
    assert!(error.contains(":2:") && error.contains("`colour`"), "{error}");
}

#[test]
fn values_that_make_no_sense_are_refused_by_clip() {
    for (text, part) in [
        ("rotate = 45", "rotate"),
        ("camera = { fx = 1.0 }", "camera"),
        ("camera = { hfov_deg = 200.0 }", "hfov_deg"),
        ("start = 3.0\nend = 2.0", "start"),
        ("params = { alpha = 0.0 }", "alpha"),
        ("params = { method = \"theirs\" }", "theirs"),
        ("params = { beta = \"big\" }", "beta"),
        ("params = { hole_dilation = 0.2 }", "hole_dilation"),
        ("params = { wrist = { left = { roll_deg = 200.0 } } }", "wrist"),
        ("params = { wrist = { roll_deg = 2.0 } }", "roll_deg"),
        ("params = { R_cam = [[1.0,0.0,0.0],[0.0,1.0,0.0],[0.0,0.0,2.0]] }", "R_cam"),
        ("object = { label = \"x\" }", "object"),
        ("id = \"../up\"", "../up"),
    ] {
        let error = jobs("m.toml", &format!("[[clip]]\npath = \"a.mp4\"\n{text}\n")).unwrap_err();
        assert!(error.contains(part), "{text}: {error}");
    }
}

#[test]
fn two_clips_with_one_id_are_refused() {
    let error = jobs("m.jsonl", "{\"path\": \"x/a.mp4\"}\n{\"path\": \"y/a.mp4\"}\n").unwrap_err();
    assert!(error.contains("\"a\""), "{error}");
}
