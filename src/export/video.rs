//! H.264 video by an `ffmpeg` child process, one frame a push.

use std::{
    borrow::Cow,
    io::{Read, Write},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread::JoinHandle,
    time::Duration,
};

use serde::Deserialize;

use super::ExportError;
use crate::{clip::child::run_to_end, geometry::Size, image::Rgb8};

/// How well a video is kept, against the time and room it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VideoQuality {
    /// Visually lossless: what others learn from.
    Final,
    /// Good enough to see what happened.
    Debug,
}

impl VideoQuality {
    /// Preset and constant rate factor (lower is better) of the encoder.
    const fn arguments(self) -> [&'static str; 4] {
        match self {
            Self::Final => ["-preset", "veryfast", "-crf", "16"],
            Self::Debug => ["-preset", "superfast", "-crf", "21"],
        }
    }
}

/// Address space `ffprobe` may use, bytes.
const PROBE_MEMORY: u64 = 4 << 30;

/// Writes one H.264 video: yuv420p, BT.709, constant 30 FPS, no reordered frames, index in front.
///
/// Odd sizes are padded to even ones by repeating the last column or row, so every pixel keeps its
/// place. Encoding runs on one thread: the bytes do not depend on the machine's cores. Dropped
/// before [`finish`](Self::finish), it leaves nothing.
#[derive(Debug)]
pub struct VideoWriter {
    path: PathBuf,
    size: Size,
    frames: usize,
    child: Option<Child>,
    messages: Option<JoinHandle<String>>,
}

impl VideoWriter {
    /// Starts a video of `size` frames at `path`; its folder must exist.
    ///
    /// # Errors
    /// When `ffmpeg` cannot be started.
    pub fn create(path: &Path, size: Size, quality: VideoQuality) -> Result<Self, ExportError> {
        let even = even(size);
        let mut command = Command::new("ffmpeg");
        command.args(["-nostdin", "-hide_banner", "-nostats", "-loglevel", "error", "-y"]);
        command.args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-framerate", "30", "-threads", "1"]);
        command.args(["-video_size", &format!("{}x{}", even.width, even.height)]);
        command.args(["-i", "pipe:0", "-an", "-filter_threads", "1", "-vf"]);
        command.arg(
            "scale=flags=bicubic+accurate_rnd+full_chroma_inp:out_color_matrix=bt709:out_range=tv,format=yuv420p",
        );
        command.args(["-c:v", "libx264", "-threads", "1"]).args(quality.arguments());
        command.args(["-g", "30", "-bf", "0", "-colorspace", "bt709", "-color_primaries", "bt709"]);
        command.args(["-color_trc", "bt709", "-color_range", "tv", "-map_metadata", "-1"]);
        command.args(["-fflags", "+bitexact", "-flags:v", "+bitexact", "-video_track_timescale", "15360"]);
        command.args(["-movflags", "+faststart", "-f", "mp4"]).arg(file_url(path));
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child =
            command.spawn().map_err(|source| ExportError::Program { program: "ffmpeg", source })?;
        let messages = child.stderr.take().map(|mut pipe| {
            std::thread::spawn(move || {
                let mut text = Vec::new();
                // The first messages name the cause; the pipe is drained to its end all the same.
                let _ = pipe.by_ref().take(4096).read_to_end(&mut text);
                let _ = std::io::copy(&mut pipe, &mut std::io::sink());
                String::from_utf8_lossy(&text).trim().replace('\n', "; ")
            })
        });
        Ok(Self { path: path.to_owned(), size, frames: 0, child: Some(child), messages })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// When its size is not the video's, or the encoder failed.
    pub fn push(&mut self, frame: &Rgb8) -> Result<(), ExportError> {
        let (expected, found) = (self.size, frame.size());
        if expected != found {
            return Err(ExportError::WrongSize { path: self.path.clone(), expected, found });
        }
        let padded = padded(frame);
        let pipe = self.child.as_mut().and_then(|child| child.stdin.as_mut());
        let written = pipe.map_or(Ok(()), |pipe| pipe.write_all(&padded));
        if let Err(error) = written {
            return Err(self.encoder_failed(&error.to_string()));
        }
        self.frames += 1;
        Ok(())
    }

    /// Frames pushed so far.
    pub fn frame_count(&self) -> usize {
        self.frames
    }

    /// Ends the video and checks that it holds exactly the frames that were pushed.
    ///
    /// # Errors
    /// When nothing was pushed, the encoder failed, or the file holds something else.
    pub fn finish(mut self) -> Result<(), ExportError> {
        if self.frames == 0 {
            return Err(self.encoder_failed("no frame was pushed"));
        }
        let Some(mut child) = self.child.take() else { return Ok(()) };
        drop(child.stdin.take());
        let status = child.wait().map_err(|source| ExportError::io(&self.path, "encode", source))?;
        if !status.success() {
            let error = self.encoder_failed(&status.to_string());
            let _ = std::fs::remove_file(&self.path);
            return Err(error);
        }
        let expected = VideoFacts {
            size: even(self.size),
            frames: self.frames,
            rate: "30/1".to_owned(),
            pixels: "yuv420p".to_owned(),
        };
        let found = video_facts(&self.path)?;
        if found == expected {
            return Ok(());
        }
        let (expected, found) = (expected.to_string(), found.to_string());
        Err(ExportError::WrongVideo { path: self.path.clone(), expected, found })
    }

    fn encoder_failed(&mut self, otherwise: &str) -> ExportError {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
            let _ = std::fs::remove_file(&self.path);
        }
        let said = self.messages.take().and_then(|thread| thread.join().ok()).unwrap_or_default();
        let reason = if said.is_empty() { otherwise.to_owned() } else { said };
        ExportError::Encoder { path: self.path.clone(), frames: self.frames, reason }
    }
}

