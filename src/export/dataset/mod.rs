//! Datasets that trainers load, made of finished clips.
//!
//! An export can be stopped at any moment and started again with the same line: what is whole stays, what is not
//! is made anew, and the bytes are those of an undisturbed run. New clips are appended; the files of earlier episodes
//! keep their bytes. A clip is never dropped in silence: the report says of each what became of it and why.

mod build;
mod clip;
mod coco;
mod davis;
mod error;
mod file;
mod images;
mod ledger;
mod lerobot;
mod motors;
mod stats;
mod unitree;
mod video;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

pub use build::export_dataset;
pub use error::DatasetError;
pub use motors::{MOTOR_NAMES, ROBOT_TYPE, ThumbOrder};
pub use stats::{FeatureStats, Histogram};

/// What a dataset is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DatasetFormat {
    /// LeRobot v3.0.
    #[serde(rename = "lerobot-v3")]
    LerobotV3,
    /// LeRobot v2.1, with GR00T's `meta/modality.json`.
    #[serde(rename = "lerobot-v2.1")]
    LerobotV21,
    /// Episodes of Unitree's xr_teleoperate.
    UnitreeJson,
    /// Masks as COCO annotations with run lengths.
    Coco,
    /// Masks as DAVIS palette pictures.
    Davis,
}

/// How a dataset is made.
#[derive(Clone, Copy, Debug)]
pub struct DatasetOptions {
    /// What for.
    pub format: DatasetFormat,
    /// Which motor comes first in a hand.
    pub thumb_order: ThumbOrder,
    /// Whether clips that a person rejected are taken all the same.
    pub include_rejected: bool,
}

/// What became of one clip.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "outcome")]
pub enum ClipFate {
    /// It is in the dataset now.
    Written {
        /// Its episode.
        episode: usize,
    },
    /// It was there already.
    Present {
        /// Its episode.
        episode: usize,
    },
    /// It is not in it.
    LeftOut {
        /// Why.
        reason: String,
    },
}

/// One line of the closing table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DatasetRow {
    /// The clip's id.
    pub id: String,
    /// Its folder.
    pub folder: PathBuf,
    /// Its frames, where they are known.
    pub frames: Option<usize>,
    /// What became of it.
    #[serde(flatten)]
    pub fate: ClipFate,
    /// What else should be known: a video that was encoded again, a hand order.
    pub notes: Vec<String>,
}

/// What an export did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DatasetReport {
    /// The format.
    pub format: DatasetFormat,
    /// The dataset's folder.
    pub out: PathBuf,
    /// One a clip, in the order of the input.
    pub clips: Vec<DatasetRow>,
    /// Episodes of the whole dataset, earlier ones included.
    pub episodes: usize,
    /// Their frames.
    pub frames: usize,
}
