//! Datasets made of finished clips: what trainers load, made anew after a kill, lengthened, and never in silence.
#![cfg(feature = "engine")]
#![expect(clippy::unwrap_used, reason = "a failure in a helper fails the test")]

#[path = "support/finished_clip.rs"]
mod finished_clip;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use agenticfocus::{
    export::{
        dataset::{
            ClipFate, DatasetError, DatasetFormat, DatasetOptions, DatasetReport, MOTOR_NAMES, ThumbOrder,
            export_dataset,
        },
        read_indexed, video_facts,
    },
    geometry::Size,
    image::Mask,
    progress::Unwatched,
    segment::{RleMask, counts_from_text},
};
use finished_clip::{Made, finished, masks};
use serde_json::{Value, json};

const FORMATS: [DatasetFormat; 5] = [
    DatasetFormat::LerobotV3,
    DatasetFormat::LerobotV21,
    DatasetFormat::UnitreeJson,
    DatasetFormat::Coco,
    DatasetFormat::Davis,
];

fn options(format: DatasetFormat) -> DatasetOptions {
    DatasetOptions { format, thumb_order: ThumbOrder::Hardware, include_rejected: false }
}

fn export(input: &Path, out: &Path, format: DatasetFormat) -> Result<DatasetReport, DatasetError> {
    export_dataset(&[input.to_owned()], out, &options(format), &Unwatched)
}

/// Every file below `folder` with its bytes; the lock says nothing.
fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.file_name().unwrap() != "lock" {
                all.insert(path.strip_prefix(folder).unwrap().to_owned(), fs::read(&path).unwrap());
            }
        }
    }
    all
}

fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn a_killed_export_started_again_and_one_that_is_lengthened_have_the_bytes_of_an_undisturbed_one() {
    let dir = tempfile::tempdir().unwrap();
    let (clips, more) = (dir.path().join("clips"), dir.path().join("more"));
    finished(&clips, &Made { id: "a", ..Made::default() });
    finished(&clips, &Made { id: "b", task: "pour", frames: 4, ..Made::default() });
    finished(&more, &Made { id: "c", frames: 5, ..Made::default() });
    for format in FORMATS {
        let at = |name: &str| dir.path().join(format!("{format:?}-{name}"));
        let (undisturbed, lengthened, killed) = (at("undisturbed"), at("lengthened"), at("killed"));
        let both = [clips.clone(), more.clone()];
        export_dataset(&both, &undisturbed, &options(format), &Unwatched).unwrap();
        let whole = bytes(&undisturbed);
        export(&clips, &lengthened, format).unwrap();
        let before = bytes(&lengthened);
        let report = export_dataset(&both, &lengthened, &options(format), &Unwatched).unwrap();
        assert_eq!(bytes(&lengthened), whole, "{format:?} lengthened");
        assert!(matches!(report.clips[0].fate, ClipFate::Present { episode: 0 }));
        assert!(matches!(report.clips[2].fate, ClipFate::Written { episode: 2 }));
        let own = |path: &PathBuf| path.starts_with("data") || path.starts_with("videos");
        assert!(before.iter().filter(|(path, _)| own(path)).all(|(path, old)| whole[path] == *old));
        // Killed while the last episode was written: files are there, half of one too, its note is not.
        export_dataset(&both, &killed, &options(format), &Unwatched).unwrap();
        fs::remove_file(killed.join(".agenticfocus/episode_000002.json")).unwrap();
        let last = whole.keys().rfind(|path| own(path));
        if let Some(last) = last {
            fs::write(killed.join(last), b"half").unwrap();
        }
        export_dataset(&both, &killed, &options(format), &Unwatched).unwrap();
        assert_eq!(bytes(&killed), whole, "{format:?} killed");
    }
}

