//! What is known of an opened clip.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{CameraSpec, FrameIndex, FrameRow, Rotation};
use crate::geometry::{Pinhole, Pixel, PixelBox, Size};

/// What is noteworthy about a clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClipFlag {
    /// It ends before the end that its container states: used up to the last good frame.
    Truncated,
    /// The decoder reported errors: frames may be missing or show concealment.
    Damaged,
    /// The time between frames varies by more than a tenth.
    VariableFrameRate,
    /// Time stamps ran backwards or stood still; they were put in order.
    NonMonotonicPts,
    /// Time stamps were missing and were filled in at the nominal rate.
    MissingPts,
    /// Nothing is known of the camera: a default field of view was taken.
    DefaultIntrinsics,
    /// Pixels are not square.
    NonSquarePixels,
}

/// An opened clip, all but its pixels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClipInfo {
    /// The video file.
    pub path: PathBuf,
    /// BLAKE3 of the file, hexadecimal: the clip's identity.
    pub hash: String,
    /// The video codec's name.
    pub codec: String,
    /// Picture size of every frame, turned.
    pub size: Size,
    /// Picture size as decoded, the container's own rotation applied, before `rotate`.
    pub decoded_size: Size,
    /// Turn that was applied.
    pub rotate: Rotation,
    /// The camera of the turned picture.
    pub intrinsics: Pinhole,
    /// Where the camera comes from.
    pub intrinsics_source: CameraSpec,
    /// Mean frame rate of the source, Hz.
    pub source_fps: f64,
    /// Frames of the source that were decoded, used or not.
    pub source_frames: u32,
    /// The standard timeline: one row a frame.
    pub frame_table: Vec<FrameRow>,
    /// What is noteworthy, sorted, none twice.
    pub flags: Vec<ClipFlag>,
    /// The first messages of the decoder, where it reported errors.
    pub messages: Vec<String>,
}

impl ClipInfo {
    /// Number of frames of the standard timeline.
    pub fn frame_count(&self) -> usize {
        self.frame_table.len()
    }

    /// The standard frame that first shows source frame `source_frame`, or, where that frame is
    /// not shown (a faster source), the first one that shows a later frame. `None` beyond the end.
    pub fn standard_index(&self, source_frame: u32) -> Option<FrameIndex> {
        let place = self.frame_table.partition_point(|row| row.source_frame < source_frame);
        let first = self.frame_table.first()?.source_frame;
        let row = self.frame_table.get(place).filter(|_| source_frame >= first)?;
        Some(row.index)
    }

    /// Where a pixel of the decoded picture lies on the turned one.
    pub fn turned_pixel(&self, pixel: Pixel) -> Pixel {
        self.rotate.pixel(pixel, self.decoded_size)
    }

    /// Where a box of the decoded picture lies on the turned one.
    pub fn turned_box(&self, pixel_box: PixelBox) -> PixelBox {
        self.rotate.pixel_box(pixel_box, self.decoded_size)
    }

    /// Whether `flag` is set.
    pub fn has(&self, flag: ClipFlag) -> bool {
        self.flags.contains(&flag)
    }
}
