//! Video, record, masks, crops: everything of a finished clip's folder.

pub mod dataset;
mod error;
mod folder;
pub mod overlay;
mod pictures;
mod record;
mod video;

pub use error::ExportError;
pub use folder::{ClipFolder, check_id, write_json};
pub use pictures::{object_crop, read_indexed, read_mask, write_indexed, write_mask, write_rgb, write_rgba};
pub use record::{
    ArrayData, ArrayNote, HandLimits, NamedArray, Record, RecordClip, RecordDescription, RecordMeta,
    write_npz,
};
pub use video::{VideoFacts, VideoQuality, VideoWriter, video_facts};
