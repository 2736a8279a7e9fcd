//! Opening a clip: decode once, standardise, keep the frames in a scratch file.

use std::{fs::File, io::Read, path::Path};

use super::{
    CameraSpec, ClipError, ClipFlag, ClipInfo, ClipRequest, FrameError, FrameIndex, FrameRow, FrameSource,
    FrameStore, FrameStoreWriter, Resampler, StoreError,
    decode::Decoder,
    probe::{StreamProbe, check_readable, probe},
    timing::Timing,
};
use crate::{geometry::Size, image::Rgb8, progress::Watch};

/// Most frames of the standard timeline that are accepted: two hours.
pub const MAX_FRAMES: usize = 2 * 3600 * 30;
/// Slack for `start` and `end`, which people type with few digits, seconds.
const TYPED: f64 = 1e-3;

/// A clip on the standard 30 FPS timeline with random access to its frames.
#[derive(Debug)]
pub struct StandardClip {
    /// All but the pixels.
    pub info: ClipInfo,
    store: FrameStore,
}

impl FrameSource for StandardClip {
    fn frame_count(&self) -> usize {
        self.info.frame_table.len()
    }

    fn size(&self) -> Size {
        self.info.size
    }

    fn frame(&self, index: FrameIndex) -> Result<Rgb8, FrameError> {
        let count = self.frame_count();
        let row = self.info.frame_table.get(index.as_usize());
        let row = row.ok_or(FrameError::OutOfRange { index, count })?;
        self.store.frame(FrameIndex(row.stored))
    }
}

impl StandardClip {
    /// The frame store, which holds every frame of the source that the timeline shows, once.
    pub fn store(&self) -> &FrameStore {
        &self.store
    }
}

/// Decodes the clip of `request` once, standardises it to 30 FPS and keeps its frames in
/// `scratch/source.frames`.
///
/// Damaged and truncated files are used up to the last good frame and flagged.
///
/// # Errors
/// When there is no frame to be had, a limit is exceeded, a program or the scratch file fails, or
/// `watch` cancels; see [`ClipError::exit_code`].
pub fn open(request: &ClipRequest, scratch: &Path, watch: &dyn Watch) -> Result<StandardClip, ClipError> {
    let path = request.path.as_path();
    let probe = probe(path)?;
    let range = Range::new(request)?;
    let hash = content_hash(path, watch)?;
    let mut decoder = Decoder::start(path, &probe, request.rotate)?;
    let store_path = scratch.join("source.frames");
    let read = read_frames(&mut decoder, &probe, &range, &store_path, watch)?;

    let decoded_size = decoder.decoded_size().unwrap_or(probe.size);
    let aspect = decoder.pixel_aspect();
    let camera = request.camera.pinhole(decoded_size, aspect);
    let camera = camera.map_err(|source| ClipError::Camera { path: path.into(), source })?;
    let info = ClipInfo {
        path: path.into(),
        hash,
        codec: probe.codec.clone(),
        size: request.rotate.size(decoded_size),
        decoded_size,
        rotate: request.rotate,
        intrinsics: request.rotate.pinhole(&camera),
        intrinsics_source: request.camera,
        source_fps: read.source_fps,
        source_frames: read.timing.count(),
        frame_table: read.rows,
        flags: flags(&read.timing, &decoder, &probe, request, read.seconds, range.cut_short),
        messages: decoder.errors().1.to_vec(),
    };
    Ok(StandardClip { info, store: read.store })
}

/// The seconds of the source that are used.
struct Range {
    start: f64,
    end: f64,
    cut_short: bool,
}

impl Range {
    fn new(request: &ClipRequest) -> Result<Self, ClipError> {
        let (start, end) = (request.start.unwrap_or(0.0), request.end.unwrap_or(f64::INFINITY));
        if start.is_nan() || end.is_nan() || end <= start {
            let path = request.path.clone();
            return Err(ClipError::EmptyRange { path, start, end, duration: f64::NAN });
        }
        Ok(Self { start, end, cut_short: request.end.is_some() })
    }
}

struct ReadFrames {
    rows: Vec<FrameRow>,
    store: FrameStore,
    timing: Timing,
    /// Seconds from the first to the end of the last frame decoded.
    seconds: f64,
    source_fps: f64,
}

