//! Pictures in files: PNG truth and the H.264 clip.

use std::{
    fs::File,
    io::{BufReader, BufWriter, Write as _},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, Command, Stdio},
};

use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

use super::spec::SynthError;
use crate::{geometry::Size, image::Rgb8};

/// Writes `bytes` of `size` as a PNG of the given colour type.
pub fn write_png(path: &Path, size: Size, colour: png::ColorType, bytes: &[u8]) -> Result<(), SynthError> {
    let file = File::create(path).map_err(SynthError::io(path))?;
    let mut encoder = png::Encoder::new(BufWriter::new(file), size.width, size.height);
    encoder.set_color(colour);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let write = |encoder: png::Encoder<'_, _>| encoder.write_header()?.write_image_data(bytes);
    write(encoder).map_err(|error| SynthError::io(path)(std::io::Error::other(error)))
}

/// Reads a PNG that has `channels` bytes a pixel.
pub fn read_png(path: &Path, channels: usize) -> Result<(Size, Vec<u8>), SynthError> {
    let file = File::open(path).map_err(SynthError::io(path))?;
    let damaged = |error: png::DecodingError| SynthError::damaged(path, error);
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().map_err(damaged)?;
    let length = reader.output_buffer_size().unwrap_or(0);
    let mut bytes = vec![0; length];
    let info = reader.next_frame(&mut bytes).map_err(damaged)?;
    let size = Size::new(info.width, info.height);
    bytes.truncate(info.buffer_size());
    if bytes.len() != size.area() * channels {
        return Err(SynthError::damaged(path, format!("expected {channels} bytes a pixel")));
    }
    Ok((size, bytes))
}

/// A mild lens blur: a binomial of about 0.5 pixels, the same for every channel.
pub fn lens_blur(size: Size, channels: usize, bytes: &mut [u8]) {
    const SIDE: u32 = 30;
    let (width, height) = (size.width as usize, size.height as usize);
    let weight = |a: u8, b: u8, c: u8| {
        ((u32::from(a) * SIDE + u32::from(b) * (256 - 2 * SIDE) + u32::from(c) * SIDE + 128) / 256) as u8
    };
    let source = bytes.to_vec();
    for y in 0..height {
        for i in 0..width * channels {
            let at = y * width * channels + i;
            let left = if i < channels { at } else { at - channels };
            let right = if i + channels >= width * channels { at } else { at + channels };
            bytes[at] = weight(source[left], source[at], source[right]);
        }
    }
    let source = bytes.to_vec();
    let stride = width * channels;
    for at in 0..source.len() {
        let up = if at < stride { at } else { at - stride };
        let down = if at + stride >= source.len() { at } else { at + stride };
        bytes[at] = weight(source[up], source[at], source[down]);
    }
}

/// Adds sensor noise of standard deviation `sigma` (8-bit steps), reproducible from `seed`.
pub fn sensor_noise(picture: &mut Rgb8, sigma: f64, seed: u64) {
    if sigma <= 0.0 {
        return;
    }
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    for value in picture.data_mut() {
        // The sum of four uniform bytes is nearly normal with a standard deviation of 147.8.
        let bits: u32 = rng.random();
        let sum: u32 = bits.to_le_bytes().into_iter().map(u32::from).sum();
        let noise = (f64::from(sum) - 510.0) / 147.8 * sigma;
        *value = (f64::from(*value) + noise).round().clamp(0.0, 255.0) as u8;
    }
}

/// An H.264 encoder fed with RGB frames; the same frames make the same bytes.
#[derive(Debug)]
pub struct ClipWriter {
    path: PathBuf,
    child: Child,
    input: Option<ChildStdin>,
}

impl ClipWriter {
    /// Starts an encoder.
    pub fn new(path: &Path, size: Size, crf: u32) -> Result<Self, SynthError> {
        let mut command = Command::new("ffmpeg");
        command.args(["-nostdin", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
        command.args(["-s", &format!("{}x{}", size.width, size.height), "-r", "30", "-i", "-"]);
        command
            .args(["-an", "-c:v", "libx264", "-preset", "veryfast", "-threads", "1", "-pix_fmt", "yuv420p"]);
        command.args([
            "-crf",
            &crf.to_string(),
            "-g",
            "30",
            "-color_range",
            "tv",
            "-colorspace",
            "smpte170m",
        ]);
        command.args(["-fflags", "+bitexact", "-flags:v", "+bitexact"]);
        command.arg(path).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command
            .spawn()
            .map_err(|error| SynthError::Encoder { path: path.into(), reason: error.to_string() })?;
        let input = child.stdin.take();
        Ok(Self { path: path.into(), child, input })
    }

    /// Appends a frame.
    pub fn push(&mut self, frame: &Rgb8) -> Result<(), SynthError> {
        let Some(input) = &mut self.input else { return Ok(()) };
        if input.write_all(frame.data()).is_err() {
            self.input = None;
            return Err(self.failure());
        }
        Ok(())
    }

    /// Ends the stream and waits for the file to be whole.
    pub fn finish(mut self) -> Result<(), SynthError> {
        self.input = None;
        match self.child.wait() {
            Ok(status) if status.success() => Ok(()),
            _ => Err(self.failure()),
        }
    }

    fn failure(&mut self) -> SynthError {
        use std::io::Read as _;
        let mut reason = String::new();
        let _ = self.child.wait();
        if let Some(mut stderr) = self.child.stderr.take() {
            let _ = stderr.read_to_string(&mut reason);
        }
        SynthError::Encoder { path: self.path.clone(), reason: reason.trim().to_owned() }
    }
}

impl Drop for ClipWriter {
    fn drop(&mut self) {
        self.input = None;
        let _ = self.child.wait();
    }
}
