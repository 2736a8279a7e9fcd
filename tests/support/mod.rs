//! What several integration tests need.
#![allow(dead_code, clippy::unwrap_used, reason = "each test uses its part; a failing unwrap fails the test")]

use std::{
    fs,
    path::{Path, PathBuf},
};

use agenticfocus::{
    clip::FrameIndex,
    geometry::{Side, Size},
    progress::Unwatched,
    synth::{Episode, EpisodeSpec, generate},
};
use serde_json::json;

/// A short small episode with its true hands, so that no estimator is needed.
pub fn episode(folder: &Path) -> Episode {
    let spec = EpisodeSpec { seed: 2, size: Size::new(320, 240), frames: 20, ..EpisodeSpec::default() };
    generate(&spec, folder, &Unwatched).unwrap();
    Episode::load(folder).unwrap()
}

/// The episode's true hands as a track to import.
pub fn hand_track(episode: &Episode) -> serde_json::Value {
    let side = |side: Side| -> Vec<_> {
        let frames = episode.truth.frames.iter();
        frames
            .map(|frame| frame.hands[side].as_ref().filter(|hand| hand.in_view).map(|hand| hand.joints))
            .collect()
    };
    json!({ "fps": 30, "left_joints_cam": side(Side::Left), "right_joints_cam": side(Side::Right) })
}

/// A manifest of the same episode under several ids, and what else it holds.
pub fn manifest(folder: &Path, ids: &[&str], more: &str) -> PathBuf {
    let truth = Episode::load(folder).unwrap();
    fs::write(folder.join("hands.json"), hand_track(&truth).to_string()).unwrap();
    let camera = truth.truth.pinhole;
    let b = truth.object_visible(FrameIndex(0)).unwrap().bounding_box().unwrap();
    let mut text = String::new();
    for id in ids {
        text += &format!(
            "[[clip]]\nid = \"{id}\"\npath = \"clip.mp4\"\nhands = {{ track = \"hands.json\" }}\n\
             object = {{ frame = 0, box = [{}, {}, {}, {}] }}\n\
             camera = {{ fx = {}, fy = {}, cx = {}, cy = {} }}\n",
            b.x0, b.y0, b.x1, b.y1, camera.fx, camera.fy, camera.cx, camera.cy
        );
    }
    let path = folder.join("manifest.toml");
    fs::write(&path, text + more).unwrap();
    path
}

/// Every file in `folder` and below, relative to it, sorted.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for path in fs::read_dir(&next).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path.strip_prefix(folder).unwrap().to_owned());
            }
        }
    }
    found.sort();
    found
}
