//! How often each level occurs in a video's pictures.

use std::time::Duration;

use super::{DatasetError, Histogram, clip::FinishedClip, video::ffmpeg};
use crate::{clip::child::run_to_end, export::ExportError};

/// Side of the pictures that are counted: statistics need no detail.
const SIDE: usize = 128;
/// Pictures of one episode at most.
const MOST: usize = 100;
/// Frames between two pictures that stand for themselves in our videos.
const KEY_INTERVAL: usize = 30;

/// Histograms of red, green and blue over key frames spread over the clip, and how many those are.
pub(super) fn histograms(clip: &FinishedClip) -> Result<(Vec<Histogram>, u64), DatasetError> {
    let path = clip.video();
    let stride = (clip.frames().div_ceil(KEY_INTERVAL)).div_ceil(MOST).max(1);
    let mut command = ffmpeg(&path, &["-skip_frame", "nokey"]);
    let picture = format!("select=not(mod(n\\,{stride})),scale={SIDE}:{SIDE}:flags=area+accurate_rnd");
    command.args(["-an", "-filter_threads", "1", "-vf", &picture, "-fps_mode", "passthrough"]);
    command.args(["-f", "rawvideo", "-pix_fmt", "rgb24", "pipe:1"]);
    let bytes = SIDE * SIDE * 3;
    let end = run_to_end(&mut command, Duration::from_secs(600), bytes * (MOST + 2), 8 << 30)
        .map_err(|source| ExportError::Program { program: "ffmpeg", source })?;
    let whole = end.output.len() >= bytes && end.output.len().is_multiple_of(bytes);
    if !(whole && end.status.is_some_and(|status| status.success())) {
        return Err(DatasetError::clip(&path, format!("cannot be decoded: {}", end.log.join("; "))));
    }
    let mut channels = vec![Histogram::default(); 3];
    for pixel in end.output.as_chunks::<3>().0 {
        for (channel, level) in channels.iter_mut().zip(pixel) {
            channel.add(*level);
        }
    }
    Ok((channels, (end.output.len() / bytes) as u64))
}