#[test]
fn rejected_and_failed_clips_are_left_out_and_named() {
    let dir = tempfile::tempdir().unwrap();
    let clips = dir.path().join("clips");
    finished(&clips, &Made { id: "good", ..Made::default() });
    let review = json!({ "state": "rejected", "reason": "blurred", "note": "" });
    finished(&clips, &Made { id: "rejected", review, ..Made::default() });
    fs::create_dir_all(clips.join("worse")).unwrap();
    let failed = json!({ "id": "worse", "exit": "bad_input", "message": "no video stream" });
    fs::write(clips.join("worse/failed.json"), failed.to_string()).unwrap();
    let report = export(&clips, &dir.path().join("out"), DatasetFormat::LerobotV21).unwrap();
    let said: Vec<String> = report
        .clips
        .iter()
        .map(|row| match &row.fate {
            ClipFate::LeftOut { reason } => format!("{}: {reason}", row.id),
            other => format!("{}: {other:?}", row.id),
        })
        .collect();
    assert!(said[0].starts_with("good: Written"), "{said:?}");
    assert!(said[1].starts_with("rejected: rejected: blurred"), "{said:?}");
    assert!(said[2].starts_with("worse: the clip failed: no video stream"), "{said:?}");
    let all = DatasetOptions { include_rejected: true, ..options(DatasetFormat::LerobotV21) };
    let report = export_dataset(&[clips], &dir.path().join("all"), &all, &Unwatched).unwrap();
    assert_eq!(report.episodes, 2);
}

#[test]
fn another_folder_another_format_and_another_run_of_a_clip_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let (clips, out) = (dir.path().join("clips"), dir.path().join("out"));
    finished(&clips, &Made::default());
    assert!(matches!(export(&clips, dir.path(), DatasetFormat::Coco), Err(DatasetError::Foreign { .. })));
    export(&clips, &out, DatasetFormat::LerobotV3).unwrap();
    let other = export(&clips, &out, DatasetFormat::LerobotV21);
    assert!(matches!(other, Err(DatasetError::Other { what: "format", .. })));
    let swapped = DatasetOptions { thumb_order: ThumbOrder::UnitreeXr, ..options(DatasetFormat::LerobotV3) };
    let other = export_dataset(std::slice::from_ref(&clips), &out, &swapped, &Unwatched);
    assert!(matches!(other, Err(DatasetError::Other { what: "thumb order", .. })));
    finished(&clips, &Made { key: "second", ..Made::default() });
    assert!(matches!(
        export(&clips, &out, DatasetFormat::LerobotV3),
        Err(DatasetError::Changed { episode: 0, .. })
    ));
    assert!(matches!(
        export(&dir.path().join("out/data"), &out, DatasetFormat::LerobotV3),
        Err(DatasetError::NoClips { .. })
    ));
}

#[test]
fn a_record_or_a_mask_that_is_missing_or_damaged_is_an_error_that_names_the_file() {
    let dir = tempfile::tempdir().unwrap();
    let clips = dir.path().join("clips");
    finished(&clips, &Made::default());
    fs::remove_file(clips.join("clip/masks/hand/000003.png")).unwrap();
    for format in [DatasetFormat::Coco, DatasetFormat::Davis] {
        let error = export(&clips, &dir.path().join(format!("{format:?}")), format).unwrap_err();
        assert!(error.to_string().contains("masks/hand/000003.png"), "{error}");
    }
    fs::write(clips.join("clip/record.npz"), b"PK\x03\x04 no record").unwrap();
    let error = export(&clips, &dir.path().join("v3"), DatasetFormat::LerobotV3).unwrap_err();
    assert!(error.to_string().contains("record.npz") && error.exit_code() == 65, "{error}");
}

#[test]
fn a_clip_of_another_size_is_fitted_into_the_datasets_pictures() {
    let dir = tempfile::tempdir().unwrap();
    let clips = dir.path().join("clips");
    finished(&clips, &Made { id: "a", ..Made::default() });
    finished(&clips, &Made { id: "b", size: Size::new(80, 96), frames: 5, ..Made::default() });
    let out = dir.path().join("out");
    let report = export(&clips, &out, DatasetFormat::LerobotV3).unwrap();
    assert_eq!(report.clips[1].notes, ["video encoded again, 80×96 to 64×48"]);
    let key = "videos/observation.images.cam_left_high/chunk-000";
    let facts = video_facts(&out.join(key).join("file-001.mp4")).unwrap();
    assert_eq!((facts.size, facts.frames), (Size::new(64, 48), 5));
    let same = fs::read(clips.join("a/composite.mp4")).unwrap();
    assert_eq!(fs::read(out.join(key).join("file-000.mp4")).unwrap(), same, "the very file where it fits");
}

