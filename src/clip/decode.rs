//! Decoding by an `ffmpeg` child process: every frame with its real time stamp.
//!
//! The child writes raw RGB to its output; its `showinfo` filter names the time stamp of each frame
//! in the log just before the frame itself comes. Decoding runs on one thread, so that even what a
//! decoder makes of damaged data is the same on every run.

use std::{
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use super::{
    ClipError, Rotation,
    child::{Caged, Turn, run_to_end},
    probe::{CHILD_MEMORY, MAX_PIXELS, StreamProbe, fraction, input_arguments},
};
use crate::{geometry::Size, image::Rgb8, progress::Watch};

/// The decoder is given up after this long without a frame or a line.
const STALL: Duration = Duration::from_secs(60);
/// Messages of the decoder that are kept.
const KEPT_MESSAGES: usize = 5;

/// One frame as decoded and turned.
#[derive(Debug)]
pub struct DecodedFrame {
    /// Time stamp in ticks of [`Decoder::time_base`]; `None` where the file has none.
    pub pts: Option<i64>,
    /// The picture.
    pub picture: Rgb8,
}

/// A running decode.
#[derive(Debug)]
pub struct Decoder {
    path: PathBuf,
    rotate: Rotation,
    child: Option<Caged>,
    log: Vec<String>,
    stamps: std::collections::VecDeque<Option<i64>>,
    /// Seconds a tick, as a fraction.
    time_base: Option<(u32, u32)>,
    nominal_rate: Option<(u32, u32)>,
    decoded_size: Option<Size>,
    pixel_aspect: f64,
    frames: u64,
    errors: u64,
    messages: Vec<String>,
    broken_off: bool,
}

impl Decoder {
    /// Starts decoding stream `probe` of the file at `path`, turning every frame by `rotate`.
    ///
    /// # Errors
    /// When `ffmpeg` cannot be started.
    pub fn start(path: &Path, probe: &StreamProbe, rotate: Rotation) -> Result<Self, ClipError> {
        let mut command = Command::new("ffmpeg");
        command.args(["-nostdin", "-hide_banner", "-nostats", "-loglevel", "level+info"]);
        command.args(["-fflags", "+discardcorrupt", "-threads", "1"]);
        command.args(["-max_pixels", &MAX_PIXELS.to_string()]);
        command.args(input_arguments(path));
        command.args(["-map", &format!("0:{}", probe.stream), "-filter_threads", "1"]);
        command.args(["-vf", &filters(probe, rotate)]);
        command.args(passthrough_arguments()?);
        command.args(["-f", "rawvideo", "pipe:1"]);
        let child = Caged::spawn(&mut command, CHILD_MEMORY)
            .map_err(|source| ClipError::Program { program: "ffmpeg", source })?;
        Ok(Self {
            path: path.into(),
            rotate,
            child: Some(child),
            log: Vec::new(),
            stamps: std::collections::VecDeque::new(),
            time_base: None,
            nominal_rate: None,
            decoded_size: None,
            pixel_aspect: 1.0,
            frames: 0,
            errors: 0,
            messages: Vec::new(),
            broken_off: false,
        })
    }

    /// The next frame; `None` after the last.
    ///
    /// # Errors
    /// When the decoder stands still or is killed, a pipe fails, or `watch` cancels.
    pub fn next_frame(&mut self, watch: &dyn Watch) -> Result<Option<DecodedFrame>, ClipError> {
        let (mut buffer, mut filled) = (Vec::new(), 0);
        loop {
            watch.check()?;
            if let (true, Some(size), Some(_)) = (buffer.is_empty(), self.size(), self.stamps.front()) {
                buffer = vec![0; size.area() * Rgb8::CHANNELS];
            }
            if !buffer.is_empty() && filled == buffer.len() {
                let pts = self.stamps.pop_front().flatten();
                self.frames += 1;
                let picture = self.size().and_then(|size| Rgb8::from_data(size, buffer));
                return Ok(picture.map(|picture| DecodedFrame { pts, picture }));
            }
            let Some(child) = &mut self.child else { return Ok(None) };
            let turn = child
                .wait_for(&mut buffer, &mut filled, &mut self.log)
                .map_err(|e| pipe_failed(&self.path, e))?;
            let silence = child.silence();
            self.read_log()?;
            match turn {
                // What is still expected after both pipes closed will never come.
                Turn::Closed if filled < buffer.len() || (buffer.is_empty() && self.stamps.is_empty()) => {
                    self.end()?;
                    return Ok(None);
                }
                Turn::Idle if silence > STALL => {
                    let (path, frames) = (self.path.clone(), self.frames);
                    return Err(ClipError::Stalled { path, seconds: STALL.as_secs(), frames });
                }
                _ => {}
            }
        }
    }

    fn end(&mut self) -> Result<(), ClipError> {
        use std::os::unix::process::ExitStatusExt as _;
        let Some(child) = self.child.take() else { return Ok(()) };
        let status = child.finish(Duration::from_secs(5)).map_err(|e| pipe_failed(&self.path, e))?;
        // A signal that faults (SIGSEGV and the like) is the file's doing, any other one is not.
        if let Some(signal @ (9 | 15 | 2 | 1)) = status.signal() {
            return Err(ClipError::Killed { path: self.path.clone(), signal, frames: self.frames });
        }
        self.broken_off = !status.success();
        Ok(())
    }

    fn read_log(&mut self) -> Result<(), ClipError> {
        for line in std::mem::take(&mut self.log) {
            if line.starts_with("[Parsed_showinfo_0 @") {
                self.read_showinfo(&line)?;
            } else if line.contains("[error]") || line.contains("[fatal]") {
                self.errors += 1;
                if self.messages.len() < KEPT_MESSAGES {
                    self.messages.push(plain_message(&line));
                }
            }
        }
        Ok(())
    }

    fn read_showinfo(&mut self, line: &str) -> Result<(), ClipError> {
        if line.contains("] config in ") && self.time_base.is_none() {
            self.time_base = field(line, "time_base:").and_then(fraction);
            self.nominal_rate = field(line, "frame_rate:").and_then(fraction);
        }
        if !(line.contains(" n:") && line.contains(" pts:")) {
            return Ok(());
        }
        if self.decoded_size.is_none() {
            let size = field(line, " s:").and_then(|text| text.split_once('x'));
            let size = size.and_then(|(w, h)| Some(Size::new(w.parse().ok()?, h.parse().ok()?)));
            let Some(size) = size.filter(|size| size.width > 0 && size.height > 0) else { return Ok(()) };
            let found = u64::from(size.width) * u64::from(size.height);
            if found > MAX_PIXELS {
                let what = "pixels a frame";
                return Err(ClipError::TooLarge { path: self.path.clone(), what, found, limit: MAX_PIXELS });
            }
            self.decoded_size = Some(size);
            let aspect = field(line, " sar:").and_then(fraction);
            self.pixel_aspect = aspect.map_or(1.0, |(n, d)| (f64::from(n) / f64::from(d)).clamp(0.1, 10.0));
        }
        self.stamps.push_back(field(line, " pts:").and_then(|text| text.parse().ok()));
        Ok(())
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Size of the turned frames, once the first has come.
    pub fn size(&self) -> Option<Size> {
        self.decoded_size.map(|size| self.rotate.size(size))
    }

    /// Size as decoded, before [`Rotation`], once the first frame has come.
    pub fn decoded_size(&self) -> Option<Size> {
        self.decoded_size
    }

    /// Width of a decoded pixel over its height.
    pub fn pixel_aspect(&self) -> f64 {
        self.pixel_aspect
    }

    /// Seconds a tick, as a fraction, once the first frame has come.
    pub fn time_base(&self) -> (u32, u32) {
        self.time_base.unwrap_or((1, 90_000))
    }

    /// The stream's nominal frame rate, where the decoder knows it.
    pub fn nominal_rate(&self) -> Option<(u32, u32)> {
        self.nominal_rate
    }

    /// How many errors the decoder reported so far, and the first few.
    pub fn errors(&self) -> (u64, &[String]) {
        (self.errors, &self.messages)
    }

    /// Whether the decoder ended with a failure.
    pub fn broken_off(&self) -> bool {
        self.broken_off
    }
}

fn pipe_failed(path: &Path, source: std::io::Error) -> ClipError {
    ClipError::Io { path: path.into(), doing: "reading from the decoder", source }
}

fn filters(probe: &StreamProbe, rotate: Rotation) -> String {
    let turn = match rotate {
        Rotation::Deg0 => "",
        Rotation::Deg90 => ",transpose=clock",
        Rotation::Deg180 => ",hflip,vflip",
        Rotation::Deg270 => ",transpose=cclock",
    };
    // FFmpeg takes an unstated matrix as BT.601; video of HD size is BT.709 by convention.
    let shorter = probe.size.width.min(probe.size.height);
    let matrix = if !probe.has_colour_matrix && shorter >= 720 { ":in_color_matrix=bt709" } else { "" };
    let flags = "bicubic+accurate_rnd+full_chroma_int";
    format!("showinfo=checksum=0{turn},scale=flags={flags}{matrix},format=rgb24")
}

/// The option that passes every frame on as it is has another name in older releases.
fn passthrough_arguments() -> Result<[&'static str; 2], ClipError> {
    let mut command = Command::new("ffmpeg");
    command.arg("-version");
    let end = run_to_end(&mut command, Duration::from_secs(30), 1 << 16, CHILD_MEMORY)
        .map_err(|source| ClipError::Program { program: "ffmpeg", source })?;
    let text = String::from_utf8_lossy(&end.output);
    let version = text.strip_prefix("ffmpeg version ").unwrap_or("");
    let old = ["2.", "3.", "4.", "5.0"].iter().any(|start| version.starts_with(start));
    Ok([if old { "-vsync" } else { "-fps_mode" }, "passthrough"])
}

/// The word that follows `name`, blanks skipped.
fn field<'a>(line: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = line.split_once(name)?;
    rest.split_whitespace().next().map(|word| word.trim_end_matches(','))
}

/// A log line without its `[codec @ address] [error]` tags, so that it is the same on every run.
fn plain_message(line: &str) -> String {
    let mut rest = line;
    while let Some((tag, after)) = rest.strip_prefix('[').and_then(|inner| inner.split_once(']')) {
        if tag.len() > 80 {
            break;
        }
        rest = after.trim_start();
    }
    rest.chars().take(200).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn showinfo_fields_are_read() {
        let line =
            "[Parsed_showinfo_0 @ 0x5] [info] n:  12 pts:  -1024 pts_time:-0.06 sar:1/1 s:1280x720 i:P";
        assert_eq!(field(line, " pts:"), Some("-1024"));
        assert_eq!(field(line, " s:"), Some("1280x720"));
        assert_eq!(field(line, " pts_time:"), Some("-0.06"));
    }

    #[test]
    fn messages_lose_tags_and_addresses() {
        assert_eq!(plain_message("[h264 @ 0x55] [error] bad MB at 3 [x]"), "bad MB at 3 [x]");
    }
}
