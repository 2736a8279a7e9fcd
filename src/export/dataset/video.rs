//! A clip's video as an episode's: the very file where it fits, else encoded again.

use std::{fs, path::Path, process::Command, time::Duration};

use super::{DatasetError, clip::FinishedClip};
use crate::{
    clip::child::run_to_end,
    export::{ExportError, VideoFacts, video_facts},
    geometry::Size,
};

/// Address space `ffmpeg` may use, bytes.
const MEMORY: u64 = 8 << 30;
/// Longest time for a video: far more than an hour of footage takes.
const PATIENCE: Duration = Duration::from_secs(6 * 3600);

/// What the clip's video holds, which has to be one frame a row of its record at constant 30 FPS.
pub(super) fn checked(clip: &FinishedClip) -> Result<VideoFacts, DatasetError> {
    let path = clip.video();
    let found = video_facts(&path)?;
    let expected = VideoFacts {
        size: found.size,
        frames: clip.frames(),
        rate: "30/1".to_owned(),
        pixels: "yuv420p".to_owned(),
    };
    if found == expected {
        return Ok(found);
    }
    Err(DatasetError::clip(&path, format!("holds {found}, expected {expected}")))
}

/// Puts the clip's video at `to` with pictures of `size`. Returns what was done to it, where anything was.
pub(super) fn place(
    clip: &FinishedClip,
    found: &VideoFacts,
    size: Size,
    to: &Path,
) -> Result<Option<String>, DatasetError> {
    if found.size == size {
        fs::copy(clip.video(), to).map_err(DatasetError::io(to, "copy the video"))?;
        return Ok(None);
    }
    let fit = format!(
        "scale={0}:{1}:force_original_aspect_ratio=decrease:flags=area+accurate_rnd,pad={0}:{1}:-1:-1,setsar=1",
        size.width, size.height
    );
    let mut command = ffmpeg(&clip.video(), &[]);
    command.args(["-an", "-filter_threads", "1", "-vf", &fit, "-c:v", "libx264", "-threads", "1"]);
    command.args(["-preset", "veryfast", "-crf", "16", "-pix_fmt", "yuv420p", "-g", "30", "-bf", "0"]);
    command.args(["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"]);
    command.args(["-video_track_timescale", "15360", "-movflags", "+faststart", "-f", "mp4"]);
    command.arg(to);
    finished(&mut command, to, clip.frames())?;
    let encoded = video_facts(to)?;
    if encoded.frames != found.frames || encoded.size != size {
        let (path, expected) = (to.to_owned(), format!("{} frames of {size}", found.frames));
        return Err(ExportError::WrongVideo { path, expected, found: encoded.to_string() }.into());
    }
    Ok(Some(format!("video encoded again, {} to {size}", found.size)))
}

/// Every frame as `%06d_color_0.jpg` from 0 on, in `folder`.
pub(super) fn unpack(clip: &FinishedClip, folder: &Path) -> Result<(), DatasetError> {
    let mut command = ffmpeg(&clip.video(), &[]);
    command.args(["-an", "-threads", "1", "-q:v", "2", "-start_number", "0"]);
    command.args(["-fflags", "+bitexact", "-flags:v", "+bitexact", "-f", "image2"]);
    command.arg(folder.join("%06d_color_0.jpg"));
    finished(&mut command, folder, clip.frames())?;
    let entries = fs::read_dir(folder).map_err(DatasetError::io(folder, "list the folder"))?;
    let (expected, found) = (clip.frames(), entries.count());
    if found == expected {
        return Ok(());
    }
    let (path, expected) = (folder.to_owned(), format!("{expected} pictures"));
    Err(ExportError::WrongVideo { path, expected, found: format!("{found} pictures") }.into())
}

/// `ffmpeg` reading the file `input`, with these options for its decoder, on one thread: the bytes do not depend on the machine.
pub(super) fn ffmpeg(input: &Path, decoder: &[&str]) -> Command {
    let mut command = Command::new("ffmpeg");
    command.args(["-nostdin", "-hide_banner", "-nostats", "-loglevel", "error", "-y"]);
    command.args(["-protocol_whitelist", "file", "-threads", "1"]).args(decoder).arg("-i").arg(input);
    command
}

fn finished(command: &mut Command, path: &Path, frames: usize) -> Result<(), DatasetError> {
    let end = run_to_end(command, PATIENCE, 1 << 16, MEMORY)
        .map_err(|source| ExportError::Program { program: "ffmpeg", source })?;
    if end.status.is_some_and(|status| status.success()) {
        return Ok(());
    }
    let reason = end.log.join("; ");
    Err(ExportError::Encoder { path: path.to_owned(), frames, reason }.into())
}