#[test]
fn coco_and_davis_give_every_mask_back_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    let (clips, size) = (dir.path().join("clips"), Made::default().size);
    finished(&clips, &Made::default());
    export(&clips, &dir.path().join("coco"), DatasetFormat::Coco).unwrap();
    let coco = read_json(&dir.path().join("coco/annotations/clip.json"));
    let annotations = coco["annotations"].as_array().unwrap();
    assert_eq!(annotations.len(), 2 * Made::default().frames);
    for annotation in annotations {
        let frame = annotation["image_id"].as_u64().unwrap() as usize - 1;
        let layer = annotation["category_id"].as_u64().unwrap() as usize - 1;
        let counts = counts_from_text(annotation["segmentation"]["counts"].as_str().unwrap()).unwrap();
        let mask = RleMask::from_counts(size, counts).unwrap().decode();
        assert_eq!(mask, masks(size, frame)[layer], "frame {frame}, layer {layer}");
        assert_eq!(annotation["area"].as_u64().unwrap() as usize, mask.area());
    }
    export(&clips, &dir.path().join("davis"), DatasetFormat::Davis).unwrap();
    for frame in 0..Made::default().frames {
        let path = dir.path().join(format!("davis/Annotations/clip/{frame:05}.png"));
        let (found, indices) = read_indexed(&path).unwrap();
        assert_eq!(found, size);
        for (bit, mask) in masks(size, frame).into_iter().enumerate() {
            let layer = Mask::from_fn(size, |x, y| indices[(y * size.width + x) as usize] >> bit & 1 == 1);
            assert_eq!(layer, mask, "frame {frame}, layer {bit}");
        }
    }
}

#[test]
fn unitrees_episode_has_a_picture_and_both_arms_and_hands_on_every_frame() {
    let dir = tempfile::tempdir().unwrap();
    let clips = dir.path().join("clips");
    finished(&clips, &Made::default());
    let order = DatasetOptions { thumb_order: ThumbOrder::UnitreeXr, ..options(DatasetFormat::UnitreeJson) };
    export_dataset(&[clips], &dir.path().join("out"), &order, &Unwatched).unwrap();
    let episode = dir.path().join("out/move_the_cup/episode_0001");
    let data = read_json(&episode.join("data.json"));
    assert_eq!(data["info"]["joint_names"]["left_ee"][1], MOTOR_NAMES[15]);
    assert_eq!(data["text"]["goal"], "move the cup");
    let items = data["data"].as_array().unwrap();
    assert_eq!(items.len(), Made::default().frames);
    for (index, item) in items.iter().enumerate() {
        assert!(episode.join(item["colors"]["color_0"].as_str().unwrap()).is_file());
        let expected = |column: usize| 0.5 + 0.5 * (0.1 * index as f64 + column as f64 + 4.0).sin();
        let hand = item["states"]["left_ee"]["qpos"].as_array().unwrap();
        let thumb: Vec<f64> = hand.iter().map(|value| value.as_f64().unwrap()).collect();
        assert!((thumb[0] - expected(1)).abs() < 1e-6 && (thumb[1] - expected(0)).abs() < 1e-6);
        assert_eq!(item["actions"]["right_arm"]["qpos"].as_array().unwrap().len(), 7);
    }
}

/// A Python with pyarrow and pandas, where there is one.
fn checker() -> Option<PathBuf> {
    let named = std::env::var_os("AGENTICFOCUS_CHECK_PYTHON").map(PathBuf::from);
    let usual = Path::new(env!("CARGO_MANIFEST_DIR")).join(".deps/checkers/bin/python");
    let python = named.unwrap_or(usual);
    let finds = Command::new(&python).args(["-c", "import pandas, pyarrow"]).output();
    finds.is_ok_and(|output| output.status.success()).then_some(python)
}

#[test]
fn lerobot_datasets_keep_the_formats_rules() {
    let Some(python) = checker() else {
        println!("skipped: no Python with pyarrow and pandas in .deps/checkers");
        return;
    };
    let dir = tempfile::tempdir().unwrap();
    let clips = dir.path().join("clips");
    finished(&clips, &Made { id: "a", ..Made::default() });
    finished(&clips, &Made { id: "b", task: "pour", frames: 65, ..Made::default() });
    finished(&clips, &Made { id: "c", frames: 4, ..Made::default() });
    for format in [DatasetFormat::LerobotV3, DatasetFormat::LerobotV21] {
        let out = dir.path().join(format!("{format:?}"));
        export(&clips, &out, format).unwrap();
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/check_lerobot.py");
        let output = Command::new(&python).arg(script).arg(&out).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{format:?}: {said}");
    }
}