impl Drop for VideoWriter {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

fn file_url(path: &Path) -> std::ffi::OsString {
    let mut url = std::ffi::OsString::from("file:");
    url.push(path);
    url
}

fn even(size: Size) -> Size {
    Size::new(size.width.next_multiple_of(2), size.height.next_multiple_of(2))
}

fn padded(frame: &Rgb8) -> Cow<'_, [u8]> {
    let (size, even) = (frame.size(), even(frame.size()));
    if size == even {
        return Cow::Borrowed(frame.data());
    }
    let row_length = size.width as usize * Rgb8::CHANNELS;
    let mut data = Vec::with_capacity(even.area() * Rgb8::CHANNELS);
    for y in 0..even.height.min(size.height + 1) {
        let start = y.min(size.height - 1) as usize * row_length;
        let row = &frame.data()[start..start + row_length];
        data.extend_from_slice(row);
        if even.width > size.width {
            data.extend_from_slice(&row[row_length - Rgb8::CHANNELS..]);
        }
    }
    Cow::Owned(data)
}

/// What a video file holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VideoFacts {
    /// Picture size.
    pub size: Size,
    /// Frames, counted packet by packet.
    pub frames: usize,
    /// Mean frame rate as a fraction.
    pub rate: String,
    /// Pixel format.
    pub pixels: String,
}

impl std::fmt::Display for VideoFacts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} frames of {} at {} Hz, {}", self.frames, self.size, self.rate, self.pixels)
    }
}

/// Counts what the first video stream of the file at `path` holds.
///
/// # Errors
/// When `ffprobe` cannot be started or finds no video.
pub fn video_facts(path: &Path) -> Result<VideoFacts, ExportError> {
    #[derive(Deserialize)]
    struct Report {
        streams: Vec<Stream>,
    }
    #[derive(Deserialize)]
    struct Stream {
        width: u32,
        height: u32,
        avg_frame_rate: String,
        pix_fmt: String,
        nb_read_packets: String,
    }
    let mut command = Command::new("ffprobe");
    command.args(["-v", "error", "-select_streams", "v:0", "-count_packets", "-of", "json"]);
    command.args(["-show_entries", "stream=width,height,avg_frame_rate,pix_fmt,nb_read_packets"]);
    command.arg(file_url(path));
    let end = run_to_end(&mut command, Duration::from_secs(120), 1 << 16, PROBE_MEMORY)
        .map_err(|source| ExportError::Program { program: "ffprobe", source })?;
    let report: Option<Report> = serde_json::from_slice(&end.output).ok();
    let stream = report.and_then(|report| report.streams.into_iter().next());
    let facts = stream.and_then(|stream| {
        Some(VideoFacts {
            size: Size::new(stream.width, stream.height),
            frames: stream.nb_read_packets.parse().ok()?,
            rate: stream.avg_frame_rate,
            pixels: stream.pix_fmt,
        })
    });
    facts.ok_or_else(|| ExportError::WrongVideo {
        path: path.to_owned(),
        expected: "a video".to_owned(),
        found: end.log.join("; "),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padding_repeats_the_last_column_and_row() {
        let size = Size::new(1, 1);
        let frame = Rgb8::from_data(size, vec![1, 2, 3]).unwrap();
        assert_eq!(&*padded(&frame), &[1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3]);
        let frame = Rgb8::from_data(Size::new(2, 1), vec![1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(&*padded(&frame), &[1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6]);
    }
}
