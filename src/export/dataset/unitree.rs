//! Episodes as Unitree's xr_teleoperate records them: a folder with JPEG pictures and `data.json`.

use std::{
    fs::{self, File},
    io::{BufWriter, Write},
    path::Path,
};

use serde_json::{Value, json};

use super::{
    DatasetError, MOTOR_NAMES, ThumbOrder,
    clip::{FinishedClip, Rows},
    video,
};
use crate::{
    geometry::Size,
    robot::{ACTUATED_DOF, ARM_DOF, HAND_DOF},
};

/// Columns of an arm, and of a hand.
const ARM: usize = ARM_DOF / 2;
const HAND: usize = HAND_DOF / 2;

/// Fills the folder `episode` with the clip.
pub(super) fn write_episode(
    clip: &FinishedClip,
    size: Size,
    order: ThumbOrder,
    episode: &Path,
) -> Result<(), DatasetError> {
    let colours = episode.join("colors");
    for folder in [&colours, &episode.join("depths"), &episode.join("audios")] {
        fs::create_dir_all(folder).map_err(DatasetError::io(folder, "create the folder"))?;
    }
    video::unpack(clip, &colours)?;
    let path = episode.join("data.json");
    let written = || -> std::io::Result<()> {
        let mut file = BufWriter::new(File::create(&path)?);
        // Frame by frame: a long clip must not stand in memory as JSON.
        write!(file, "{{\n\"info\": {},\n\"text\": {},\n\"data\": [", info(clip, size, order), text(clip))?;
        let rows = rows_of(clip, order).map_err(std::io::Error::other)?;
        for (index, (state, action)) in rows.iter().enumerate() {
            let separator = if index == 0 { "" } else { "," };
            write!(file, "{separator}\n{}", item(index, state, action))?;
        }
        file.write_all(b"\n]\n}\n")?;
        file.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()
    };
    written().map_err(DatasetError::io(&path, "write the file"))
}

type Row = [f32; ACTUATED_DOF];

fn rows_of(clip: &FinishedClip, order: ThumbOrder) -> Result<Vec<(Row, Row)>, DatasetError> {
    let Rows { state, action } = clip.rows()?;
    Ok(state
        .into_iter()
        .zip(action)
        .map(|(state, action)| (order.arrange(state), order.arrange(action)))
        .collect())
}

fn info(clip: &FinishedClip, size: Size, order: ThumbOrder) -> Value {
    let meta = &clip.description.meta;
    json!({
        "version": "1.0.0",
        "date": "",
        "author": "agenticfocus",
        "image": { "width": size.width, "height": size.height, "fps": 30 },
        "depth": { "width": size.width, "height": size.height, "fps": 30 },
        "audio": { "sample_rate": 16000, "channels": 1, "format": "PCM", "bits": 16 },
        "joint_names": {
            "left_arm": &MOTOR_NAMES[..ARM],
            "left_ee": &MOTOR_NAMES[ARM_DOF..ARM_DOF + HAND],
            "right_arm": &MOTOR_NAMES[ARM..ARM_DOF],
            "right_ee": &MOTOR_NAMES[ARM_DOF + HAND..],
            "body": [],
        },
        "tactile_names": { "left_ee": [], "right_ee": [] },
        "sim_state": "",
        "agenticfocus": {
            "id": clip.id,
            "source_file": clip.description.clip.file,
            "source_hash": clip.description.clip.hash,
            "backends": meta.backends,
            "versions": meta.versions,
            "parameters": meta.parameters,
            "brainco_thumb_order": order.name(),
        },
    })
}

fn text(clip: &FinishedClip) -> Value {
    json!({ "goal": clip.task(), "desc": "", "steps": "" })
}

fn item(index: usize, state: &Row, action: &Row) -> Value {
    let colour = format!("colors/{index:06}_color_0.jpg");
    json!({
        "idx": index,
        "colors": { "color_0": colour },
        "depths": {},
        "states": parts(state),
        "actions": parts(action),
        "tactiles": {},
        "audios": {},
        "sim_state": "",
    })
}

fn parts(row: &Row) -> Value {
    let part = |columns: &[f32]| json!({ "qpos": columns, "qvel": [], "torque": [] });
    json!({
        "left_arm": part(&row[..ARM]),
        "right_arm": part(&row[ARM..ARM_DOF]),
        "left_ee": part(&row[ARM_DOF..ARM_DOF + HAND]),
        "right_ee": part(&row[ARM_DOF + HAND..]),
        "body": { "qpos": [] },
    })
}
