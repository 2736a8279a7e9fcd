//! `meta/info.json`.

use serde_json::{Map, Value, json};

use super::{ANNOTATION, CHUNK, FPS, VIDEO, Version};
use crate::{
    export::dataset::{MOTOR_NAMES, ROBOT_TYPE, ledger::Ledger},
    geometry::Size,
    robot::ACTUATED_DOF,
};

/// What the dataset holds and where.
pub(super) fn info(ledger: &Ledger, version: Version) -> Value {
    let episodes = ledger.episodes.len();
    let mut info = json!({
        "robot_type": ROBOT_TYPE,
        "total_episodes": episodes,
        "total_frames": ledger.frames(),
        "total_tasks": ledger.tasks().len(),
        "chunks_size": CHUNK,
        "fps": FPS,
        "splits": { "train": format!("0:{episodes}") },
        "features": features(ledger, version),
    });
    let own = match version {
        Version::V30 => json!({
            "codebase_version": "v3.0",
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 200,
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
        }),
        Version::V21 => json!({
            "codebase_version": "v2.1",
            "total_videos": episodes,
            "total_chunks": episodes.div_ceil(CHUNK),
            "data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
            "video_path": "videos/chunk-{episode_chunk:03d}/{video_key}/episode_{episode_index:06d}.mp4",
        }),
    };
    if let (Some(info), Value::Object(own)) = (info.as_object_mut(), own) {
        info.extend(own);
        info.insert(
            "agenticfocus".to_owned(),
            json!({
                "brainco_thumb_order": ledger.head.thumb_order.name(),
                "action": "action[t] = state[t + 1], last row repeated",
            }),
        );
    }
    info
}

fn features(ledger: &Ledger, version: Version) -> Map<String, Value> {
    let size = ledger.episodes.first().map_or(Size::new(0, 0), |episode| episode.size);
    let vector = json!({ "dtype": "float32", "shape": [ACTUATED_DOF], "names": MOTOR_NAMES });
    let scalar = |kind: &str| json!({ "dtype": kind, "shape": [1], "names": null });
    let video = json!({
        "dtype": "video",
        "shape": [size.height, size.width, 3],
        "names": ["height", "width", "channels"],
        "info": {
            "video.height": size.height,
            "video.width": size.width,
            "video.codec": "h264",
            "video.pix_fmt": "yuv420p",
            "video.is_depth_map": false,
            "video.fps": FPS,
            "video.channels": 3,
            "has_audio": false,
        },
    });
    let mut features = Map::new();
    let mut add = |name: &str, feature: Value| features.insert(name.to_owned(), feature);
    add("observation.state", vector.clone());
    add("action", vector);
    add(VIDEO, video);
    add("timestamp", scalar("float32"));
    for name in ["frame_index", "episode_index", "index", "task_index"] {
        add(name, scalar("int64"));
    }
    if version == Version::V21 {
        add(ANNOTATION, scalar("int64"));
    }
    features
}
