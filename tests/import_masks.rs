//! Masks from elsewhere become a person's edits, bit for bit.
#![cfg(feature = "engine")]
#![expect(clippy::unwrap_used, reason = "a failure in a helper fails the test")]

#[path = "support/finished_clip.rs"]
mod finished_clip;

use std::{fs, path::Path};

use agenticfocus::{
    clip::FrameIndex,
    export::{
        dataset::{DatasetFormat, DatasetOptions, ThumbOrder, export_dataset},
        write_indexed,
    },
    geometry::Size,
    image::Mask,
    pipeline::{ClipFailure, ExitCode, FrameNumbering, LayerLabels, MaskImportReport, import_masks},
    progress::Unwatched,
    session::{ClipReference, Document, MaskEdit, MaskLayer, Session},
};
use finished_clip::{Made, finished, masks};
use serde_json::json;

const OURS: LayerLabels = LayerLabels { object: 1, arms: 2, both: Some(3) };

/// A session about the video of a finished clip, which lies in `folder/clips`.
fn session(folder: &Path) -> Session {
    finished(&folder.join("clips"), &Made::default());
    let path = folder.join("clips/clip/composite.mp4").to_string_lossy().into_owned();
    let clip = ClipReference { id: "clip".to_owned(), path, ..ClipReference::default() };
    Session::create(&folder.join("clip.afs"), Document { clip, ..Document::default() }).unwrap()
}

fn import(session: &mut Session, path: &Path) -> Result<MaskImportReport, ClipFailure> {
    import_masks(session, path, FrameNumbering::Timeline, &OURS, &Unwatched)
}

#[test]
fn exported_masks_come_back_as_human_edits_bit_for_bit() {
    for (format, at) in
        [(DatasetFormat::Coco, "annotations/clip.json"), (DatasetFormat::Davis, "Annotations/clip")]
    {
        let dir = tempfile::tempdir().unwrap();
        let mut session = session(dir.path());
        let out = dir.path().join("out");
        let options = DatasetOptions { format, thumb_order: ThumbOrder::Hardware, include_rejected: false };
        export_dataset(&[dir.path().join("clips")], &out, &options, &Unwatched).unwrap();
        let report = import(&mut session, &out.join(at)).unwrap();
        let frames = Made::default().frames;
        assert_eq!((report.object, report.arms, report.outside.len()), (frames, frames, 0), "{format:?}");
        drop(session);
        // Read anew: what is on disk counts.
        let (session, _) = Session::open(&dir.path().join("clip.afs")).unwrap();
        for frame in 0..frames {
            let expected = masks(Made::default().size, frame);
            for (layer, expected) in [MaskLayer::Object, MaskLayer::Arms].into_iter().zip(expected) {
                let edit = &session.document().masks(layer)[&FrameIndex(frame as u32)];
                let found = match edit {
                    MaskEdit::Absent => Mask::new(Made::default().size),
                    MaskEdit::Mask(id) => session.masks().get(id).unwrap().decode(),
                };
                assert_eq!(found, expected, "{format:?}, frame {frame}, {layer:?}");
            }
        }
    }
}

#[test]
fn what_belongs_to_no_layer_and_what_lies_outside_is_said() {
    let dir = tempfile::tempdir().unwrap();
    let mut session = session(dir.path());
    let (folder, size) = (dir.path().join("davis"), Made::default().size);
    fs::create_dir_all(&folder).unwrap();
    let mut indices = vec![0_u8; size.area()];
    indices[..10].fill(1);
    indices[20..25].fill(7);
    for frame in [2, 400] {
        write_indexed(&folder.join(format!("{frame:05}.png")), size, &[[0; 3]; 8], &indices).unwrap();
    }
    let report = import(&mut session, &folder).unwrap();
    assert_eq!((report.object, report.arms), (1, 1), "and no arms on it: absent");
    assert_eq!((report.others[&7], report.outside.as_slice()), (10, &[400][..]));
}

#[test]
fn masks_that_do_not_fit_are_refused_and_change_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let mut session = session(dir.path());
    let refused = |session: &mut Session, name: &str, bytes: &[u8], said: &str| {
        let path = dir.path().join(name);
        fs::write(&path, bytes).unwrap();
        let failure = import(session, &path).unwrap_err();
        assert!(failure.exit == ExitCode::BadInput && failure.message.contains(said), "{}", failure.message);
        assert!(session.document().masks(MaskLayer::Object).is_empty());
    };
    let coco = |segmentation: serde_json::Value| {
        let annotation = json!({ "id": 1, "image_id": 4, "category_id": 1, "segmentation": segmentation });
        let image = json!({ "id": 4, "file_name": "a/000001.jpg" });
        json!({ "images": [image], "annotations": [annotation] }).to_string().into_bytes()
    };
    refused(&mut session, "a.json", b"{\"images\": 3}", "no COCO file");
    refused(&mut session, "b.json", &coco(json!([[1.0, 2.0, 3.0, 4.0]])), "a polygon");
    let runs = |height: u32, width: u32, counts: serde_json::Value| {
        coco(json!({ "size": [height, width], "counts": counts }))
    };
    refused(&mut session, "c.json", &runs(48, 64, json!([5])), "sum to 5");
    refused(&mut session, "d.json", &runs(48, 64, json!("~~")), "character");
    refused(&mut session, "e.json", &runs(2, 2, json!([4])), "the clip is 64×48");
    refused(&mut session, "f.json", &runs(4_000_000_000, 4_000_000_000, json!([1])), "a picture of");
    let folder = dir.path().join("davis");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("00000.png"), b"\x89PNG\r\n\x1a\n and no more").unwrap();
    assert!(import(&mut session, &folder).unwrap_err().message.contains("00000.png"));
    write_indexed(&folder.join("00000.png"), Size::new(2, 2), &[[0; 3]; 2], &[1; 4]).unwrap();
    assert!(import(&mut session, &folder).unwrap_err().message.contains("is 2×2, the clip is 64×48"));
}