fn read_frames(
    decoder: &mut Decoder,
    probe: &StreamProbe,
    range: &Range,
    store_path: &Path,
    watch: &dyn Watch,
) -> Result<ReadFrames, ClipError> {
    let path = decoder.path().to_owned();
    let Some(mut next) = decoder.next_frame(watch)? else {
        return Err(no_frames(decoder));
    };
    let time_base = decoder.time_base();
    let tick = f64::from(time_base.0) / f64::from(time_base.1);
    let nominal = probe.average_rate.or(decoder.nominal_rate()).or(probe.nominal_rate);
    let mut timing = Timing::new(time_base, nominal);
    let mut writer = FrameStoreWriter::create(store_path, next.picture.size()).map_err(store_failed)?;
    let mut resampler: Option<Resampler> = None;
    let mut pending: Option<Rgb8> = None;
    loop {
        let time = timing.push(next.pts);
        let seconds = time.ticks as f64 * tick;
        if seconds + TYPED >= range.end {
            break;
        }
        if seconds + TYPED >= range.start {
            let resampler = resampler.get_or_insert_with(|| Resampler::new(time_base, time.ticks));
            check_length(&path, resampler.rows_until(time.ticks))?;
            if resampler.push(time).store_previous
                && let Some(frame) = &pending
            {
                writer.push(frame).map_err(store_failed)?;
            }
            pending = Some(next.picture);
            watch.advance(resampler.row_count(), expected_rows(probe, range));
        }
        match decoder.next_frame(watch)? {
            Some(frame) => next = frame,
            None => break,
        }
    }
    let seconds = (timing.last() + timing.last_duration()) as f64 * tick;
    let (Some(resampler), Some(last)) = (resampler, pending) else {
        return Err(ClipError::EmptyRange { path, start: range.start, end: range.end, duration: seconds });
    };
    let (decision, rows) = resampler.finish(timing.last_duration());
    if decision.store_previous {
        writer.push(&last).map_err(store_failed)?;
    }
    let store = writer.finish().map_err(store_failed)?;
    let source_fps = f64::from(timing.count()) / seconds.max(tick);
    Ok(ReadFrames { rows, store, timing, seconds, source_fps })
}

fn check_length(path: &Path, found: u64) -> Result<(), ClipError> {
    let limit = MAX_FRAMES as u64;
    if found <= limit {
        return Ok(());
    }
    Err(ClipError::TooLarge { path: path.into(), what: "frames at 30 FPS", found, limit })
}

fn expected_rows(probe: &StreamProbe, range: &Range) -> usize {
    let end = range.end.min(probe.duration.unwrap_or(0.0));
    ((end - range.start).max(0.0) * 30.0).round() as usize
}

fn no_frames(decoder: &Decoder) -> ClipError {
    let reason = decoder.errors().1.first().map_or(String::new(), |message| format!(": {message}"));
    ClipError::NoFrames { path: decoder.path().into(), reason }
}

fn store_failed(error: StoreError) -> ClipError {
    match error {
        StoreError::Io { path, doing, source } => ClipError::Io { path, doing, source },
        StoreError::Torn { ref path, .. } | StoreError::WrongSize { ref path, .. } => ClipError::Io {
            path: path.clone(),
            doing: "keeping frames",
            source: std::io::Error::other(error.to_string()),
        },
    }
}

fn flags(
    timing: &Timing,
    decoder: &Decoder,
    probe: &StreamProbe,
    request: &ClipRequest,
    seconds: f64,
    cut_short: bool,
) -> Vec<ClipFlag> {
    let mut flags = timing.flags();
    let frame = seconds / f64::from(timing.count().max(1));
    let short_of = |stated: f64| seconds + 1.5 * frame < stated;
    if !cut_short && (probe.duration.is_some_and(short_of) || decoder.broken_off()) {
        flags.push(ClipFlag::Truncated);
    }
    if decoder.errors().0 > 0 {
        flags.push(ClipFlag::Damaged);
    }
    if request.camera == CameraSpec::Unknown {
        flags.push(ClipFlag::DefaultIntrinsics);
    }
    if (decoder.pixel_aspect() - 1.0).abs() > 1e-3 {
        flags.push(ClipFlag::NonSquarePixels);
    }
    flags.sort_unstable();
    flags.dedup();
    flags
}

/// BLAKE3 of the file at `path`, hexadecimal.
///
/// # Errors
/// When the file cannot be read or `watch` cancels.
pub fn content_hash(path: &Path, watch: &dyn Watch) -> Result<String, ClipError> {
    let failed = |source| ClipError::Io { path: path.into(), doing: "reading", source };
    check_readable(path)?;
    let mut file = File::open(path).map_err(failed)?;
    let mut hasher = blake3::Hasher::new();
    let mut chunk = vec![0; 1 << 18];
    loop {
        watch.check()?;
        let count = file.read(&mut chunk).map_err(failed)?;
        if count == 0 {
            return Ok(hasher.finalize().to_hex().to_string());
        }
        hasher.update(&chunk[..count]);
    }
}
