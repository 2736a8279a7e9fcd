//! What a file says of itself, read by `ffprobe` in a child process.

use std::{ffi::OsString, path::Path, process::Command, time::Duration};

use serde::Deserialize;

use super::{ClipError, child::run_to_end};
use crate::geometry::Size;

/// Largest picture accepted, pixels: 8K UHD with some room.
pub const MAX_PIXELS: u64 = 8192 * 4352;
/// Address space a decoder may use, bytes.
pub(super) const CHILD_MEMORY: u64 = 8 << 30;

/// Containers that hold video themselves. Playlists (HLS, concat, DASH) are left out: they would
/// make the decoder open other files.
const FORMATS: &str = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,mpeg,mpegvideo,flv,live_flv,asf,ogg,\
h264,hevc,av1,obu,ivf,m4v,mjpeg,gif,apng,nut,mxf,dv,rm,wtv,yuv4mpegpipe,h263,vc1,gxf,mp3,wav,aac,flac";

/// Arguments that open `path` and nothing else.
pub(super) fn input_arguments(path: &Path) -> Vec<OsString> {
    let mut url = OsString::from("file:");
    url.push(path);
    ["-protocol_whitelist", "file", "-format_whitelist", FORMATS, "-i"]
        .into_iter()
        .map(OsString::from)
        .chain([url])
        .collect()
}

/// The video stream of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamProbe {
    /// Its index among all streams.
    pub stream: u32,
    /// The codec's name.
    pub codec: String,
    /// Coded size, before any rotation.
    pub size: Size,
    /// Mean frame rate, as a fraction, where known.
    pub average_rate: Option<(u32, u32)>,
    /// Nominal frame rate, as a fraction, where known.
    pub nominal_rate: Option<(u32, u32)>,
    /// Seconds the file claims to last, where it does.
    pub duration: Option<f64>,
    /// Whether the colour matrix is stated.
    pub has_colour_matrix: bool,
}

#[derive(Deserialize)]
struct Report {
    #[serde(default)]
    streams: Vec<Stream>,
    #[serde(default)]
    format: Format,
}

#[derive(Deserialize, Default)]
struct Format {
    duration: Option<String>,
}

#[derive(Deserialize)]
struct Stream {
    index: u32,
    codec_type: Option<String>,
    codec_name: Option<String>,
    width: Option<u32>,
    height: Option<u32>,
    avg_frame_rate: Option<String>,
    r_frame_rate: Option<String>,
    duration: Option<String>,
    color_space: Option<String>,
    #[serde(default)]
    disposition: Disposition,
}

#[derive(Deserialize, Default)]
struct Disposition {
    #[serde(default)]
    attached_pic: u8,
}

/// Reads what the file at `path` says of its first video stream (cover pictures do not count).
///
/// # Errors
/// When the path is no readable file, FFmpeg cannot open it, or it has no video stream.
pub fn probe(path: &Path) -> Result<StreamProbe, ClipError> {
    check_readable(path)?;
    let mut command = Command::new("ffprobe");
    command.args(["-v", "error", "-of", "json", "-show_entries"]);
    command.arg(
        "stream=index,codec_type,codec_name,width,height,avg_frame_rate,r_frame_rate,duration,\
         color_space:stream_disposition=attached_pic:format=duration",
    );
    command.args(input_arguments(path));
    let end = run_to_end(&mut command, Duration::from_secs(60), 1 << 20, CHILD_MEMORY)
        .map_err(|source| ClipError::Program { program: "ffprobe", source })?;
    let Some(status) = end.status else {
        return Err(ClipError::Stalled { path: path.into(), seconds: 60, frames: 0 });
    };
    if !status.success() {
        let reason = end.log.last().map_or("ffprobe gives no reason", String::as_str);
        let reason = reason.rsplit_once(&*path.to_string_lossy()).map_or(reason, |(_, rest)| rest);
        let reason = reason.trim_start_matches([':', ' ']).to_owned();
        return Err(ClipError::NotVideo { path: path.into(), reason });
    }
    let report: Report = serde_json::from_slice(&end.output)
        .map_err(|error| ClipError::NotVideo { path: path.into(), reason: error.to_string() })?;
    choose_stream(path, report)
}

/// Whether `path` is a file with content that may be read; what it says stays so: bad input, not a fault of the disk.
pub(super) fn check_readable(path: &Path) -> Result<(), ClipError> {
    let refuse = |reason: String| Err(ClipError::Unreadable { path: path.into(), reason });
    // A named pipe must not be opened before this: that would wait for a writer.
    match std::fs::metadata(path) {
        Err(error) => return refuse(error.to_string()),
        Ok(data) if data.is_dir() => return refuse("it is a folder, not a file".to_owned()),
        Ok(data) if !data.is_file() => return refuse("it is not a regular file".to_owned()),
        Ok(data) if data.len() == 0 => return refuse("the file is empty".to_owned()),
        Ok(_) => {}
    }
    std::fs::File::open(path).map_or_else(|error| refuse(error.to_string()), |_| Ok(()))
}

fn choose_stream(path: &Path, report: Report) -> Result<StreamProbe, ClipError> {
    let is_video = |s: &Stream| s.codec_type.as_deref() == Some("video") && s.disposition.attached_pic == 0;
    let Some(stream) = report.streams.iter().find(|stream| is_video(stream)) else {
        let mut kinds: Vec<&str> =
            report.streams.iter().map(|s| s.codec_type.as_deref().unwrap_or("unknown")).collect();
        kinds.dedup();
        let found = if kinds.is_empty() { "no stream at all".to_owned() } else { kinds.join(", ") };
        return Err(ClipError::NoVideoStream { path: path.into(), found });
    };
    let size = Size::new(stream.width.unwrap_or(0), stream.height.unwrap_or(0));
    let pixels = u64::from(size.width) * u64::from(size.height);
    if pixels > MAX_PIXELS {
        return Err(ClipError::TooLarge {
            path: path.into(),
            what: "pixels a frame",
            found: pixels,
            limit: MAX_PIXELS,
        });
    }
    let duration = stream.duration.as_deref().or(report.format.duration.as_deref());
    Ok(StreamProbe {
        stream: stream.index,
        codec: stream.codec_name.clone().unwrap_or_else(|| "unknown".to_owned()),
        size,
        average_rate: stream.avg_frame_rate.as_deref().and_then(fraction),
        nominal_rate: stream.r_frame_rate.as_deref().and_then(fraction),
        duration: duration.and_then(|text| text.parse().ok()).filter(|seconds| *seconds > 0.0),
        has_colour_matrix: stream.color_space.as_deref().is_some_and(|name| name != "unknown"),
    })
}

/// `"30000/1001"` as two positive numbers.
pub(super) fn fraction(text: &str) -> Option<(u32, u32)> {
    let (numerator, denominator) = text.split_once('/')?;
    let pair = (numerator.trim().parse().ok()?, denominator.trim().parse().ok()?);
    (pair.0 > 0 && pair.1 > 0).then_some(pair)
}
